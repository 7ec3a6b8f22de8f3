//! The safety gate from outside: whatever comes in, what goes out keeps every promise.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

mod checks;
mod clock;
mod hostile;
mod jerk;
mod motions;
mod promises;
mod real_time;
mod scene;
