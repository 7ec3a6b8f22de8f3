//! A recording or a made-up scene, settings and a clock → the messages that a sensor would send.
//!
//! A [`Player`] is told what time it is, and says what is due: the partner's skeleton as a
//! [`Sensor`](crate::sensor::Sensor) sees it, where the robot's joints are, the object. Frame `k`
//! of what is played is due at `t₀ + (sₖ − s₀) / speed`, `s` its stamps, and that is the stamp of its
//! messages, however late somebody asks. Equal seeds and settings give equal messages.
//!
//! Needs no ROS, reads no clock, opens no file: the node in `sim/src/ros.rs` does.

mod outgoing;
mod player;
mod settings;
mod source;

pub use outgoing::{Outgoing, Reliability, Topic};
pub use player::{BroadcastError, Player};
pub use settings::{Settings, follow_ups, parameters};
pub use source::Source;
