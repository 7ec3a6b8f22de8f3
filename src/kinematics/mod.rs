//! Where a limb's joints lie when its ends are given.
//!
//! Geometry only: knows nothing of people, recordings or robots.

mod two_bone;

pub use two_bone::{TwoBone, two_bone};
