//! The interaction mesh: two people's joints over time → who neighbours whom, how strongly, and
//! how each joint sits among its neighbours.
//!
//! `δᵢ = vᵢ − Σⱼ w̄ᵢⱼ vⱼ`, `w̄ᵢⱼ = wᵢⱼ / Σⱼ wᵢⱼ` over spatial neighbours in the frame and the same
//! joint one frame earlier and later (Thai 2014, 3.1; Ho, Komura & Tai 2010).
//!
//! Knows nothing of targets, robots or learning.

mod laplacian;
mod pair;
mod topology;
mod weights;

pub use laplacian::InteractionMesh;
pub use pair::{Pair, Vertex};
pub use topology::{Edge, InitialEdges, Topology};
pub use weights::{EdgeWeights, Kernel};

use crate::delaunay::DelaunayError;

/// Why a mesh could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// An edge names a joint that is not there, or joins a joint with itself.
    #[error("edge {a}-{b} is none: the pair has {vertices} joints and an edge joins two of them")]
    Edge {
        /// One end.
        a: usize,
        /// The other end.
        b: usize,
        /// Joints of both people.
        vertices: usize,
    },
    /// Positions do not fill whole frames.
    #[error("{got} positions are not {frames} frames of {vertices} joints")]
    Shape {
        /// Positions given.
        got: usize,
        /// Frames expected.
        frames: usize,
        /// Joints of both people.
        vertices: usize,
    },
    /// A weight is negative, NaN or infinite, or a joint has none at all.
    #[error("frame {frame}, joint {joint}: edge weights are finite, ≥ 0 and not all 0")]
    Weight {
        /// The frame, counted from 0.
        frame: usize,
        /// The joint, counted over both people.
        joint: usize,
    },
    /// A frame's positions have no exact tetrahedra.
    #[error("a frame has no exact tetrahedra")]
    Delaunay(#[from] DelaunayError),
    /// A position is NaN or infinite.
    #[error("frame {frame}, joint {joint}: position is not finite")]
    NotFinite {
        /// The frame, counted from 0.
        frame: usize,
        /// The joint, counted over both people.
        joint: usize,
    },
}
