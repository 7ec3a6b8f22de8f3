//! What nodes on ROS 2 have in common; the one place that knows `r2r`.

pub mod context;
pub mod parameters;
pub mod shell;
