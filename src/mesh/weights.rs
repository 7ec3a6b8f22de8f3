//! How strongly neighbours bind: a kernel of the distance in the demonstration.

use super::{MeshError, Topology};
use crate::geometry::Point;

/// The weight of an interperson edge at distance `d` `[m]` in the demonstration; edges inside a
/// person weigh 1 always.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kernel {
    /// 1 at any distance (Thai 2014).
    Uniform,
    /// `scale · (reference / max(d, minimum))^power`: hands bind when they are close, in each
    /// frame anew.
    InverseDistance {
        /// Weight `[-]` at the reference distance.
        scale: f64,
        /// Exponent `[-]`.
        power: f64,
        /// Reference distance `[m]`.
        reference: f64,
        /// Nearer than this counts as this `[m]`.
        minimum: f64,
    },
}

impl Kernel {
    /// The name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::InverseDistance { .. } => "inverse_distance",
        }
    }

    /// The weight `[-]` of an interperson edge at `distance` `[m]`.
    pub fn weight(self, distance: f64) -> f64 {
        match self {
            Self::Uniform => 1.0,
            Self::InverseDistance { scale, power, reference, minimum } => {
                scale * (reference / distance.max(minimum)).powf(power)
            }
        }
    }
}

/// Weights of all edges in all frames, and of the temporal edges: `[-]`, finite, not negative.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeWeights {
    /// `frames × edges`.
    spatial: Vec<f64>,
    edges: usize,
    time: f64,
}

impl EdgeWeights {
    /// Weights by `kernel` of the distances in `positions`.
    ///
    /// - `positions`: `[m]`, `frames × vertices`.
    /// - `time`: weight `[-]` of the edges to the same joint a frame earlier and later.
    pub fn by_kernel(topology: &Topology, positions: &[Point], kernel: Kernel, time: f64) -> Self {
        let pair = topology.pair();
        let weigh = |frame: &[Point], edge: super::Edge| {
            let [a, b] = edge.ends();
            if edge.is_interperson(pair) {
                kernel.weight((frame[a.index()] - frame[b.index()]).norm())
            } else {
                1.0
            }
        };
        let frames = positions.chunks_exact(pair.len());
        let spatial =
            frames.flat_map(|frame| topology.edges().iter().map(move |edge| weigh(frame, *edge)));
        Self { spatial: spatial.collect(), edges: topology.edges().len(), time }
    }

    /// One edge's weight in one frame.
    pub fn get(&self, frame: usize, edge: usize) -> f64 {
        self.spatial[frame * self.edges + edge]
    }

    /// Changes one edge's weight in one frame; whoever makes a mesh of it checks it.
    pub fn set(&mut self, frame: usize, edge: usize, weight: f64) {
        self.spatial[frame * self.edges + edge] = weight;
    }

    /// One frame's weights, one per edge.
    pub fn frame(&self, frame: usize) -> &[f64] {
        &self.spatial[frame * self.edges..(frame + 1) * self.edges]
    }

    /// The weight of temporal edges.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Checks the numbers; every vertex must have a neighbour that counts.
    pub(super) fn check(&self, topology: &Topology, frames: usize) -> Result<(), MeshError> {
        let vertices = topology.pair().len();
        if self.spatial.len() != frames * topology.edges().len() {
            let got = self.spatial.len();
            return Err(MeshError::Shape { got, frames, vertices: topology.edges().len() });
        }
        let bad = |w: f64| !w.is_finite() || w < 0.0;
        for frame in 0..frames {
            let weights = self.frame(frame);
            for joint in 0..vertices {
                let mut row = topology.neighbours(joint).map(|(_, edge)| weights[edge]);
                let sum: f64 = topology.neighbours(joint).map(|(_, edge)| weights[edge]).sum();
                if row.any(bad) || bad(self.time) || sum + self.time <= 0.0 {
                    return Err(MeshError::Weight { frame, joint });
                }
            }
        }
        Ok(())
    }
}
