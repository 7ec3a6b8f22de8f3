//! Whole ticks from outside: sightings in, targets out.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

#[allow(dead_code, reason = "shared with tests of the gate that use other parts")]
#[path = "../safety/checks.rs"]
mod checks;
mod following;
#[allow(dead_code, reason = "shared with tests and benches that use other parts")]
#[path = "../common/handovers.rs"]
mod handovers;
mod hostile;
mod invariance;
mod lifecycle;
mod runs;
mod strangers;
