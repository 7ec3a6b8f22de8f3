//! The protocol `leave_one_out`: every clip by methods that never saw it, nor its group.

use std::sync::Arc;

use rayon::prelude::*;

use super::folds::folds;
use super::report::{Clip, Evaluation};
use super::{Figures, Scene};
use crate::demonstration::{Demonstration, Observation};
use crate::predict::{Method, PredictError, PredictSettings, Predictor};

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
    /// A method failed on a clip.
    #[error("{clip}: {error}")]
    Predict {
        /// The clip.
        clip: String,
        /// Why.
        error: PredictError,
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
    let smoothed: Vec<Arc<Demonstration>> =
        clips.par_iter().map(|clip| Arc::new(clip.smoothed(settings.predict.smoothing))).collect();
    let predictors: Vec<Predictor> = (0..count)
        .into_par_iter()
        .map(|fold| {
            let others = smoothed.iter().zip(&folds).filter(|(_, f)| **f != fold);
            let others = others.map(|(clip, _)| clip.clone()).collect();
            Predictor::fit(others, settings.predict.clone())
                .map_err(|error| EvaluateError::Predict { clip: format!("fold {fold}"), error })
        })
        .collect::<Result<_, _>>()?;
    let clips: Vec<Clip> = (0..clips.len())
        .into_par_iter()
        .map(|at| {
            let clip = evaluate_clip(&clips[at], &smoothed[at], &predictors[folds[at]], settings);
            done();
            clip.map_err(|error| {
                let clip = clips[at].recording().name().to_owned();
                EvaluateError::Predict { clip, error }
            })
        })
        .collect::<Result<_, _>>()?;
    Ok(Evaluation::new("leave_one_out", &settings.methods, clips))
}

/// All methods on one clip: they see its smoothed partner, the figures its raw truth.
fn evaluate_clip(
    truth: &Demonstration,
    smoothed: &Demonstration,
    predictor: &Predictor,
    settings: &EvaluateSettings,
) -> Result<Clip, PredictError> {
    // Smoothing may shorten a bone; the robot's own do not change.
    let bone_lengths = truth.robot().bone_lengths();
    let observation = Observation { bone_lengths, ..smoothed.observation() };
    let alignment = predictor.align(&observation)?;
    let skeleton = truth.robot().skeleton();
    let ignored: Vec<_> =
        settings.ignored_joints.iter().filter_map(|name| skeleton.joint(name)).collect();
    let gap = predictor.mean_gap(alignment.hands);
    let scene = Scene::new(truth, alignment.hands, gap, &ignored);
    let methods = settings.methods.iter().map(|method| {
        let predicted = predictor.predict(*method, &observation, &alignment)?;
        let figures = scene.as_ref().map(|scene| scene.figures(&predicted));
        Ok((*method, figures.unwrap_or_default()))
    });
    let methods = methods.collect::<Result<Vec<(Method, Figures)>, PredictError>>()?;
    let did = truth.robot().frames().iter().flat_map(|f| f.positions.iter().copied());
    let human = scene.as_ref().map(|scene| scene.figures(&did.collect::<Vec<_>>()));
    Ok(Clip {
        name: truth.recording().name().to_owned(),
        frames: truth.recording().len(),
        methods,
        human: human.unwrap_or_default(),
    })
}
