//! What comes before the first insertion: checks, the order, the first simplex.

use super::cells::{Bounds, Cell, Plane, Side};
use super::dimension::{Dimension, lifted};
use super::hilbert::{bits, hilbert};
use super::triangulation::Triangulation;
use super::{DelaunayError, MAGNITUDES, MAX_POINTS, Span};
use std::array::from_fn;

/// Up to here the order given is as good as a sorted one.
const UNSORTED: usize = 64;

impl<const D: usize, const N: usize> Triangulation<D, N>
where
    Self: Dimension<D, N>,
{
    /// Checks the points and fills `points`, `lifted`, `bounds` and `order`.
    pub(super) fn prepare(
        &mut self,
        points: impl ExactSizeIterator<Item = [f64; D]>,
    ) -> Result<(), DelaunayError> {
        let count = points.len();
        if count > MAX_POINTS {
            return Err(DelaunayError::TooMany { points: count });
        }
        self.points.clear();
        self.points.extend(points);
        let (mut low, mut high) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
        for (point, p) in self.points.iter().enumerate() {
            for axis in 0..D {
                let value = p[axis];
                let size = value.abs();
                if !(MAGNITUDES[0]..=MAGNITUDES[1]).contains(&size) && size != 0.0 {
                    return Err(if value.is_finite() {
                        DelaunayError::OutOfRange { point, value }
                    } else {
                        DelaunayError::NotFinite { point }
                    });
                }
                low[axis] = low[axis].min(value);
                high[axis] = high[axis].max(value);
            }
        }
        if count < N {
            return Err(DelaunayError::TooFew { points: count });
        }
        let middle = from_fn(|axis| 0.5 * (low[axis] + high[axis]));
        let mut size = [0.0_f64; D];
        self.lifted.clear();
        self.lifted.extend(self.points.iter().map(|p| lifted(p, &middle, &mut size)));
        self.lifted.push([0.0; N]);
        self.bounds = Bounds::new(size);
        self.sort(size.into_iter().fold(0.0, f64::max));
        Ok(())
    }

    /// The vertex at infinity.
    pub(super) fn infinity(&self) -> u32 {
        self.points.len() as u32
    }

    /// Fills `order`: as given, or along a Hilbert curve where that saves long walks.
    ///
    /// Equal points stay in the order given, so that the first of them is the one kept.
    fn sort(&mut self, size: f64) {
        let count = self.points.len();
        self.order.clear();
        if count <= UNSORTED {
            self.order.extend(0..count as u32);
            return;
        }
        let cells = f64::from(1_u32 << bits(D));
        self.keys.clear();
        self.keys.extend(self.lifted[..count].iter().enumerate().map(|(index, p)| {
            let mut cell = [0; D];
            for axis in 0..D {
                // NOTE: float to integer casts saturate, and the top cell takes the upper rim.
                let place = (0.5 + 0.5 * (p[axis] / size)) * cells;
                cell[axis] = (place as u32).min(cells as u32 - 1);
            }
            u64::from(hilbert(cell)) << 32 | index as u64
        }));
        self.keys.sort_unstable();
        self.order.extend(self.keys.iter().map(|key| *key as u32));
    }

    /// The first points of the order that span all dimensions, positively oriented.
    pub(super) fn simplex(&self) -> Result<[u32; N], DelaunayError> {
        let mut order = self.order.iter().copied();
        let mut simplex = [order.next().ok_or(DelaunayError::TooFew { points: 0 })?; N];
        let mut corners = [&self.points[simplex[0] as usize]; N];
        for (known, span) in (1..N).zip([Span::Point, Span::Line, Span::Plane, Span::Space]) {
            simplex[known] = order
                .find(|&v| Self::independent(&corners[..known], &self.points[v as usize]))
                .ok_or(DelaunayError::Flat { points: self.points.len(), span })?;
            corners[known] = &self.points[simplex[known] as usize];
        }
        if Self::orientation(corners) < 0.0 {
            simplex.swap(0, 1);
        }
        Ok(simplex)
    }

    /// Makes the first simplex, cell 0, and the infinite ones on its facets.
    pub(super) fn start(&mut self, simplex: [u32; N]) {
        let infinity = self.infinity();
        self.cells.clear();
        self.free.clear();
        self.links.start(self.points.len());
        (self.round, self.last) = (0, 0);
        self.lifted[infinity as usize] = self.bounds.above(&self.lifted[simplex[0] as usize]);
        let mut neighbours = [Side::default(); N];
        for facet in 0..N {
            neighbours[facet] = Side::new(facet as u32 + 1, 1);
        }
        let plane = Plane::through(simplex.map(|v| &self.lifted[v as usize]));
        self.cells.push(Cell { vertices: simplex, neighbours, plane, mark: 0 });
        for (facet, others) in Self::FACETS.into_iter().enumerate() {
            // Positive with a point beyond the facet in the place of infinity.
            let mut vertices = [infinity; N];
            let mut neighbours = [Side::new(0, facet); N];
            for (place, &v) in others.iter().enumerate() {
                let place = if place == 0 { 0 } else { place + 1 };
                vertices[place] = simplex[v];
                // Opposite the facet's vertex v is the infinite cell on the facet without v, which
                // holds `facet`'s vertex in the place that its own row gives it.
                let back = Self::FACETS[v].iter().position(|&w| w == facet).unwrap_or_default();
                let back = if back == 0 { 0 } else { back + 1 };
                neighbours[place] = Side::new(v as u32 + 1, back);
            }
            let first = &self.lifted[vertices[0] as usize];
            self.lifted[infinity as usize] = self.bounds.above(first);
            let plane = Plane::through(vertices.map(|v| &self.lifted[v as usize]));
            self.cells.push(Cell { vertices, neighbours, plane, mark: 0 });
        }
    }
}
