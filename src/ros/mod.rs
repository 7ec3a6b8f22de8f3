//! What nodes on ROS 2 have in common, and the handover node; the one place that knows `r2r`.
//!
//! The shape of the node: whatever comes in is decoded and kept in an [`inbox`] by the thread that
//! spins; one thread ticks ([`ticker`]), takes the newest of each kind from it and publishes. No lock
//! is shared between the two but the clock's. What services ask for goes from the first to the second
//! as a command.

pub mod context;
mod inbox;
mod lifecycle;
mod load;
mod node;
pub mod parameters;
mod services;
pub mod shell;
mod subscriptions;
mod ticker;
mod triggers;

pub use node::run;
