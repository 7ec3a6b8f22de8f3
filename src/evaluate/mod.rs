//! How well a method stands in for the human who really took the robot's role.
//!
//! The path of the data: demonstrations → [`folds`] (who may learn from whom) → predictions of
//! every method on the same alignment → [`Figures`] per clip → [`Evaluation`] with summaries, or
//! [`Displaced`], where the partner or the robot is not as it was recorded.
//!
//! [`thesis`] goes another way: one recording retargeted to each of several, before and after
//! learning.

mod causal;
mod condition;
mod displaced;
mod figures;
mod folds;
mod forecast;
mod leave_one_out;
mod motion;
mod predictors;
mod report;
mod scene;
mod thesis;
mod trial;

pub use condition::{Condition, Direction};
pub use displaced::{ChangedClip, Displaced, displaced};
pub use figures::{Figure, Figures};
pub use folds::folds;
pub use forecast::{
    ForecastClip, ForecastErrors, ForecastEvaluation, ForecastEvaluationError, ForecastProtocol,
    forecast,
};
pub use leave_one_out::leave_one_out;
pub use motion::{
    LeftOut, MotionEvaluation, MotionEvaluationError, MotionFold, MotionProtocol, NamedSequence,
    PathErrors, cross_validate,
};
pub use predictors::{EvaluateError, EvaluateSettings};
pub use report::{Clip, Evaluation, MethodFigures, MethodSummaries, Summaries};
pub use scene::{KnownScene, Scene};
pub use thesis::{Average, Thesis, Training, thesis};
pub use trial::{ChangedTrial, Trial, TrialError, UnknownJoint};
