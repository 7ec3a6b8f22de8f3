//! Points inserted one by one.

use super::cells::{Bounds, Cell};
use super::dimension::{Dimension, Lifted};
use super::locate::Place;
use super::{Delaunay, DelaunayError, cavity, links};

/// The cells so far, and the buffers of an insertion.
#[derive(Clone, Debug, Default)]
pub(super) struct Triangulation<const D: usize, const N: usize> {
    pub(super) points: Vec<[f64; D]>,
    /// Insertion order.
    pub(super) order: Vec<u32>,
    /// Sort keys of the insertion order.
    pub(super) keys: Vec<u64>,
    /// The points about the middle of their box with `‖p‖²`; last the vertex at infinity.
    pub(super) lifted: Vec<Lifted<N>>,
    pub(super) cells: Vec<Cell<N>>,
    /// Cells that are part of nothing and may be used again.
    pub(super) free: Vec<u32>,
    /// The cell made last: where the next walk starts.
    pub(super) last: u32,
    /// Number of the insertion under way, from 1; marks of earlier ones are stale.
    pub(super) round: u32,
    /// What separates a sign the filter is sure of from one it is not; see [`Bounds`].
    pub(super) bounds: Bounds,
    pub(super) cavity: Vec<u32>,
    pub(super) boundary: Vec<cavity::Facet<D, N>>,
    pub(super) links: links::Links<D, N>,
}

impl<const D: usize, const N: usize> Triangulation<D, N>
where
    Self: Dimension<D, N>,
{
    /// As [`super::delaunay()`], in as many dimensions.
    pub(super) fn run(
        &mut self,
        points: impl ExactSizeIterator<Item = [f64; D]>,
    ) -> Result<Delaunay<N>, DelaunayError> {
        self.prepare(points)?;
        let simplex = self.simplex()?;
        self.start(simplex);
        let mut duplicates = Vec::new();
        for k in 0..self.order.len() {
            let point = self.order[k];
            if simplex.contains(&point) {
                continue;
            }
            match self.locate(point) {
                Place::Conflict(cell) => self.insert(point, cell),
                Place::Vertex(kept) => duplicates.push([point as usize, kept as usize]),
            }
        }
        duplicates.sort_unstable();
        let infinity = self.infinity();
        let simplices = (self.cells.iter())
            .filter(|cell| cell.vertices.iter().all(|&v| v < infinity))
            .map(|cell| cell.vertices)
            .collect();
        Ok(Delaunay { simplices, duplicates })
    }
}
