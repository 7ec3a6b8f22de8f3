//! Which points are nearest: exact, in any number of dimensions, without allocation.
//!
//! All points are looked at, a block at a time. A k-d tree answers sooner (`benches/motion.rs` has
//! one beside it): for the 1,700 poses of a motion model six times as fast in two dimensions and
//! 1.4 times in eight, for 20,000 poses far more; but it would allocate at every query and wants
//! its dimensions known when the program is built.

use super::Rows;

/// A point and its squared distance from the place asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Near {
    /// The squared distance, in the square of the points' unit.
    pub squared_distance: f64,
    /// The point's row.
    pub point: u32,
}

/// Points, column by column.
#[derive(Debug, Clone, PartialEq)]
pub struct Nearest {
    columns: Vec<f64>,
    dimensions: usize,
    count: usize,
}

/// Points whose distances are computed together.
const BLOCK: usize = 64;

impl Nearest {
    /// Lays the points out for queries.
    pub fn new(points: &Rows) -> Self {
        let (count, dimensions) = (points.len(), points.width());
        let column = |axis: usize| points.iter().map(move |point| point[axis]);
        Self { columns: (0..dimensions).flat_map(column).collect(), dimensions, count }
    }

    /// The `k` points nearest to a place, nearest first; of equally near ones the first.
    ///
    /// - `found`: overwritten; fewer than `k` where there are not as many points, none where
    ///   `place` is not finite.
    ///
    /// Allocates nothing if `found` has room for `k`.
    /// # Panics
    /// If `place` has other dimensions than the points: the caller's bug.
    /// # Cost
    /// `O(points · dimensions)`.
    pub fn nearest(&self, place: &[f64], k: usize, found: &mut Vec<Near>) {
        assert_eq!(place.len(), self.dimensions, "one number per dimension");
        found.clear();
        if k == 0 || !place.iter().all(|value| value.is_finite()) {
            return;
        }
        let mut farthest = f64::INFINITY;
        let mut squares = [0.0; BLOCK];
        for start in (0..self.count).step_by(BLOCK) {
            let squares = &mut squares[..BLOCK.min(self.count - start)];
            self.squared_distances(place, start, squares);
            for (point, &squared_distance) in (start as u32..).zip(&*squares) {
                if squared_distance < farthest || found.len() < k {
                    insert(found, k, Near { squared_distance, point });
                    if found.len() == k {
                        farthest = found[k - 1].squared_distance;
                    }
                }
            }
        }
    }

    fn squared_distances(&self, place: &[f64], start: usize, squares: &mut [f64]) {
        squares.fill(0.0);
        for (column, at) in self.columns.chunks_exact(self.count).zip(place) {
            let column = &column[start..][..squares.len()];
            for (square, value) in squares.iter_mut().zip(column) {
                *square += (value - at) * (value - at);
            }
        }
    }
}

/// Keeps the `k` nearest, nearest first.
fn insert(found: &mut Vec<Near>, k: usize, near: Near) {
    // Later points come after equally near ones.
    let at = found.partition_point(|known| known.squared_distance <= near.squared_distance);
    if found.len() == k {
        found.pop();
    }
    found.insert(at, near);
}
