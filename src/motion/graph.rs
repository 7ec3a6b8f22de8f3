//! Poses in sequences → a directed graph: which pose may follow which.
//!
//! Consecutive poses of a sequence are joined in the direction of time. Neighbours in the latent
//! space are joined in the direction in which both move: with `v = (v₁ + v₂)/2` from `p₁` to `p₂`
//! if `v · (p₂ − p₁) > 0`, from `p₂` to `p₁` if it is negative, not at all if it is zero
//! (Gauch & Peters III-B). An edge is as long as its ends are apart in the latent space.
//!
//! # Connectivity
//! The paper claims that the graph is connected exactly if a smaller one `H` of the sequences'
//! first and last poses is. With an arc in `H` wherever a directed path leads from one to the
//! other, and "connected" meaning strongly connected, that holds: from any pose the sequence leads
//! to its last one, from there a path in `H` to the first pose of any other's sequence, and on.

use std::ops::Range;

use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::{Dfs, EdgeRef as _};

use super::Rows;
use super::rows::distance;

/// Which pose may follow which; immutable.
#[derive(Debug, Clone)]
pub struct MotionGraph {
    graph: DiGraph<(), f64>,
    sequences: Vec<Range<usize>>,
}

impl MotionGraph {
    /// Joins poses.
    ///
    /// - `points`, `velocities`: of every pose, in the latent space.
    /// - `sequences`: the poses of each sequence, without gaps.
    /// - `neighbours`: pairs `[i, j]`, in any order.
    pub(super) fn new(
        points: &Rows,
        velocities: &Rows,
        sequences: &[Range<usize>],
        neighbours: &[[u32; 2]],
    ) -> Self {
        let mut edges: Vec<[u32; 2]> = Vec::with_capacity(points.len() + neighbours.len());
        let in_time = |range: &Range<usize>| {
            let steps = range.clone().skip(1);
            steps.map(|pose| [pose as u32 - 1, pose as u32]).collect::<Vec<_>>()
        };
        edges.extend(sequences.iter().flat_map(in_time));
        let starts: Vec<usize> = sequences.iter().map(|range| range.start).collect();
        for &[i, j] in neighbours {
            // Time has directed these already.
            let [i, j] = [i.min(j), i.max(j)];
            if j == i + 1 && starts.binary_search(&(j as usize)).is_err() {
                continue;
            }
            let [p, q, v, w] = [(points, i), (points, j), (velocities, i), (velocities, j)]
                .map(|(rows, row)| rows.row(row as usize));
            let along: f64 =
                (0..p.len()).map(|axis| 0.5 * (v[axis] + w[axis]) * (q[axis] - p[axis])).sum();
            if along > 0.0 {
                edges.push([i, j]);
            } else if along < 0.0 {
                edges.push([j, i]);
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let mut graph = DiGraph::with_capacity(points.len(), edges.len());
        for _ in 0..points.len() {
            graph.add_node(());
        }
        for [i, j] in edges {
            let length = distance(points.row(i as usize), points.row(j as usize));
            graph.add_edge(NodeIndex::new(i as usize), NodeIndex::new(j as usize), length);
        }
        Self { graph, sequences: sequences.to_vec() }
    }

    /// The number of poses.
    #[expect(clippy::len_without_is_empty, reason = "a motion model has poses")]
    pub fn len(&self) -> usize {
        self.graph.node_count()
    }

    /// The number of directed edges.
    pub fn edge_count(&self) -> usize {
        self.graph.edge_count()
    }

    /// The poses of each sequence.
    pub fn sequences(&self) -> &[Range<usize>] {
        &self.sequences
    }

    /// The poses that may follow a pose directly, and how far they are in the latent space.
    ///
    /// # Panics
    /// If there is no such pose: the caller's bug.
    pub fn next(&self, pose: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        assert!(pose < self.len(), "no pose {pose}");
        let edges = self.graph.edges(NodeIndex::new(pose));
        edges.map(|edge| (edge.target().index(), *edge.weight()))
    }

    /// Sets of poses within which every pose leads to every other, each ascending; ordered by
    /// their first.
    pub fn components(&self) -> Vec<Vec<usize>> {
        // NOTE: petgraph's Tarjan calls itself once per pose, which a long sequence's stack is not
        // made for.
        let mut components: Vec<Vec<usize>> = kosaraju_scc(&self.graph)
            .into_iter()
            .map(|component| component.into_iter().map(NodeIndex::index).collect())
            .collect();
        components.iter_mut().for_each(|component| component.sort_unstable());
        components.sort_unstable();
        components
    }

    /// The paper's `H`: the first and the last pose of each sequence, with an arc wherever a
    /// directed path leads from one to another. A node's weight is its pose.
    pub fn sequence_ends(&self) -> DiGraph<usize, ()> {
        let mut ends: Vec<usize> =
            self.sequences.iter().flat_map(|range| [range.start, range.end - 1]).collect();
        ends.sort_unstable();
        ends.dedup();
        let mut graph = DiGraph::new();
        let nodes: Vec<_> = ends.iter().map(|pose| graph.add_node(*pose)).collect();
        for (from, &pose) in nodes.iter().zip(&ends) {
            let mut reached = vec![false; self.len()];
            let mut search = Dfs::new(&self.graph, NodeIndex::new(pose));
            while let Some(node) = search.next(&self.graph) {
                reached[node.index()] = true;
            }
            for (to, &other) in nodes.iter().zip(&ends) {
                if other != pose && reached[other] {
                    graph.add_edge(*from, *to, ());
                }
            }
        }
        graph
    }
}
