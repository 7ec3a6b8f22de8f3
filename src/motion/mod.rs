//! Where in the demonstrations is a pose, and what comes next: poses in sequences → a latent space,
//! a graph of what may follow what, and a field of velocities to follow.
//!
//! The method of Gauch & Peters, "Animation Generation with a Low-Dimensional Simplicial Complex":
//! poses → [`Pca`] → latent points → [`Complex`] (Delaunay) or nearest neighbours → weights `1/D²`
//! → velocity `Σ wᵢ vᵢ` → a path → poses again. A pose is any row of numbers; the root is the
//! caller's to remove.
//!
//! Knows no people, no joints and no seconds: time is counted in frames.

mod compare;
mod complex;
mod error;
mod field;
mod graph;
mod model;
mod nearest;
mod neighbourhood;
mod paths;
mod pca;
mod rows;

pub use compare::{error_a, error_f};
pub use complex::{Complex, Place};
pub use error::MotionError;
pub use field::{FollowSettings, Path, Stop};
pub use graph::MotionGraph;
pub use model::{MotionModel, MotionSettings};
pub use nearest::{Near, Nearest, nearest_of_all};
pub use neighbourhood::{Around, Neighbour, Neighbourhood, Neighbours};
pub use paths::{ShortestPaths, Transition};
pub use pca::{Dimensions, Pca};
pub use rows::{LARGEST, Rows};
