//! Shapes taken apart and put together again.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

mod dense;
mod ends;
mod hostile;
mod invariance;
mod iterations;
mod oracle;
mod shapes;
mod tetrisations;
mod turns;
mod weights;
