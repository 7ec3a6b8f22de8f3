//! What comes before the first insertion: checks, the order, the first tetrahedron.

use super::cells::{Bounds, Cell, FACET, above, plane};
use super::predicates::{collinear, orientation};
use super::{DelaunayError, MAGNITUDES, MAX_POINTS, Span, Workspace};
use crate::geometry::Point;

/// Up to here the order given is as good as a sorted one.
const UNSORTED: usize = 64;

/// Bits per axis of the curve along which larger sets are sorted.
const CURVE_BITS: u32 = 10;

impl Workspace {
    /// Checks the points and fills `lifted`, `bounds` and `order`.
    pub(super) fn prepare(&mut self, points: &[Point]) -> Result<(), DelaunayError> {
        let count = points.len();
        if count > MAX_POINTS {
            return Err(DelaunayError::TooMany { points: count });
        }
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for (point, p) in points.iter().enumerate() {
            for axis in 0..3 {
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
        if count < 4 {
            return Err(DelaunayError::TooFew { points: count });
        }
        let middle = [0, 1, 2].map(|axis| 0.5 * (low[axis] + high[axis]));
        let mut size = [0.0_f64; 3];
        self.lifted.clear();
        self.lifted.extend(points.iter().map(|p| {
            let [x, y, z] = [p.x - middle[0], p.y - middle[1], p.z - middle[2]];
            size = [size[0].max(x.abs()), size[1].max(y.abs()), size[2].max(z.abs())];
            [x, y, z, x * x + y * y + z * z]
        }));
        self.lifted.push([0.0; 4]);
        self.bounds = Bounds::new(size);
        self.sort(size[0].max(size[1]).max(size[2]));
        Ok(())
    }

    /// Fills `order`: as given, or along a Hilbert curve where that saves long walks.
    ///
    /// Equal points stay in the order given, so that the first of them is the one kept.
    fn sort(&mut self, size: f64) {
        let count = self.lifted.len() - 1;
        self.order.clear();
        if count <= UNSORTED {
            self.order.extend(0..count as u32);
            return;
        }
        let cells = f64::from(1_u32 << CURVE_BITS);
        self.keys.clear();
        self.keys.extend(self.lifted[..count].iter().enumerate().map(|(index, p)| {
            // NOTE: float to integer casts saturate, and the top cell takes the upper rim.
            let cell = |c: f64| (((0.5 + 0.5 * (c / size)) * cells) as u32).min(cells as u32 - 1);
            u64::from(hilbert([cell(p[0]), cell(p[1]), cell(p[2])])) << 32 | index as u64
        }));
        self.keys.sort_unstable();
        self.order.extend(self.keys.iter().map(|key| *key as u32));
    }

    /// The first four points of the order that span a volume, positively oriented.
    pub(super) fn simplex(&self, points: &[Point]) -> Result<[u32; 4], DelaunayError> {
        let flat = |span| DelaunayError::Flat { points: points.len(), span };
        let at = |index: &u32| &points[*index as usize];
        let mut order = self.order.iter();
        let a = order.next().ok_or(DelaunayError::TooFew { points: 0 })?;
        let b = order.find(|p| at(p) != at(a)).ok_or(flat(Span::Point))?;
        let c = order.find(|p| !collinear(at(a), at(b), at(p))).ok_or(flat(Span::Line))?;
        let d = (order.find(|p| orientation(at(a), at(b), at(c), at(p)) != 0.0))
            .ok_or(flat(Span::Plane))?;
        if orientation(at(a), at(b), at(c), at(d)) > 0.0 {
            Ok([*a, *b, *c, *d])
        } else {
            Ok([*b, *a, *c, *d])
        }
    }

    /// Makes the first tetrahedron, cell 0, and the four infinite ones on its facets.
    pub(super) fn start(&mut self, points: &[Point], simplex: [u32; 4]) {
        let infinity = points.len() as u32;
        self.cells.clear();
        self.free.clear();
        self.links.start(points.len());
        (self.round, self.last) = (0, 0);
        let lifted = simplex.map(|v| self.lifted[v as usize]);
        self.cells.push(Cell {
            vertices: simplex,
            neighbours: [1, 2, 3, 4].map(|cell| 4 * cell + 1),
            plane: plane(&lifted[0], &lifted[1], &lifted[2], &lifted[3]),
            mark: 0,
        });
        for (facet, &[i, j, k]) in FACET.iter().enumerate() {
            // Positive with a point beyond the facet in the place of infinity.
            let vertices = [simplex[i], infinity, simplex[j], simplex[k]];
            // Opposite the facet's vertex v is the infinite cell on the facet without v, which
            // holds `facet`'s vertex in the place that its own FACET row gives it.
            let across = |v: usize| {
                let place = FACET[v].iter().position(|&w| w == facet);
                4 * (v as u32 + 1) + [0, 2, 3][place.unwrap_or_default()]
            };
            self.cells.push(Cell {
                vertices,
                neighbours: [across(i), facet as u32, across(j), across(k)],
                plane: plane(&lifted[i], &above(&lifted[i], &self.bounds), &lifted[j], &lifted[k]),
                mark: 0,
            });
        }
    }
}

/// The place of a grid cell along the Hilbert curve (Skilling 2004, transposed form).
fn hilbert(mut axes: [u32; 3]) -> u32 {
    let mut bit = 1 << (CURVE_BITS - 1);
    while bit > 1 {
        let mask = bit - 1;
        for i in 0..3 {
            if axes[i] & bit != 0 {
                axes[0] ^= mask;
            } else {
                let swap = (axes[0] ^ axes[i]) & mask;
                axes[0] ^= swap;
                axes[i] ^= swap;
            }
        }
        bit >>= 1;
    }
    axes[1] ^= axes[0];
    axes[2] ^= axes[1];
    let mut flip = 0;
    let mut bit = 1 << (CURVE_BITS - 1);
    while bit > 1 {
        if axes[2] & bit != 0 {
            flip ^= bit - 1;
        }
        bit >>= 1;
    }
    axes.iter_mut().for_each(|axis| *axis ^= flip);
    (0..CURVE_BITS)
        .rev()
        .fold(0, |key, bit| axes.iter().fold(key, |key, axis| key << 1 | axis >> bit & 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_visits_every_cell_by_steps_of_one() {
        // The first 8^3 cells of the curve fill a cube of 8 cells a side in its corner.
        let mut cells = vec![None; 512];
        for x in 0..8 {
            for y in 0..8 {
                for z in 0..8 {
                    cells[hilbert([x, y, z]) as usize] = Some([x, y, z]);
                }
            }
        }
        for pair in cells.windows(2) {
            let (a, b) = (pair[0].unwrap(), pair[1].unwrap());
            assert_eq!((0..3).map(|i| a[i].abs_diff(b[i])).sum::<u32>(), 1);
        }
    }
}
