//! Where a person will be: their past → all joints over a horizon, by all methods.
//!
//! The path of the data: motions of others → [`Forecaster::fit`]; the past → [`Moment`] →
//! [`Forecaster::forecast`] by one [`ForecastMethod`] → joints at each horizon. A moment's
//! features are projected into a latent space, where the demonstrated moments around it say, by the
//! neighbourhoods and weights of [`crate::motion`], what came next.
//!
//! A field holds displacements over the whole horizon, not velocities to be followed step by step:
//! following the demonstrations themselves, it cannot drift.
//!
//! Knows one person at a time, and nothing of the robot.

mod examples;
mod fields;
mod forecaster;
mod mixture;
mod moment;
mod regression;
mod settings;

pub use forecaster::{ForecastError, ForecastMethod, Forecaster, Workspace};
pub use moment::Moment;
pub use settings::ForecastSettings;
