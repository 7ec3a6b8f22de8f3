//! Latent points → the simplices of their Delaunay triangulation, and which one holds a place.
//!
//! Two latent points are neighbours if they are corners of one simplex (Gauch & Peters III-B).
//! Triangles come from `spade`, tetrahedra and their four-dimensional kin from our own code with
//! exact signs. A place is found by walking: from simplex to simplex across the facet that has the
//! place farthest beyond it, which in a Delaunay triangulation comes to an end (Edelsbrunner 1989).
//!
//! Knows no poses and no velocities.

use nalgebra::{Const, DimMin, SMatrix, ToTypenum};
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation as _};

use super::{MotionError, Rows};
use crate::delaunay::{Delaunay, DelaunayError, MAGNITUDES, Span, delaunay, delaunay_4d};
use crate::geometry::Point;

/// The simplices of latent points in 2, 3 or 4 dimensions; immutable.
///
/// ```
/// use handover_mesh::motion::{Complex, Rows};
/// let square = Rows::new(2, vec![0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.1])?;
/// let complex = Complex::new(&square)?;
/// assert_eq!((complex.len(), complex.edges().len()), (2, 5));
/// assert!(complex.locate(&[0.5, 0.2], 0).is_inside());
/// assert!(!complex.locate(&[2.0, 0.2], 0).is_inside());
/// # Ok::<(), handover_mesh::motion::MotionError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Complex {
    dimensions: usize,
    /// `dimensions + 1` points each.
    corners: Vec<u32>,
    /// Across the facet opposite each corner: a simplex, or [`BEYOND`] the hull.
    neighbours: Vec<u32>,
    /// Each simplex' first corner.
    origins: Vec<f64>,
    /// Each simplex' `place − origin` → barycentric coordinates of all corners but the first, row
    /// by row; NaN of a simplex too flat to be measured.
    inverses: Vec<f64>,
    duplicates: Vec<[usize; 2]>,
}

const BEYOND: u32 = u32::MAX;

/// How far below zero a barycentric coordinate may be by rounding.
const ROUNDING: f64 = 1e-10;

/// The volume of a simplex, relative to that of the box its edges from the first corner could span,
/// below which rounding decides on which side of it a place is.
const FLAT: f64 = 1e-10;

/// Where a walk ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// In this simplex, or on its rim.
    Inside(u32),
    /// Outside the hull; the last simplex of the walk.
    Outside(u32),
}

impl Place {
    /// Whether the hull holds the place.
    pub fn is_inside(self) -> bool {
        matches!(self, Self::Inside(_))
    }

    /// Where the next walk may start.
    pub fn simplex(self) -> u32 {
        match self {
            Self::Inside(simplex) | Self::Outside(simplex) => simplex,
        }
    }
}

impl Complex {
    /// The dimensions that have a triangulation here.
    pub const DIMENSIONS: std::ops::RangeInclusive<usize> = 2..=4;

    /// Triangulates points.
    ///
    /// # Errors
    /// [`MotionError::Dimensions`]; [`MotionError::Delaunay`] if the points span no volume.
    pub fn new(points: &Rows) -> Result<Self, MotionError> {
        match points.width() {
            2 => {
                let (triangles, duplicates) = triangles(points)?;
                Ok(Self::of::<2, 3>(points, triangles, duplicates))
            }
            3 => {
                let places: Vec<Point> =
                    points.iter().map(|p| Point::new(p[0], p[1], p[2])).collect();
                Ok(Self::of_delaunay::<3, 4>(points, &delaunay(&places)?))
            }
            4 => {
                let places: Vec<[f64; 4]> =
                    points.iter().map(|p| [p[0], p[1], p[2], p[3]]).collect();
                Ok(Self::of_delaunay::<4, 5>(points, &delaunay_4d(&places)?))
            }
            dimensions => Err(MotionError::Dimensions { dimensions }),
        }
    }

    fn of_delaunay<const D: usize, const N: usize>(points: &Rows, found: &Delaunay<N>) -> Self
    where
        Const<D>: ToTypenum + DimMin<Const<D>, Output = Const<D>>,
    {
        Self::of::<D, N>(points, found.simplices().to_vec(), found.duplicates().to_vec())
    }

    fn of<const D: usize, const N: usize>(
        points: &Rows,
        simplices: Vec<[u32; N]>,
        duplicates: Vec<[usize; 2]>,
    ) -> Self
    where
        Const<D>: ToTypenum + DimMin<Const<D>, Output = Const<D>>,
    {
        let mut inverses = Vec::with_capacity(D * D * simplices.len());
        let mut origins = Vec::with_capacity(D * simplices.len());
        for simplex in &simplices {
            let corner = |i: usize| points.row(simplex[i] as usize);
            origins.extend_from_slice(corner(0));
            let edges =
                SMatrix::<f64, D, D>::from_fn(|axis, i| corner(i + 1)[axis] - corner(0)[axis]);
            let lu = edges.lu();
            let box_volume: f64 = edges.column_iter().map(|edge| edge.norm()).product();
            let measurable = lu.determinant().abs() > FLAT * box_volume;
            let inverse = if measurable { lu.try_inverse() } else { None };
            let inverse = inverse.unwrap_or_else(|| SMatrix::repeat(f64::NAN));
            inverses
                .extend((0..D).flat_map(|row| (0..D).map(move |column| inverse[(row, column)])));
        }
        Self {
            dimensions: D,
            neighbours: neighbours(&simplices),
            corners: simplices.into_flattened(),
            origins,
            inverses,
            duplicates,
        }
    }

    /// The number of simplices.
    #[expect(clippy::len_without_is_empty, reason = "a triangulation has a simplex")]
    pub fn len(&self) -> usize {
        self.corners.len() / (self.dimensions + 1)
    }

    /// The number of dimensions, one less than the corners of a simplex.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// The corners of a simplex: indices of points.
    ///
    /// # Panics
    /// If there is no such simplex: the caller's bug.
    pub fn corners(&self, simplex: u32) -> &[u32] {
        let count = self.dimensions + 1;
        &self.corners[count * simplex as usize..][..count]
    }

    /// Points that equal an earlier one and so are no corner: `[dropped, kept]`, ascending.
    pub fn duplicates(&self) -> &[[usize; 2]] {
        &self.duplicates
    }

    /// Pairs `[i, j]`, `i < j`, of points that share a simplex; each once, ascending.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::new();
        for corners in self.corners.chunks_exact(self.dimensions + 1) {
            for (at, &i) in corners.iter().enumerate() {
                edges.extend(corners[..at].iter().map(|&j| [i.min(j), i.max(j)]));
            }
        }
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// Walks to the simplex that holds a place.
    ///
    /// - `place`: finite.
    /// - `start`: any simplex; the nearer, the shorter the walk.
    ///
    /// # Panics
    /// If `place` has other dimensions, or there is no simplex `start`: the caller's bug.
    /// # Cost
    /// About `len^(1/dimensions)` steps from afar; `2 len` at most, where simplices are almost
    /// flat. No allocation.
    pub fn locate(&self, place: &[f64], start: u32) -> Place {
        assert_eq!(place.len(), self.dimensions, "one number per dimension");
        assert!((start as usize) < self.len(), "no simplex {start}");
        match self.dimensions {
            2 => self.walk::<2, 3>(place, start),
            3 => self.walk::<3, 4>(place, start),
            _ => self.walk::<4, 5>(place, start),
        }
    }

    fn walk<const D: usize, const N: usize>(&self, place: &[f64], start: u32) -> Place {
        let mut simplex = start;
        for _ in 0..self.len() {
            let (facet, least) = least(&self.barycentric::<D, N>(place, simplex));
            if least.is_nan() {
                break;
            }
            if least >= -ROUNDING {
                return Place::Inside(simplex);
            }
            let next = self.neighbours[N * simplex as usize + facet];
            if next == BEYOND {
                return Place::Outside(simplex);
            }
            simplex = next;
        }
        // Where simplices are almost flat, rounding may send a walk round in a circle.
        self.search::<D, N>(place, start)
    }

    /// Tries all simplices.
    #[cold]
    fn search<const D: usize, const N: usize>(&self, place: &[f64], start: u32) -> Place {
        let mut best = (f64::NEG_INFINITY, start);
        for simplex in 0..self.len() as u32 {
            let (_, least) = least(&self.barycentric::<D, N>(place, simplex));
            if least > best.0 {
                best = (least, simplex);
            }
        }
        if best.0 >= -ROUNDING.sqrt() { Place::Inside(best.1) } else { Place::Outside(best.1) }
    }

    /// How the corners of a simplex mix to make a place: sums to 1, none negative inside.
    #[inline]
    fn barycentric<const D: usize, const N: usize>(&self, place: &[f64], simplex: u32) -> [f64; N] {
        let simplex = simplex as usize;
        let origin = &self.origins[D * simplex..][..D];
        let inverse = &self.inverses[D * D * simplex..][..D * D];
        let mut coordinates = [0.0; N];
        let mut first = 1.0;
        for row in 0..D {
            let mut sum = 0.0;
            for column in 0..D {
                sum += inverse[D * row + column] * (place[column] - origin[column]);
            }
            coordinates[row + 1] = sum;
            first -= sum;
        }
        coordinates[0] = first;
        coordinates
    }
}

/// Where the least coordinate is, and what it is; NaN if all are.
#[inline]
fn least<const N: usize>(coordinates: &[f64; N]) -> (usize, f64) {
    let mut least = (0, coordinates[0]);
    for (at, &value) in coordinates.iter().enumerate().skip(1) {
        if value < least.1 {
            least = (at, value);
        }
    }
    least
}

/// A latent point of the plane and its row.
struct Corner {
    position: Point2<f64>,
    point: u32,
}

impl HasPosition for Corner {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.position
    }
}

/// `spade` takes sizes from 2⁻¹⁴² to 2²⁰¹: this brings ours, [`MAGNITUDES`], into that range.
const INTO_RANGE: f64 = (1 << 20) as f64;

/// Triangles of corners, and the points that are none: `[dropped, kept]`.
type Triangles = (Vec<[u32; 3]>, Vec<[usize; 2]>);

/// The Delaunay triangles of points in the plane.
fn triangles(points: &Rows) -> Result<Triangles, DelaunayError> {
    // Zeros of both signs are one place.
    let key = |point: usize| [0, 1].map(|axis| points.row(point)[axis] + 0.0);
    let mut order: Vec<usize> = (0..points.len()).collect();
    for &point in &order {
        let bad = |value: &&f64| {
            **value != 0.0 && !(MAGNITUDES[0]..=MAGNITUDES[1]).contains(&value.abs())
        };
        if let Some(&value) = points.row(point).iter().find(bad) {
            return Err(DelaunayError::OutOfRange { point, value });
        }
    }
    order.sort_by(|a, b| {
        let ([ax, ay], [bx, by]) = (key(*a), key(*b));
        ax.total_cmp(&bx).then(ay.total_cmp(&by))
    });
    let (mut corners, mut duplicates) = (Vec::new(), Vec::new());
    for same in order.chunk_by(|a, b| key(*a) == key(*b)) {
        let [x, y] = key(same[0]);
        let position = Point2::new(INTO_RANGE * x, INTO_RANGE * y);
        corners.push(Corner { position, point: same[0] as u32 });
        duplicates.extend(same[1..].iter().map(|dropped| [*dropped, same[0]]));
    }
    duplicates.sort_unstable();
    let span = if corners.len() == 1 { Span::Point } else { Span::Line };
    let flat = DelaunayError::Flat { points: points.len(), span };
    if points.len() < 3 {
        return Err(DelaunayError::TooFew { points: points.len() });
    }
    // NOTE: it refuses coordinates out of its range, and no others.
    let Ok(found) = DelaunayTriangulation::<Corner>::bulk_load(corners) else { return Err(flat) };
    let triangles: Vec<[u32; 3]> =
        found.inner_faces().map(|face| face.vertices().map(|vertex| vertex.data().point)).collect();
    if triangles.is_empty() { Err(flat) } else { Ok((triangles, duplicates)) }
}

/// Across the facet opposite each corner, simplex after simplex: facets of two simplices are found
/// by their corners.
fn neighbours<const N: usize>(simplices: &[[u32; N]]) -> Vec<u32> {
    // At most four corners of 32 bits each.
    let mut facets: Vec<(u128, u32)> = Vec::with_capacity(N * simplices.len());
    for (simplex, corners) in simplices.iter().enumerate() {
        for opposite in 0..N {
            let mut facet = *corners;
            facet.swap(opposite, N - 1);
            let facet = &mut facet[..N - 1];
            facet.sort_unstable();
            let key = facet.iter().fold(0, |key, corner| key << 32 | u128::from(*corner));
            facets.push((key, (N * simplex + opposite) as u32));
        }
    }
    facets.sort_unstable();
    let mut neighbours = vec![BEYOND; facets.len()];
    for pair in facets.windows(2) {
        let [(a, one), (b, other)] = [pair[0], pair[1]];
        if a == b {
            neighbours[one as usize] = other / N as u32;
            neighbours[other as usize] = one / N as u32;
        }
    }
    neighbours
}
