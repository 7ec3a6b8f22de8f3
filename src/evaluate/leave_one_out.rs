//! The protocol `leave_one_out`: every clip by methods that never saw it, nor its group.

use std::sync::Arc;

use rayon::prelude::*;

use super::folds::folds;
use super::report::{Clip, Evaluation};
use super::trial::UnknownJoint;
use super::{Figures, Trial, TrialError};
use crate::learn::{LearnSettings, Lessons, Search};
use crate::demonstration::Demonstration;
use crate::predict::{Method, PredictSettings, Predictor};

/// What an evaluation may choose.
#[derive(Debug, Clone, PartialEq)]
pub struct EvaluateSettings {
    /// The columns.
    pub methods: Vec<Method>,
    /// How many folds, where there are more than twenty groups; ≥ 2.
    pub folds: usize,
    /// Joints of the robot, by name, that no figure counts.
    pub ignored_joints: Vec<String>,
    /// How predictions are made.
    pub predict: PredictSettings,
    /// How the edges of `mesh` are learned, once per fold.
    pub learn: LearnSettings,
}

/// Why there is no evaluation.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EvaluateError {
    /// Nobody is left to learn from.
    #[error("{groups} group(s) of clips; leave_one_out learns from the others and needs two")]
    TooFew {
        /// How many groups there are.
        groups: usize,
    },
    /// A clip could not be evaluated.
    #[error("{clip}: {error}")]
    Clip {
        /// The clip.
        clip: String,
        /// Why.
        error: TrialError,
    },
}

/// Evaluates every method on every clip.
///
/// - `groups`: one per clip; clips of one group never learn from each other.
/// - `done`: called after each clip, from any thread.
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
    assert_eq!(clips.len(), groups.len(), "one group per clip");
    let folds = folds(groups, settings.folds);
    let count = folds.iter().max().map_or(0, |last| last + 1);
    if count < 2 {
        return Err(EvaluateError::TooFew { groups: count });
    }
    let predictors: Vec<Predictor> = (0..count)
        .into_par_iter()
        .map(|fold| {
            let others = clips.iter().zip(groups).zip(&folds).filter(|(_, f)| **f != fold);
            let (others, groups): (Vec<_>, Vec<String>) =
                others.map(|((clip, group), _)| (clip.clone(), group.clone())).unzip();
            let failed = |error: TrialError| EvaluateError::Clip {
                clip: format!("learning without fold {fold}"),
                error,
            };
            let predictor = Predictor::fit(others, settings.predict.clone())
                .map_err(|error| failed(error.into()))?;
            learn(predictor, &groups, settings).map_err(failed)
        })
        .collect::<Result<_, _>>()?;
    let evaluated: Vec<(Clip, Vec<String>)> = clips
        .par_iter()
        .zip(&folds)
        .map(|(clip, fold)| {
            let evaluated = evaluate_clip(clip, &predictors[*fold], settings);
            done();
            evaluated.map_err(|error| EvaluateError::Clip {
                clip: clip.recording().name().to_owned(),
                error,
            })
        })
        .collect::<Result<_, _>>()?;
    let (clips, failures): (Vec<Clip>, Vec<Vec<String>>) = evaluated.into_iter().unzip();
    Ok(Evaluation::new("leave_one_out", &settings.methods, clips, failures.concat()))
}

/// A predictor with the edges that its demonstrations need.
fn learn(
    predictor: Predictor,
    groups: &[String],
    settings: &EvaluateSettings,
) -> Result<Predictor, TrialError> {
    if !settings.methods.contains(&Method::Mesh) {
        return Ok(predictor);
    }
    let skeleton = predictor.demonstrations()[0].robot().skeleton();
    let ignored = UnknownJoint::find(skeleton, &settings.ignored_joints)?;
    let lessons = Lessons::of(&predictor, groups, &ignored, &settings.learn)?;
    let mut search = Search::new(lessons, settings.learn.clone())?;
    while let Some(step) = search.step(|| ())? {
        if std::env::var("LAB").is_ok() { eprintln!("{:?}", (step.change, step.before, step.distance)); }
    }
    if std::env::var("LAB").is_ok() { eprintln!("{:?}", (search.initial(), search.lessons().distance(), search.lessons().held_out_distance())); }
    Ok(predictor.with_edges(search.edges()?))
}

/// All methods on one clip, and which of them had nothing to say about it.
fn evaluate_clip(
    truth: &Demonstration,
    predictor: &Predictor,
    settings: &EvaluateSettings,
) -> Result<(Clip, Vec<String>), TrialError> {
    let trial = Trial::new(truth, predictor, &settings.ignored_joints)?;
    let name = truth.recording().name();
    let mut failures = Vec::new();
    let methods = settings.methods.iter().map(|method| {
        let figures = trial.run(*method).map(|(_, figures)| figures).unwrap_or_else(|error| {
            failures.push(format!("{name}, {}: {error}", method.name()));
            Figures::default()
        });
        (*method, figures)
    });
    let methods = methods.collect();
    let clip = Clip {
        name: name.to_owned(),
        frames: truth.recording().len(),
        methods,
        human: trial.human(),
    };
    Ok((clip, failures))
}
