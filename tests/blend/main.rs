//! Shapes taken apart and put together again.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

mod ends;
mod shapes;
