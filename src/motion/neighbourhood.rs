//! A place of the latent space → the poses around it, and how much each of them counts.
//!
//! The poses are the corners of the simplex that holds the place, its `k` nearest, or both
//! (Gauch & Peters III-C and V-A). A pose at distance `D` counts `1/D²`, the sum being 1; a place
//! where a pose is gets that pose. Outside the hull there is no simplex, and the `k` nearest stand
//! in.

use super::complex::{Complex, Place};
use super::nearest::{Near, Nearest};
use super::{MotionError, Rows};

/// Which poses are around a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Neighbourhood {
    /// The `k` nearest.
    Knn,
    /// The corners of the simplex that holds the place.
    Delaunay,
    /// Both together.
    KDelaunay,
}

impl Neighbourhood {
    /// All of them, in the order tables show them.
    pub const ALL: [Self; 3] = [Self::Knn, Self::Delaunay, Self::KDelaunay];

    /// The name in tables, files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Knn => "knn",
            Self::Delaunay => "delaunay",
            Self::KDelaunay => "k_delaunay",
        }
    }

    /// Whether it has simplices.
    pub fn has_simplices(self) -> bool {
        self != Self::Knn
    }
}

/// A pose around a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Neighbour {
    /// The pose's row.
    pub pose: u32,
    /// How much it counts: the sum over a place's neighbours is 1.
    pub weight: f64,
}

/// The poses around a place, and what the search for them keeps.
///
/// May be dropped at any time; a new one only makes the next search longer.
#[derive(Debug, Clone, Default)]
pub struct Around {
    neighbours: Vec<Neighbour>,
    outside: bool,
    near: Vec<Near>,
    /// Where the last walk ended.
    simplex: u32,
}

impl Around {
    /// The poses, nearest first where they are the nearest; empty only around a place that is not
    /// finite.
    pub fn neighbours(&self) -> &[Neighbour] {
        &self.neighbours
    }

    /// Whether the place lies outside the hull, so that the nearest poses stood in for a simplex.
    pub fn is_outside(&self) -> bool {
        self.outside
    }
}

/// Latent points, ready to be asked for neighbours; immutable.
///
/// ```
/// use handover_mesh::motion::{Neighbourhood, Neighbours, Rows};
/// let corners = Rows::new(2, vec![0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 9.0, 9.0])?;
/// let neighbours = Neighbours::new(corners, Neighbourhood::Delaunay, 2)?;
/// let mut around = neighbours.around();
/// neighbours.find(&[0.2, 0.2], &mut around);
/// let total: f64 = around.neighbours().iter().map(|neighbour| neighbour.weight).sum();
/// assert!((total - 1.0).abs() < 1e-12 && around.neighbours().len() == 3);
/// # Ok::<(), handover_mesh::motion::MotionError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Neighbours {
    points: Rows,
    nearest: Nearest,
    complex: Option<Complex>,
    /// The points at each duplicated corner's place: `[corner, other]`, ascending.
    copies: Vec<[u32; 2]>,
    neighbourhood: Neighbourhood,
    k: usize,
}

impl Neighbours {
    /// Lays the points out, and triangulates them where the neighbourhood has simplices.
    ///
    /// - `k`: how many nearest points are neighbours; at least 1.
    ///
    /// # Errors
    /// [`MotionError::Dimensions`], [`MotionError::Delaunay`] of neighbourhoods with simplices.
    pub fn new(points: Rows, neighbourhood: Neighbourhood, k: usize) -> Result<Self, MotionError> {
        let complex = match neighbourhood {
            Neighbourhood::Knn => None,
            Neighbourhood::Delaunay | Neighbourhood::KDelaunay => Some(Complex::new(&points)?),
        };
        let duplicates = complex.iter().flat_map(Complex::duplicates);
        let mut copies: Vec<[u32; 2]> =
            duplicates.map(|[dropped, kept]| [*kept as u32, *dropped as u32]).collect();
        copies.sort_unstable();
        let nearest = Nearest::new(&points);
        let k = k.min(points.len());
        Ok(Self { points, nearest, complex, copies, neighbourhood, k })
    }

    /// The points.
    pub fn points(&self) -> &Rows {
        &self.points
    }

    /// The triangulation, where the neighbourhood has simplices.
    pub fn complex(&self) -> Option<&Complex> {
        self.complex.as_ref()
    }

    /// The nearest points, whatever the neighbourhood: see [`Nearest::nearest`].
    pub(super) fn nearest(&self, place: &[f64], k: usize, found: &mut Vec<Near>) {
        self.nearest.nearest(place, k, found);
    }

    /// How many nearest points are neighbours, of as many as there are.
    pub(super) fn k(&self) -> usize {
        self.k
    }

    /// Which of them are around a place.
    pub fn neighbourhood(&self) -> Neighbourhood {
        self.neighbourhood
    }

    /// Room for any search, so that none allocates.
    pub fn around(&self) -> Around {
        let corners = self.complex.as_ref().map_or(0, |complex| complex.dimensions() + 1);
        let most = self.k + corners + self.copies.len();
        Around {
            neighbours: Vec::with_capacity(most),
            near: Vec::with_capacity(most),
            ..Around::default()
        }
    }

    /// Finds the points around a place, and how much each counts.
    ///
    /// Without allocation if `around` is from [`Self::around`].
    ///
    /// # Panics
    /// If `place` has other dimensions than the points: the caller's bug.
    pub fn find(&self, place: &[f64], around: &mut Around) {
        around.neighbours.clear();
        around.near.clear();
        around.outside = false;
        if !place.iter().all(|value| value.is_finite()) {
            return;
        }
        let inside = self.complex.as_ref().map(|complex| {
            let start = if (around.simplex as usize) < complex.len() { around.simplex } else { 0 };
            let found = complex.locate(place, start);
            around.simplex = found.simplex();
            found
        });
        around.outside = inside.is_some_and(|place| !place.is_inside());
        if self.neighbourhood != Neighbourhood::Delaunay || around.outside {
            self.nearest.nearest(place, self.k, &mut around.near);
        }
        if let (Some(complex), Some(Place::Inside(simplex))) = (&self.complex, inside) {
            self.add_corners(complex.corners(simplex), place, &mut around.near);
        }
        weigh(&around.near, &mut around.neighbours);
    }

    /// Edges between corners, and between all other poses at the places of their ends.
    pub(super) fn with_copies(&self, edges: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
        if self.copies.is_empty() {
            return edges;
        }
        let all = |[i, j]: [u32; 2]| {
            let ends = self.at_place(i).flat_map(move |i| self.at_place(j).map(move |j| [i, j]));
            ends.collect::<Vec<_>>()
        };
        edges.into_iter().flat_map(all).collect()
    }

    /// The poses at a corner's place.
    fn at_place(&self, corner: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.copies.partition_point(|copy| copy[0] < corner);
        let copies = self.copies[first..].iter().take_while(move |copy| copy[0] == corner);
        copies.map(|copy| copy[1]).chain([corner])
    }

    /// Adds corners, with the other poses at their places, that are not yet there.
    fn add_corners(&self, corners: &[u32], place: &[f64], near: &mut Vec<Near>) {
        for &corner in corners {
            for point in self.at_place(corner) {
                if near.iter().all(|known| known.point != point) {
                    let at = self.points.row(point as usize);
                    let squared_distance =
                        at.iter().zip(place).map(|(a, b)| (a - b) * (a - b)).sum();
                    near.push(Near { squared_distance, point });
                }
            }
        }
    }
}

/// Weights `1/D²`, normalised; poses at the place itself share all.
fn weigh(near: &[Near], neighbours: &mut Vec<Neighbour>) {
    let least = near.iter().map(|near| near.squared_distance).fold(f64::INFINITY, f64::min);
    // Relative to the nearest, so that no distance is too small or too large to be divided by.
    let weight = |near: &Near| {
        if near.squared_distance == least { 1.0 } else { least / near.squared_distance }
    };
    let total: f64 = near.iter().map(weight).sum();
    let of = |near: &Near| Neighbour { pose: near.point, weight: weight(near) / total };
    neighbours.extend(near.iter().map(of));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weights(squares: &[f64]) -> Vec<f64> {
        let near =
            (0..).zip(squares).map(|(point, &squared_distance)| Near { squared_distance, point });
        let mut neighbours = Vec::new();
        weigh(&near.collect::<Vec<_>>(), &mut neighbours);
        neighbours.iter().map(|neighbour| neighbour.weight).collect()
    }

    #[test]
    fn weights_are_inverse_squares_and_a_pose_on_the_place_takes_all() {
        assert_eq!(weights(&[1.0, 4.0]), [0.8, 0.2]);
        assert_eq!(weights(&[2.0, 0.0, 0.0]), [0.0, 0.5, 0.5]);
        assert_eq!(weights(&[1e-320, 1e-320, 1e96]), [0.5, 0.5, 0.0]);
        assert_eq!(weights(&[]), [0.0; 0]);
    }
}
