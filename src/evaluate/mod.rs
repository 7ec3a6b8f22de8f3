//! How well a method stands in for the human who really took the robot's role.
//!
//! The path of the data: demonstrations → [`folds`] (who may learn from whom) → predictions of
//! every method on the same alignment → [`Figures`] per clip → [`Evaluation`] with summaries.

mod figures;
mod folds;
mod leave_one_out;
mod report;
mod trial;

pub use figures::{Figure, Figures, Scene};
pub use folds::folds;
pub use leave_one_out::{EvaluateError, EvaluateSettings, leave_one_out};
pub use report::{Clip, Evaluation, Summaries};
pub use trial::{Trial, TrialError, UnknownJoint};
