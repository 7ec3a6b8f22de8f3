//! Which points are nearest: exact, in any number of dimensions.
//!
//! A single place is compared with all points, a block at a time, without allocation: this is for
//! a tick. The neighbours of all points at once, which a model is made with, come from a k-d tree
//! (`kiddo`) where there are few dimensions; it allocates at every query.

use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

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
            self.squared_distances(place, start, &mut squares);
            // Most blocks hold nothing near enough, which is sooner seen of a block as a whole.
            if found.len() == k && least(&squares) >= farthest {
                continue;
            }
            let here = &squares[..BLOCK.min(self.count - start)];
            for (point, &squared_distance) in (start as u32..).zip(here) {
                if squared_distance < farthest || found.len() < k {
                    insert(found, k, Near { squared_distance, point });
                    if found.len() == k {
                        farthest = found[k - 1].squared_distance;
                    }
                }
            }
        }
    }

    /// Of a whole block; infinite beyond the last point.
    fn squared_distances(&self, place: &[f64], start: usize, squares: &mut [f64; BLOCK]) {
        let end = self.count.min(start + BLOCK);
        squares.fill(0.0);
        squares[end - start..].fill(f64::INFINITY);
        for (column, at) in self.columns.chunks_exact(self.count).zip(place) {
            if let Some(column) = column[start..].first_chunk::<BLOCK>() {
                // Of a length known when the program is built, which makes it vector code.
                for (square, value) in squares.iter_mut().zip(column) {
                    *square += (value - at) * (value - at);
                }
            } else {
                for (square, value) in squares.iter_mut().zip(&column[start..end]) {
                    *square += (value - at) * (value - at);
                }
            }
        }
    }
}

/// The least of a block, four at a time.
fn least(squares: &[f64; BLOCK]) -> f64 {
    let mut least = [f64::INFINITY; 4];
    for four in squares.chunks_exact(4) {
        for (least, square) in least.iter_mut().zip(four) {
            *least = if square < least { *square } else { *least };
        }
    }
    least.into_iter().fold(f64::INFINITY, f64::min)
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

/// The `k` points nearest to each point, itself among them (unless more than `k` lie where it does),
/// nearest first.
///
/// Returns `k` rows a point, fewer where there are fewer points: `min(k, points)`.
/// # Cost
/// About `O(points · k · log points)` in up to eight dimensions, `O(points² · dimensions)` in more;
/// on all of the caller's threads.
pub fn nearest_of_all(points: &Rows, k: usize) -> Vec<u32> {
    let k = k.min(points.len());
    let Some(count) = NonZero::new(k) else { return Vec::new() };
    // A tree's dimensions are known when the program is built; zeros change no distance.
    let found = match points.width() {
        1 | 2 => by_tree::<2>(points, count),
        3 => by_tree::<3>(points, count),
        4 => by_tree::<4>(points, count),
        5..=8 => by_tree::<8>(points, count),
        _ => None,
    };
    found.unwrap_or_else(|| by_scan(points, k))
}

/// `None` if the tree cannot be made.
fn by_tree<const D: usize>(points: &Rows, k: NonZero<usize>) -> Option<Vec<u32>> {
    let padded = |point: &[f64]| -> [f64; D] {
        std::array::from_fn(|axis| point.get(axis).copied().unwrap_or(0.0))
    };
    let places: Vec<[f64; D]> = points.iter().map(padded).collect();
    let tree = ImmutableKdTree::<f64, D>::new_from_slice(&places).ok()?;
    let found = places.par_iter().flat_map_iter(|place| {
        let mut near = tree.query(place).nearest_n::<SquaredEuclidean<f64>>(k).execute();
        near.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.item.cmp(&b.item)));
        near.into_iter().map(|near| near.item)
    });
    let found: Vec<u32> = found.collect();
    (found.len() == k.get() * places.len()).then_some(found)
}

fn by_scan(points: &Rows, k: usize) -> Vec<u32> {
    let nearest = Nearest::new(points);
    let rows: Vec<&[f64]> = points.iter().collect();
    let found = rows.par_iter().map_init(
        || Vec::with_capacity(k),
        |near, point| {
            nearest.nearest(point, k, near);
            near.iter().map(|near| near.point).collect::<Vec<_>>()
        },
    );
    found.collect::<Vec<_>>().concat()
}
