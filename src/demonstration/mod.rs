//! A recording seen from the robot's side: what it may know, and what it is to learn from.
//!
//! An [`Observation`] holds all a method may use of the interaction at hand: the partner's motion,
//! where the robot's base is, the robot's own bones and first pose; the robot role's truth is not
//! in it. A [`Demonstration`] is a recording with both roles, and where its hands met.

mod carried;
mod changed;
mod contact;
mod observation;

pub use carried::{CarryError, with_object_carried};
pub use contact::{Contact, Hands};
pub use observation::{Demonstration, DemonstrationError, Observation};
