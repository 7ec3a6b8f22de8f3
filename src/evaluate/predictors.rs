//! What is learnt for an evaluation, fold by fold, and each clip put to what never saw it.

use std::sync::Arc;

use rayon::prelude::*;

use super::TrialError;
use super::folds::folds;
use super::trial::UnknownJoint;
use crate::demonstration::Demonstration;
use crate::learn::{LearnSettings, learn};
use crate::online::{OnlineModel, OnlineSettings};
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
    /// Where methods are to know the past alone, tick by tick; else they know the partner's whole
    /// motion.
    pub causal: Option<OnlineSettings>,
}

/// What is learnt without one fold.
pub(super) struct Learnt {
    pub(super) predictor: Predictor,
    /// Where methods know the past alone.
    pub(super) online: Option<Arc<OnlineModel>>,
}

/// Why there is no evaluation.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EvaluateError {
    /// Nobody is left to learn from.
    #[error("{groups} group(s) of clips; each learns from the others and needs two")]
    TooFew {
        /// How many groups there are.
        groups: usize,
    },
    /// Nothing to retarget to but the input motion itself.
    #[error("{clips} recording(s); the input motion needs others to be retargeted to")]
    NoTargets {
        /// How many recordings there are.
        clips: usize,
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

/// One predictor per fold, learnt from the clips of all other folds.
///
/// - `folds`: each clip's, as [`folds`] deals them.
fn predictors(
    clips: &[Arc<Demonstration>],
    groups: &[String],
    folds: &[usize],
    settings: &EvaluateSettings,
    done: &(impl Fn() + Sync),
) -> Result<Vec<Learnt>, EvaluateError> {
    let count = folds.iter().max().map_or(0, |last| last + 1);
    if count < 2 {
        return Err(EvaluateError::TooFew { groups: count });
    }
    let predictors = (0..count).into_par_iter().map(|fold| {
        let others = clips.iter().zip(groups).zip(folds).filter(|(_, f)| **f != fold);
        let (others, groups): (Vec<_>, Vec<_>) =
            others.map(|((clip, group), _)| (clip.clone(), group.clone())).unzip();
        let fitted = fit(others, &groups, settings);
        done();
        fitted.map_err(|error| EvaluateError::Clip { clip: format!("without fold {fold}"), error })
    });
    // NOTE: collected straight into one result, the error kept would be that of any fold.
    predictors.collect::<Vec<_>>().into_iter().collect()
}

/// A predictor with the edges that its demonstrations need.
fn fit(
    demonstrations: Vec<Arc<Demonstration>>,
    groups: &[String],
    settings: &EvaluateSettings,
) -> Result<Learnt, TrialError> {
    let mut predictor = Predictor::fit(demonstrations, settings.predict.clone())?;
    if settings.methods.contains(&Method::Mesh) {
        let skeleton = predictor.demonstrations()[0].robot().skeleton();
        let ignored = UnknownJoint::find(skeleton, &settings.ignored_joints)?;
        let edges = learn(&predictor, groups, &ignored, &settings.learn)?;
        predictor = predictor.with_edges(edges);
    }
    let online = settings.causal.clone();
    let online =
        online.map(|online| OnlineModel::new(&predictor, online).map(Arc::new)).transpose()?;
    Ok(Learnt { predictor, online })
}

/// What `evaluate` makes of each clip with a predictor that never saw the clip nor its group, in
/// the clips' order, whatever the number of threads.
///
/// - `done`: called after each fold has been learned from, from any thread.
///
/// # Errors
/// [`EvaluateError`] if there is one group only, or `evaluate` fails on a clip.
/// # Panics
/// If there is not one group per clip.
pub(super) fn each_clip<T: Send>(
    clips: &[Arc<Demonstration>],
    groups: &[String],
    settings: &EvaluateSettings,
    done: &(impl Fn() + Sync),
    evaluate: impl Fn(&Demonstration, &Learnt) -> Result<T, TrialError> + Sync,
) -> Result<Vec<T>, EvaluateError> {
    assert_eq!(clips.len(), groups.len(), "one group per clip");
    let folds = folds(groups, settings.folds);
    let predictors = predictors(clips, groups, &folds, settings, done)?;
    let evaluated = clips.par_iter().zip(&folds).map(|(clip, fold)| {
        evaluate(clip, &predictors[*fold]).map_err(|error| EvaluateError::Clip {
            clip: clip.recording().name().to_owned(),
            error,
        })
    });
    evaluated.collect::<Vec<_>>().into_iter().collect()
}
