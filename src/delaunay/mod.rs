//! Delaunay simplices of points in three or four dimensions: positions → simplices and edges
//! (indices).
//!
//! A simplex (a tetrahedron in three dimensions) belongs to the result when no point lies strictly
//! inside its circumsphere. Points are inserted one by one: the simplices whose circumsphere holds
//! the new point form a star-shaped cavity, which is emptied and joined to the point (Bowyer 1981,
//! Watson 1981). A vertex at infinity makes the outside of the hull a set of simplices like any
//! other. Signs are exact (Shewchuk 1997 in three dimensions, whole numbers in four), and a point
//! *on* a sphere counts as outside, as if each later point were lifted infinitesimally off the
//! paraboloid (the perturbation of Devillers & Teillaud 2011), so symmetric and cospherical sets
//! keep every vertex and yield no flat simplex.
//!
//! Deliberately not done: other dimensions (two are planar graphs, for which crates serve; from
//! five on simplices are too many), removal of points, constraints, weights.
//!
//! # Why ties are safe
//! "On the sphere is outside" is the regular triangulation of heights `‖p‖² + ε_k`, where the k-th
//! inserted point has `0 < ε₁ ≪ ε₂ ≪ …` infinitesimal: an insertion then sees a strict sign
//! everywhere, and conflict regions of regular triangulations are connected and star-shaped. The
//! perturbation cannot hide a vertex, as a point is strictly inside the sphere of any simplex whose
//! vertices it is none of but which contains it. It cannot make a flat one either: let the new
//! point lie in the hyperplane of a facet of a simplex in conflict. Every sphere through the facet
//! cuts that hyperplane in the facet's own sphere, one dimension lower, which the point is strictly
//! inside of; so it is strictly inside the sphere of the simplex beyond the facet too, and the
//! facet is not on the cavity's boundary. For a facet of the hull the same holds by the rule for
//! infinite simplices: in conflict if the point is strictly beyond the facet's hyperplane, or in it
//! and strictly inside the facet's sphere.

use crate::geometry::Point;

mod cavity;
mod cells;
mod dimension;
mod four;
mod hilbert;
mod input;
mod links;
mod locate;
mod three;
mod triangulation;

use triangulation::Triangulation;

/// The Delaunay simplices of a set of points: tetrahedra (`N = 4`), or the simplices of five
/// corners in four dimensions (`N = 5`).
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
pub struct Delaunay<const N: usize = 4> {
    simplices: Vec<[u32; N]>,
    duplicates: Vec<[usize; 2]>,
}

/// Why a set of points has no Delaunay simplices, or none that can be computed exactly.
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
        /// The coordinate.
        value: f64,
    },
    /// Fewer points than a simplex has corners.
    #[error("{points} points are too few: 3 are needed in two dimensions, 4 in three, 5 in four")]
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
    /// All points lie, exactly, in one place, on one line, in one plane, or in four dimensions in
    /// one space of three.
    #[error("the {points} points span {}", .span.describe())]
    Flat {
        /// How many there are.
        points: usize,
        /// What they do span.
        span: Span,
    },
}

/// What points that have no Delaunay simplices span.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Span {
    /// All coincide.
    Point,
    /// All are collinear.
    Line,
    /// All are coplanar.
    Plane,
    /// All lie in one three-dimensional space; only in four dimensions.
    Space,
}

impl Span {
    fn describe(self) -> &'static str {
        match self {
            Span::Point => "no volume: all coincide",
            Span::Line => "no volume: all are collinear",
            Span::Plane => "no volume: all are coplanar",
            Span::Space => "three dimensions of four: all lie in one three-dimensional space",
        }
    }
}

/// Sizes a coordinate other than zero may have: 2⁻¹⁶⁰ to 2¹⁶⁰, about 7e-49 to 1e48.
///
/// In three dimensions the predicates are polynomials of degree up to 5. A double of size ≥ 2⁻¹⁶⁰ is a multiple of
/// 2⁻²¹², so every number met on the way is a multiple of 2⁻¹⁰⁶⁰ and none underflows (the smallest
/// double is 2⁻¹⁰⁷⁴); with sizes ≤ 2¹⁶⁰ none exceeds 2⁸⁵⁰, whatever the differences are.
/// In four dimensions exact numbers are whole ones of any size, and the rounded ones stay below 2⁹⁷⁵.
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

/// Finds the Delaunay simplices of `points` in four dimensions: five corners each, axes in one unit.
///
/// Otherwise as [`delaunay()`].
///
/// # Example
/// ```
/// use handover_mesh::delaunay::delaunay_4d;
///
/// let mut corners = vec![[0.0; 4]];
/// for axis in 0..4 {
///     let mut corner = [0.0; 4];
///     corner[axis] = 1.0;
///     corners.push(corner);
/// }
/// corners.push([1.0; 4]);
/// let found = delaunay_4d(&corners)?;
/// assert_eq!(found.simplices().len(), 2);
/// assert_eq!(found.edges().len(), 14);
/// # Ok::<(), handover_mesh::delaunay::DelaunayError>(())
/// ```
///
/// # Errors
/// See [`DelaunayError`].
/// # Cost
/// Simplices are many: about 27 for each of 1,700 scattered points, 58 where they follow a path.
pub fn delaunay_4d(points: &[[f64; 4]]) -> Result<Delaunay<5>, DelaunayError> {
    Workspace::default().delaunay_4d(points)
}

impl Delaunay {
    /// [`Delaunay::simplices`] by their name in three dimensions.
    pub fn tetrahedra(&self) -> &[[u32; 4]] {
        &self.simplices
    }
}

impl<const N: usize> Delaunay<N> {
    /// The simplices `[a, b, c, …]`, indices into the points, each once, in no particular order.
    ///
    /// Positively oriented: `det(b − a, c − a, …) > 0`.
    pub fn simplices(&self) -> &[[u32; N]] {
        &self.simplices
    }

    /// Pairs `[i, j]`, `i < j`, of points that share a simplex; each once, ascending.
    pub fn edges(&self) -> Vec<[usize; 2]> {
        let mut keys = Vec::with_capacity(N * (N - 1) / 2 * self.simplices.len());
        for simplex in &self.simplices {
            for (place, &i) in simplex.iter().enumerate() {
                for &j in &simplex[place + 1..] {
                    keys.push(u64::from(i.min(j)) << 32 | u64::from(i.max(j)));
                }
            }
        }
        keys.sort_unstable();
        keys.dedup();
        keys.iter().map(|key| [(key >> 32) as usize, (key & 0xffff_ffff) as usize]).collect()
    }

    /// Points that equal an earlier one: `[dropped, kept]`, ascending, `kept < dropped`.
    ///
    /// Only `kept` occurs in [`Delaunay::simplices`] and [`Delaunay::edges`].
    pub fn duplicates(&self) -> &[[usize; 2]] {
        &self.duplicates
    }
}

/// The buffers of [`delaunay()`] or, as `Workspace<4, 5>`, of [`delaunay_4d`], kept from call to
/// call. `D` is the number of axes, `N = D + 1` that of a simplex' corners.
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
pub struct Workspace<const D: usize = 3, const N: usize = 4>(Triangulation<D, N>);

impl Workspace {
    /// As [`delaunay()`], with the buffers of earlier calls.
    ///
    /// # Errors
    /// As [`delaunay()`].
    pub fn delaunay(&mut self, points: &[Point]) -> Result<Delaunay, DelaunayError> {
        self.0.run(points.iter().map(|p| [p.x, p.y, p.z]))
    }
}

impl Workspace<4, 5> {
    /// As [`delaunay_4d`], with the buffers of earlier calls.
    ///
    /// # Errors
    /// As [`delaunay_4d`].
    pub fn delaunay_4d(&mut self, points: &[[f64; 4]]) -> Result<Delaunay<5>, DelaunayError> {
        self.0.run(points.iter().copied())
    }
}

#[cfg(test)]
mod tests;
