//! The protocol `displaced`: the clips and folds of `leave_one_out`, the partner elsewhere or the
//! robot of another size.
//!
//! Asks whether a method still brings the hand to the partner's where no human has shown it. What a
//! human would have done there nobody knows: joint, hand and contact error are undefined, and there
//! is no row of humans.

use std::sync::Arc;

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::predictors::{EvaluateError, EvaluateSettings, Learnt, each_clip};
use super::report::{
    MethodFigures, MethodSummaries, every_method, figures_json, names, summaries_json, summarise,
};
use super::{Condition, Figures, Trial, TrialError};
use crate::demonstration::Demonstration;
use crate::geometry::Vector;

/// One clip's figures under one condition, by all methods.
#[derive(Debug, Clone, PartialEq)]
pub struct ChangedClip {
    /// The clip.
    pub name: String,
    /// Its length in frames.
    pub frames: usize,
    /// What is not as it was recorded.
    pub condition: Condition,
    /// By what the partner is moved `[m]`, in the world.
    pub displacement: Vector,
    /// Whether the robot's bones reach the partner's hand at contact. Asked of scaled robots only;
    /// where it is not so, all figures are undefined.
    pub reachable: bool,
    /// The methods' figures, in the columns' order.
    pub methods: MethodFigures,
}

/// All clips under all conditions, and their summaries.
///
/// Means and medians count a clip once per condition; intervals are those of other clips, each with
/// all its conditions.
#[derive(Debug, Clone, PartialEq)]
pub struct Displaced {
    /// Whether methods knew the past alone.
    pub causal: bool,
    /// Per clip, in their own order, and condition, in [`Condition::ALL`]'s.
    pub clips: Vec<ChangedClip>,
    /// Over all displacements, the robot as it is; per method, in the columns' order.
    pub summary: MethodSummaries,
    /// Over all scales, where the robot reaches the partner's hand.
    pub scaled: MethodSummaries,
    /// Over the clips, condition by condition.
    pub conditions: Vec<(Condition, MethodSummaries)>,
    /// Clips, conditions and methods without a prediction, each with its reason; their figures are
    /// undefined.
    pub failures: Vec<String>,
}

/// Evaluates every method on every clip under every condition of [`Condition::ALL`].
///
/// - `groups`: one per clip; clips of one group never learn from each other.
/// - `done`: called after each fold has been learned from, and after each clip and condition, from any thread.
///
/// The result does not depend on the number of threads.
///
/// # Errors
/// [`EvaluateError`] if there is one group only, or a clip cannot be aligned.
/// # Panics
/// If there is not one group per clip.
pub fn displaced(
    clips: &[Arc<Demonstration>],
    groups: &[String],
    settings: &EvaluateSettings,
    done: impl Fn() + Sync,
) -> Result<Displaced, EvaluateError> {
    let evaluated = each_clip(clips, groups, settings, &done, |clip, learnt| {
        evaluate_clip(clip, learnt, settings, &done)
    })?;
    let (clips, failures): (Vec<_>, Vec<Vec<String>>) = evaluated.into_iter().flatten().unzip();
    let over = |wanted: &dyn Fn(Condition) -> bool| {
        let clips = clips.chunks(Condition::ALL.len()).map(|clip: &[ChangedClip]| {
            let wanted = clip.iter().filter(|changed| wanted(changed.condition));
            wanted.map(|changed| &changed.methods).collect()
        });
        summarise(&settings.methods, &clips.collect::<Vec<_>>())
    };
    let is_scaled = |condition| matches!(condition, Condition::Scaled(_));
    let summary = over(&|condition| !is_scaled(condition));
    let scaled = over(&is_scaled);
    let conditions = Condition::ALL.map(|one| (one, over(&|condition| condition == one))).into();
    let (causal, failures) = (settings.causal.is_some(), failures.concat());
    Ok(Displaced { causal, summary, scaled, conditions, failures, clips })
}

/// All methods on one clip under all conditions, each with the methods that had nothing to say.
fn evaluate_clip(
    truth: &Demonstration,
    learnt: &Learnt,
    settings: &EvaluateSettings,
    done: &(impl Fn() + Sync),
) -> Result<Vec<(ChangedClip, Vec<String>)>, TrialError> {
    let trial =
        Trial::new(truth, &learnt.predictor, learnt.online.as_ref(), &settings.ignored_joints)?;
    let evaluate = |condition: Condition| {
        let evaluated = evaluate_condition(truth, &trial, condition, settings);
        done();
        evaluated
    };
    Condition::ALL.into_par_iter().map(evaluate).collect()
}

fn evaluate_condition(
    truth: &Demonstration,
    trial: &Trial<'_>,
    condition: Condition,
    settings: &EvaluateSettings,
) -> Result<(ChangedClip, Vec<String>), TrialError> {
    let changed = trial.under(condition)?;
    let recording = truth.recording();
    // A displaced partner may be out of reach too; that is the same for every method, and whoever
    // keeps its bones comes as near as it can.
    let reachable = matches!(condition, Condition::Displaced(..)) || changed.scene().within_reach();
    let name = format!("{} {}", recording.name(), condition.name());
    let (methods, failures) = every_method(&name, &settings.methods, |method| {
        if reachable { Ok(changed.run(method)?.1) } else { Ok(Figures::default()) }
    });
    let clip = ChangedClip {
        name: recording.name().to_owned(),
        frames: recording.len(),
        condition,
        displacement: changed.displacement(),
        reachable,
        methods,
    };
    Ok((clip, failures))
}

impl Displaced {
    /// `{"protocol","role","causal","methods":[METHOD],"clips":[{"name","frames","condition",
    /// "displacement_m":[x,y,z],"scale","methods":{METHOD:{FIGURE}}}],
    /// "summary":{METHOD:{FIGURE:{"mean","median","low","high","n"}}},"scaled":{as summary},
    /// "conditions":{CONDITION:{as summary}}}`; undefined figures are null.
    pub fn to_json(&self, role: &str) -> Value {
        let clips: Vec<Value> = self.clips.iter().map(clip_json).collect();
        let conditions = self.conditions.iter();
        let conditions: Map<String, Value> = conditions
            .map(|(condition, summary)| (condition.name(), summaries_json(summary)))
            .collect();
        json!({
            "protocol": "displaced",
            "role": role,
            "causal": self.causal,
            "methods": names(&self.summary),
            "clips": clips,
            "summary": summaries_json(&self.summary),
            "scaled": summaries_json(&self.scaled),
            "conditions": conditions,
        })
    }
}

fn clip_json(clip: &ChangedClip) -> Value {
    json!({
        "name": clip.name,
        "frames": clip.frames,
        "condition": clip.condition.name(),
        "displacement_m": <[f64; 3]>::from(clip.displacement),
        "scale": clip.condition.scale(),
        "methods": figures_json(&clip.methods),
    })
}
