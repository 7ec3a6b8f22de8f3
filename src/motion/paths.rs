//! Which poses lead from one pose to another: shortest paths between all pairs.
//!
//! From every pose the others are reached about nearest first: by shells as wide as half a usual
//! step, within which a way may be mended (Meyer & Sanders 2003, "Δ-stepping"); that is several
//! times as fast as a heap, which would sort them wholly. `petgraph`'s own forms give distances
//! without paths, or keep them in hash maps that for 1,700 poses take seconds to fill.

use rayon::prelude::*;

use super::{MotionError, MotionGraph};

/// Shortest paths between all pairs of poses; immutable.
///
/// ```
/// use handover_mesh::motion::{MotionModel, MotionSettings, Rows, ShortestPaths};
/// // Round a circle twice, the second time a little wider.
/// let turns = (0..60).map(|k| (f64::from(k) / 5.0, 1.0 + f64::from(k) / 600.0));
/// let poses = Rows::new(2, turns.flat_map(|(t, r)| [r * t.cos(), r * t.sin()]).collect())?;
/// let model = MotionModel::fit(&[poses], MotionSettings::default())?;
/// let paths = ShortestPaths::of(&model.graph())?;
/// let [from, to] = [[1.0, 0.0], [0.0, 1.1]].map(|pose| model.nearest_pose(&pose));
/// let way = from.zip(to).and_then(|(from, to)| paths.transition(from, to));
/// // A quarter of the circle, not a round more.
/// assert!(way.is_some_and(|way| way.poses.len() < 12 && way.length < 2.0));
/// # Ok::<(), handover_mesh::motion::MotionError>(())
/// ```
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
    /// About `O(n · edges)` time, 12 bytes a pair.
    pub fn of(graph: &MotionGraph) -> Result<Self, MotionError> {
        let count = graph.len();
        if count > Self::MOST {
            return Err(MotionError::TooManyPaths { poses: count, most: Self::MOST });
        }
        let mut before = vec![NONE; count * count];
        let mut lengths = vec![f64::INFINITY; count * count];
        let steps = Steps::of(graph);
        let rows = before.par_chunks_mut(count).zip(lengths.par_chunks_mut(count)).enumerate();
        rows.for_each_init(
            || vec![Vec::new(); steps.shells],
            |shells, (from, (before, lengths))| steps.search(from, before, lengths, shells),
        );
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

/// The graph's edges, laid out for searches.
struct Steps {
    /// Pose after pose: where each edge leads, and its length.
    edges: Vec<(u32, f64)>,
    /// Each pose's first edge, and the end.
    starts: Vec<usize>,
    /// How many shells a step crosses, per length.
    per_length: f64,
    /// Shells that are open together, from the nearest to the end of the longest step from there.
    shells: usize,
}

/// A shell is at least as wide as the longest edge divided by this.
const MOST_SHELLS: f64 = 1024.0;

impl Steps {
    fn of(graph: &MotionGraph) -> Self {
        let (mut edges, mut starts) = (Vec::with_capacity(graph.edge_count()), vec![0]);
        for pose in 0..graph.len() {
            edges.extend(graph.next(pose).map(|(next, length)| (next as u32, length)));
            starts.push(edges.len());
        }
        let longest = edges.iter().fold(0.0, |most: f64, (_, length)| most.max(*length));
        let mean = edges.iter().map(|(_, length)| length).sum::<f64>() / edges.len() as f64;
        let per_length = (0.5 * mean).max(longest / MOST_SHELLS).recip();
        // One shell holds all where steps have no length to speak of.
        let per_length = if per_length.is_finite() { per_length } else { 0.0 };
        // The one a step starts in, the part of the next it ends in, and one for rounding.
        let shells = (longest * per_length) as usize + 3;
        Self { edges, starts, per_length, shells }
    }

    /// From one pose to all others.
    ///
    /// - `shells`: empty, and left so; a shell is used again once its poses are done.
    fn search(
        &self,
        from: usize,
        before: &mut [u32],
        lengths: &mut [f64],
        shells: &mut [Vec<u32>],
    ) {
        let shell_of = |length: f64| (length * self.per_length) as usize;
        lengths[from] = 0.0;
        shells[0].push(from as u32);
        let (mut shell, mut waiting) = (0, 1);
        while waiting > 0 {
            let mut at = 0;
            // First come, first served: poses may come in again while the shell is open.
            while let Some(&pose) = shells[shell % self.shells].get(at) {
                at += 1;
                let length = lengths[pose as usize];
                // It has been reached by a shorter way, and is done.
                if shell_of(length) < shell {
                    continue;
                }
                let edges = self.starts[pose as usize]..self.starts[pose as usize + 1];
                for &(next, step) in &self.edges[edges] {
                    let there = length + step;
                    if there < lengths[next as usize] {
                        lengths[next as usize] = there;
                        before[next as usize] = pose;
                        shells[shell_of(there) % self.shells].push(next);
                        waiting += 1;
                    }
                }
            }
            waiting -= at;
            shells[shell % self.shells].clear();
            shell += 1;
        }
    }
}
