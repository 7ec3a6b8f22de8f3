//! The protocol `leave_one_out`: every clip by methods that never saw it, nor its group.

use std::sync::Arc;

use super::predictors::{EvaluateError, EvaluateSettings, Learnt, each_clip};
use super::report::{Clip, Evaluation, every_method};
use super::{Trial, TrialError};
use crate::demonstration::Demonstration;

/// Evaluates every method on every clip.
///
/// - `groups`: one per clip; clips of one group never learn from each other.
/// - `done`: called after each fold has been learned from, and after each clip, from any thread.
///
/// The result does not depend on the number of threads.
///
/// # Errors
/// [`EvaluateError`] if there is one group only, or a prediction fails.
/// # Panics
/// If there is not one group per clip.
pub fn leave_one_out(
    clips: &[Arc<Demonstration>],
    groups: &[String],
    settings: &EvaluateSettings,
    done: impl Fn() + Sync,
) -> Result<Evaluation, EvaluateError> {
    let evaluated = each_clip(clips, groups, settings, &done, |clip, learnt| {
        let evaluated = evaluate_clip(clip, learnt, settings);
        done();
        evaluated
    })?;
    let (clips, failures): (Vec<Clip>, Vec<Vec<String>>) = evaluated.into_iter().unzip();
    Ok(Evaluation::new("leave_one_out", settings, clips, failures.concat()))
}

/// All methods on one clip, and which of them had nothing to say about it.
fn evaluate_clip(
    truth: &Demonstration,
    learnt: &Learnt,
    settings: &EvaluateSettings,
) -> Result<(Clip, Vec<String>), TrialError> {
    let trial =
        Trial::new(truth, &learnt.predictor, learnt.online.as_ref(), &settings.ignored_joints)?;
    let name = truth.recording().name();
    let (methods, failures) =
        every_method(name, &settings.methods, |method| Ok(trial.run(method)?.1));
    let clip = Clip {
        name: name.to_owned(),
        frames: truth.recording().len(),
        methods,
        human: trial.human(),
    };
    Ok((clip, failures))
}
