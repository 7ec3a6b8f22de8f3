//! Which poses lead from one pose to another: shortest paths between all pairs.
//!
//! From every pose the others are reached nearest first (Dijkstra 1959). `petgraph`'s own forms
//! give distances without paths, or keep them in hash maps that for 1,700 poses take seconds to
//! fill.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::{MotionError, MotionGraph};

/// Shortest paths between all pairs of poses; immutable.
#[derive(Debug, Clone, PartialEq)]
pub struct ShortestPaths {
    count: usize,
    /// `count × count`: on the way from a pose (row) to another (column), the last but one.
    before: Vec<u32>,
    /// `count × count`: how long the way is; infinite where there is none.
    lengths: Vec<f64>,
}

/// A way from one pose to another.
#[derive(Debug, Clone, PartialEq)]
pub struct Transition {
    /// The poses passed, both ends among them.
    pub poses: Vec<usize>,
    /// The sum of the steps' lengths in the latent space.
    pub length: f64,
}

const NONE: u32 = u32::MAX;

impl ShortestPaths {
    /// The most poses a table of all pairs is made for: 1.2 GB.
    pub const MOST: usize = 10_000;

    /// Finds all of them, on all of the caller's threads.
    ///
    /// # Errors
    /// [`MotionError::TooManyPaths`].
    /// # Cost
    /// `O(n · edges · log n)` time, 12 bytes a pair.
    pub fn of(graph: &MotionGraph) -> Result<Self, MotionError> {
        let count = graph.len();
        if count > Self::MOST {
            return Err(MotionError::TooManyPaths { poses: count, most: Self::MOST });
        }
        let mut before = vec![NONE; count * count];
        let mut lengths = vec![f64::INFINITY; count * count];
        let rows = before.par_chunks_mut(count).zip(lengths.par_chunks_mut(count)).enumerate();
        rows.for_each_init(BinaryHeap::new, |queue, (from, (before, lengths))| {
            search(graph, from, before, lengths, queue);
        });
        Ok(Self { count, before, lengths })
    }

    /// How long the shortest way is in the latent space; `None` if there is none.
    ///
    /// # Panics
    /// If there is no such pose: the caller's bug.
    pub fn length(&self, from: usize, to: usize) -> Option<f64> {
        assert!(from.max(to) < self.count, "no pose {}", from.max(to));
        Some(self.lengths[from * self.count + to]).filter(|length| length.is_finite())
    }

    /// The shortest way from this pose to that; `None` if there is none.
    ///
    /// # Panics
    /// If there is no such pose: the caller's bug.
    pub fn transition(&self, from: usize, to: usize) -> Option<Transition> {
        let length = self.length(from, to)?;
        let mut poses = vec![to];
        let mut pose = to;
        while pose != from {
            pose = self.before[from * self.count + pose] as usize;
            poses.push(pose);
        }
        poses.reverse();
        Some(Transition { poses, length })
    }
}

/// A length as it stands in a queue: never NaN.
#[derive(PartialEq, PartialOrd)]
struct Length(f64);

impl Eq for Length {}

#[expect(clippy::derive_ord_xor_partial_ord, reason = "the same order, told for all numbers")]
impl Ord for Length {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// From one pose to all others.
fn search(
    graph: &MotionGraph,
    from: usize,
    before: &mut [u32],
    lengths: &mut [f64],
    queue: &mut BinaryHeap<Reverse<(Length, u32)>>,
) {
    queue.clear();
    lengths[from] = 0.0;
    queue.push(Reverse((Length(0.0), from as u32)));
    while let Some(Reverse((Length(length), pose))) = queue.pop() {
        if length > lengths[pose as usize] {
            continue;
        }
        for (next, step) in graph.next(pose as usize) {
            if length + step < lengths[next] {
                lengths[next] = length + step;
                before[next] = pose;
                queue.push(Reverse((Length(length + step), next as u32)));
            }
        }
    }
}
