//! Delaunay tetrahedra of points in space: positions `[m]` → tetrahedra and edges (indices).
//!
//! A tetrahedron belongs to the result when no point lies strictly inside its circumsphere.
//! Points are inserted one by one: the tetrahedra whose circumsphere holds the new point form a
//! star-shaped cavity, which is emptied and joined to the point (Bowyer 1981, Watson 1981). A
//! vertex at infinity makes the outside of the hull a set of tetrahedra like any other. Signs are
//! exact (Shewchuk 1997), and a point *on* a sphere counts as outside, as if each later point were
//! lifted infinitesimally off the paraboloid (the perturbation of Devillers & Teillaud 2011), so
//! symmetric and cospherical sets keep every vertex and yield no flat tetrahedron.
//!
//! Deliberately not done: other dimensions, removal of points, constraints, weights.
//!
//! # Why ties are safe
//! "On the sphere is outside" is the regular triangulation of heights `‖p‖² + ε_k`, where the k-th
//! inserted point has `0 < ε₁ ≪ ε₂ ≪ …` infinitesimal: an insertion then sees a strict sign
//! everywhere, and conflict regions of regular triangulations are connected and star-shaped. The
//! perturbation cannot hide a vertex, as a point is strictly inside the sphere of any tetrahedron
//! whose vertices it is none of but which contains it. It cannot make a flat one either: let the
//! new point lie in the plane of a face of a tetrahedron in conflict. Every sphere through the face
//! cuts that plane in the face's circle, which the point is strictly inside of; so it is strictly
//! inside the sphere of the tetrahedron beyond the face too, and the face is not on the cavity's
//! boundary. For the face of a hull the same holds by the rule for infinite tetrahedra: in conflict
//! if the point is strictly beyond the face's plane, or in it and strictly inside its circle.

use crate::geometry::Point;

mod cavity;
mod cells;
mod input;
mod locate;
mod predicates;

use cells::{Cell, Lifted};

/// The Delaunay tetrahedra of a set of points.
///
/// # Example
/// ```
/// use handover_mesh::{Point, delaunay::delaunay};
///
/// let corners = [
///     Point::new(0.0, 0.0, 0.0),
///     Point::new(1.0, 0.0, 0.0),
///     Point::new(0.0, 1.0, 0.0),
///     Point::new(0.0, 0.0, 1.0),
///     Point::new(0.0, 1.0, 0.0),
/// ];
/// let mesh = delaunay(&corners)?;
/// assert_eq!(mesh.tetrahedra().len(), 1);
/// assert_eq!(mesh.edges().len(), 6);
/// assert_eq!(mesh.duplicates(), [[4, 2]]);
/// # Ok::<(), handover_mesh::delaunay::DelaunayError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Delaunay {
    tetrahedra: Vec<[u32; 4]>,
    duplicates: Vec<[usize; 2]>,
}

/// Why a set of points has no Delaunay tetrahedra, or none that can be computed exactly.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DelaunayError {
    /// A coordinate is NaN or infinite.
    #[error("point {point} is not finite")]
    NotFinite {
        /// Its index.
        point: usize,
    },
    /// A coordinate is neither zero nor of a size [`MAGNITUDES`] allows.
    #[error(
        "point {point} has the coordinate {value:e}, neither 0 nor of size {:e} to {:e}",
        MAGNITUDES[0],
        MAGNITUDES[1]
    )]
    OutOfRange {
        /// Its index.
        point: usize,
        /// The coordinate `[m]`.
        value: f64,
    },
    /// Fewer than four points.
    #[error("{points} points span no volume, 4 are needed")]
    TooFew {
        /// How many there are.
        points: usize,
    },
    /// More points than [`MAX_POINTS`].
    #[error("{points} points, at most {MAX_POINTS} are taken")]
    TooMany {
        /// How many there are.
        points: usize,
    },
    /// All points lie, exactly, in one plane, on one line or in one place.
    #[error("the {points} points span no volume: all {}", .span.describe())]
    Flat {
        /// How many there are.
        points: usize,
        /// What they do span.
        span: Span,
    },
}

/// What points without volume span.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Span {
    /// All coincide.
    Point,
    /// All are collinear.
    Line,
    /// All are coplanar.
    Plane,
}

impl Span {
    fn describe(self) -> &'static str {
        match self {
            Span::Point => "coincide",
            Span::Line => "are collinear",
            Span::Plane => "are coplanar",
        }
    }
}

/// Sizes `[m]` a coordinate other than zero may have: 2⁻¹⁶⁰ to 2¹⁶⁰, about 7e-49 to 1e48.
///
/// The predicates are polynomials of degree up to 5. A double of size ≥ 2⁻¹⁶⁰ is a multiple of
/// 2⁻²¹², so every number met on the way is a multiple of 2⁻¹⁰⁶⁰ and none underflows (the smallest
/// double is 2⁻¹⁰⁷⁴); with sizes ≤ 2¹⁶⁰ none exceeds 2⁸⁵⁰, whatever the differences are.
pub const MAGNITUDES: [f64; 2] = [power_of_two(-160), power_of_two(160)];

/// The most points one call takes.
pub const MAX_POINTS: usize = (1 << 26) - 2;

const fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// Finds the Delaunay tetrahedra of `points` `[m]`.
///
/// Every distinct point becomes a vertex; of equal points the first is kept and the others are
/// reported by [`Delaunay::duplicates`]. Where more than four points lie on an empty sphere several
/// answers are right and one is chosen; the same input always gives the same output.
///
/// # Errors
/// See [`DelaunayError`].
/// # Cost
/// Expected `O(n log n)` for points scattered in space. For repeated calls a [`Workspace`] keeps
/// the buffers.
pub fn delaunay(points: &[Point]) -> Result<Delaunay, DelaunayError> {
    Workspace::default().delaunay(points)
}

impl Delaunay {
    /// The tetrahedra `[a, b, c, d]`, indices into the points, each once, in no particular order.
    ///
    /// Positively oriented: `det(b − a, c − a, d − a) > 0`.
    pub fn tetrahedra(&self) -> &[[u32; 4]] {
        &self.tetrahedra
    }

    /// Pairs `[i, j]`, `i < j`, of points that share a tetrahedron; each once, ascending.
    pub fn edges(&self) -> Vec<[usize; 2]> {
        let mut keys = Vec::with_capacity(6 * self.tetrahedra.len());
        for &[a, b, c, d] in &self.tetrahedra {
            for [i, j] in [[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]] {
                keys.push(u64::from(i.min(j)) << 32 | u64::from(i.max(j)));
            }
        }
        keys.sort_unstable();
        keys.dedup();
        keys.iter().map(|key| [(key >> 32) as usize, (key & 0xffff_ffff) as usize]).collect()
    }

    /// Points that equal an earlier one: `[dropped, kept]`, ascending, `kept < dropped`.
    ///
    /// Only `kept` occurs in [`Delaunay::tetrahedra`] and [`Delaunay::edges`].
    pub fn duplicates(&self) -> &[[usize; 2]] {
        &self.duplicates
    }
}

/// The buffers of [`delaunay`], kept from call to call.
///
/// After a call of the same size only the result is allocated. Holds nothing a caller could see:
/// results do not depend on what was computed before.
///
/// # Example
/// ```
/// use handover_mesh::{Point, delaunay::Workspace};
///
/// let mut workspace = Workspace::default();
/// for lift in [0.1, 0.2] {
///     let mut points = vec![Point::new(0.3, 0.3, lift)];
///     for i in 0..3 {
///         let turn = 2.0 * f64::from(i);
///         points.push(Point::new(turn.cos(), turn.sin(), 0.0));
///     }
///     assert_eq!(workspace.delaunay(&points)?.tetrahedra().len(), 1);
/// }
/// # Ok::<(), handover_mesh::delaunay::DelaunayError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    /// Insertion order.
    order: Vec<u32>,
    /// Sort keys of the insertion order.
    keys: Vec<u64>,
    /// The points about the middle of their box with `‖p‖²`; last the vertex at infinity.
    lifted: Vec<Lifted>,
    cells: Vec<Cell>,
    /// Cells that are part of nothing and may be used again.
    free: Vec<u32>,
    /// The cell made last: where the next walk starts.
    last: u32,
    /// Number of the insertion under way, from 1; marks of earlier ones are stale.
    round: u32,
    /// What separates a sign the filter is sure of from one it is not; see [`cells::Bounds`].
    bounds: cells::Bounds,
    cavity: Vec<u32>,
    boundary: Vec<cavity::Facet>,
    links: cavity::Links,
}

impl Workspace {
    /// As [`delaunay()`], with the buffers of earlier calls.
    ///
    /// # Errors
    /// As [`delaunay()`].
    pub fn delaunay(&mut self, points: &[Point]) -> Result<Delaunay, DelaunayError> {
        self.prepare(points)?;
        let simplex = self.simplex(points)?;
        self.start(points, simplex);
        let mut duplicates = Vec::new();
        for k in 0..self.order.len() {
            let point = self.order[k];
            if simplex.contains(&point) {
                continue;
            }
            match self.locate(points, point) {
                locate::Place::Conflict(cell) => self.insert(points, point, cell),
                locate::Place::Vertex(kept) => duplicates.push([point as usize, kept as usize]),
            }
        }
        duplicates.sort_unstable();
        let infinity = points.len() as u32;
        let tetrahedra = (self.cells.iter())
            .filter(|cell| cell.vertices.iter().all(|&v| v < infinity))
            .map(|cell| cell.vertices)
            .collect();
        Ok(Delaunay { tetrahedra, duplicates })
    }
}

#[cfg(test)]
mod tests;
