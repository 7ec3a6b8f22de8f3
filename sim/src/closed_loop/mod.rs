//! Partner → sensor → tick → arm → figures: the whole of it, closed.
//!
//! A [`Scenario`](crate::scenario::Scenario) is laid out as a [`Stage`] (who is where at any
//! instant, and what the sensor says of it); [`play`] feeds it tick by tick to a [`Controller`]
//! and lets the [`Plant`] follow what that says; the [`Trace`] is measured into an [`Outcome`],
//! beside the scenario's bounds. [`Learnt`] is what the product's own controller knows: handovers
//! made up from another seed, the same for all scenarios.
//!
//! The partner does not react to the robot: they do what the scenario says. So a robot that comes
//! late misses them, and figures of the hand's place are of the robot's own making.
//!
//! The product has no part in this module but the tick itself; everything here is what surrounds it.

mod controller;
mod feed;
mod learnt;
mod measure;
mod outcome;
mod plant;
mod play;
mod stage;
mod warp;

pub use controller::{Controller, Reply};
pub use feed::{Feed, Message};
pub use learnt::{LearnError, Learnt};
pub use measure::gap_error;
pub use outcome::{Outcome, RunError};
pub use plant::Plant;
pub use play::{Step, Trace, play};
pub use stage::{Stage, StageError};
pub use warp::TimeWarp;
