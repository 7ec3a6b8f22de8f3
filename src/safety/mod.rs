//! Solved poses → targets that break no limit, whatever the poses are.
//!
//! The robot is a base point and one unit vector a bone, so bones keep their length by construction.
//! What it is told to do is always a plan: going on for a short while, then braking to a standstill
//! (Fraichard & Asama 2004: a state is safe if some motion from it is safe for ever). A plan is
//! followed only once all of it is certified: speed, acceleration and jerk of every joint, the
//! workspace, the distance to the partner. At each tick a new plan towards the proposal is tried; if
//! none can be certified, the old one goes on, and it ends in a standstill. So each tick is safe
//! because the one before was, and a tick that never comes finds the robot braking.
//!
//! The distance to the partner has the form of speed and separation monitoring in ISO/TS 15066; it is
//! not safety-rated. Knows nothing of meshes, sensors or messages. Reads no clock; allocates
//! nothing once made.
//!
//! Nobody else can make a [`Target`]: it has no constructor, and its fields are private.
//! ```compile_fail,E0451
//! # fn forge(genuine: handover_mesh::safety::Target) -> handover_mesh::safety::Target {
//! handover_mesh::safety::Target { reason: None, ..genuine }
//! # }
//! ```

mod aim;
mod bounds;
mod brake;
mod certify;
mod chain;
mod distance;
mod gate;
mod hold;
mod jet;
mod partner;
mod plan;
mod settings;
mod target;

pub use gate::{Proposal, SafetyGate};
pub use hold::HoldReason;
pub use partner::PartnerBody;
pub(crate) use partner::is_place;
pub use settings::{SafetyError, SafetySettings};
pub use target::Target;
