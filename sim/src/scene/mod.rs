//! Parameters of one handover → what both people's joints do, at any instant.
//!
//! A [`SceneConfig`] is checked into a [`Scene`]; the scene is a closed form in time, so a pose
//! can be asked for at any instant and in any order, and a [`Recording`](handover_mesh::Recording)
//! is the poses at some stamps. Frames: `pair` has its origin on the floor halfway between the
//! two people as they stand when they hand over, x from giver to receiver, z up; `world` is where
//! recordings are, by [`SceneConfig::centre`] and [`SceneConfig::heading`].
//!
//! Deliberately no dynamics and no contact forces, and the two do not react to what they see:
//! the receiver's lag is a parameter.

mod config;
mod draw;
mod moments;
mod motion;
mod people;
mod play;

pub use config::{Approach, PersonConfig, SceneConfig, StepIn, Timing};
pub use draw::draw;
pub use moments::Moments;
pub use play::{Pose, RecordError, Scene, Take};

/// The giver's name in recordings; the first person.
pub const GIVER: &str = "giver";
/// The receiver's name in recordings; the second person.
pub const RECEIVER: &str = "receiver";
/// What is handed over, in recordings.
pub const OBJECT: &str = "object";
