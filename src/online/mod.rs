//! The online tick: a live skeleton → a safe target, whatever the tick's rate.
//!
//! The path of the data, one way: a sighting → [`crate::filter`] → the partner as known now →
//! [`crate::track`] (where in the demonstrations) and [`crate::forecast`] (where the partner will
//! be) → [`Reference`] (the demonstrations followed, on the places of now) → [`Window`] (the mesh
//! solved over a few frames of past and future) → [`crate::safety`] → target.

mod model;
mod perception;
mod pipeline;
mod reference;
mod replay;
mod settings;
mod trace;
mod window;

pub use model::{OnlineError, OnlineModel};
pub use perception::Perception;
pub use pipeline::{Pipeline, Solved, Tick, TickInput};
pub use reference::{Reference, Scene, mean_pose};
pub use replay::Replay;
pub use settings::OnlineSettings;
pub use trace::{TraceHeader, trace_line};
pub use window::Window;
