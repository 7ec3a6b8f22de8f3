//! How far forecasts of the partner are off: each clip by what was learned from the others.

use std::sync::Arc;

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::folds::folds;
use crate::demonstration::Demonstration;
use crate::forecast::{ForecastError, ForecastMethod, ForecastSettings, Forecaster, Moment};
use crate::geometry::Point;
use crate::skeleton::{Part, Sequence};
use crate::statistics::Summary;
use crate::time::Span;

/// A forecast is asked for once this much of the partner's motion has been seen `[s]`, or as much as
/// a velocity takes.
const SEEN: f64 = 0.3;

/// What an evaluation of forecasts may choose.
#[derive(Debug, Clone, PartialEq)]
pub struct ForecastProtocol {
    /// The columns.
    pub methods: Vec<ForecastMethod>,
    /// How many folds, where there are more than twenty groups; ≥ 2.
    pub folds: usize,
    /// How forecasts are made.
    pub settings: ForecastSettings,
}

/// One method's errors on one clip, horizon by horizon; `None` where the clip is too short.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ForecastErrors {
    /// Mean distance of the partner's active hand from where it came to be `[cm]`.
    pub wrist: Vec<Option<f64>>,
    /// Mean distance over all joints `[cm]`.
    pub joint: Vec<Option<f64>>,
}

/// One clip's errors by all methods.
#[derive(Debug, Clone, PartialEq)]
pub struct ForecastClip {
    /// The clip.
    pub name: String,
    /// Its length in frames.
    pub frames: usize,
    /// In the columns' order.
    pub methods: Vec<ForecastErrors>,
}

/// All clips and their summary.
#[derive(Debug, Clone, PartialEq)]
pub struct ForecastEvaluation {
    /// The columns.
    pub methods: Vec<ForecastMethod>,
    /// How far ahead `[s]`.
    pub horizons: Vec<f64>,
    /// The clips, in their own order.
    pub clips: Vec<ForecastClip>,
    /// Per method and horizon, of the active hand `[cm]`.
    pub wrist: Vec<Vec<Option<Summary>>>,
    /// Per method and horizon, of all joints `[cm]`.
    pub joint: Vec<Vec<Option<Summary>>>,
}

/// Why there is no evaluation of forecasts.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ForecastEvaluationError {
    /// Nobody is left to learn from.
    #[error("{groups} group(s) of clips; each is forecast from the others and needs one")]
    TooFew {
        /// How many groups there are.
        groups: usize,
    },
    /// A clip's partner is not like the first one's.
    #[error("{clip}: its partner has other joints than the first clip's")]
    Skeleton {
        /// The clip.
        clip: String,
    },
    /// Nothing was learned without a fold.
    #[error("without {left_out}: {error}")]
    Fold {
        /// The clips left out.
        left_out: String,
        /// Why.
        error: ForecastError,
    },
}

/// Forecasts each clip's partner by what was learned from the partners of other folds' clips.
///
/// At every frame with 0.3 s of past, from that past alone; the truth between two frames is
/// interpolated.
///
/// - `groups`: one per clip; clips of one group never learn from each other.
/// - `done`: called after each fold and each clip, from any thread.
///
/// # Errors
/// [`ForecastEvaluationError`].
/// # Panics
/// If there is not one group per clip.
pub fn forecast(
    clips: &[Arc<Demonstration>],
    groups: &[String],
    protocol: &ForecastProtocol,
    done: impl Fn() + Sync,
) -> Result<ForecastEvaluation, ForecastEvaluationError> {
    assert_eq!(clips.len(), groups.len(), "one group per clip");
    let folds = folds(groups, protocol.folds);
    let count = folds.iter().max().map_or(0, |last| last + 1);
    if count < 2 {
        return Err(ForecastEvaluationError::TooFew { groups: count });
    }
    let kind = |clip: &Demonstration| (clip.partner().skeleton().clone(), clip.partner_base());
    if let Some(other) = clips.iter().find(|clip| kind(clip) != kind(&clips[0])) {
        let clip = other.recording().name().to_owned();
        return Err(ForecastEvaluationError::Skeleton { clip });
    }
    let forecasters = (0..count).into_par_iter().map(|fold| {
        let others = clips.iter().zip(groups).zip(&folds).filter(|(_, f)| **f != fold);
        let fitted = fit(others.map(|(clip, _)| clip), groups, &protocol.settings);
        done();
        fitted.map_err(|error| {
            let own = clips.iter().zip(&folds).filter(|(_, f)| **f == fold);
            let names: Vec<&str> = own.map(|(clip, _)| clip.recording().name()).collect();
            ForecastEvaluationError::Fold { left_out: names.join(", "), error }
        })
    });
    // NOTE: collected straight into one result, the error kept would be that of any fold.
    let forecasters: Vec<Result<Forecaster, _>> = forecasters.collect();
    let forecasters: Vec<Forecaster> = forecasters.into_iter().collect::<Result<_, _>>()?;
    let clips: Vec<ForecastClip> = (clips.par_iter().zip(&folds))
        .map(|(clip, fold)| {
            let errors = clip_errors(clip, &forecasters[*fold], &protocol.methods);
            done();
            errors
        })
        .collect();
    Ok(ForecastEvaluation::new(protocol, clips))
}

fn fit<'a>(
    clips: impl Iterator<Item = (&'a Arc<Demonstration>, &'a String)>,
    groups: &[String],
    settings: &ForecastSettings,
) -> Result<Forecaster, ForecastError> {
    let clips: Vec<_> = clips.collect();
    let Some((first, _)) = clips.first() else {
        return Forecaster::fit(&[], crate::Skeleton::nite().root(), settings.clone());
    };
    let number =
        |group: &String| groups.iter().position(|known| known == group).unwrap_or(0) as u32;
    let motions: Vec<(&Sequence, u32)> =
        clips.iter().map(|(clip, group)| (clip.partner(), number(group))).collect();
    Forecaster::fit(&motions, first.partner_base(), settings.clone())
}

/// The mean errors over a clip's frames.
fn clip_errors(
    clip: &Demonstration,
    forecaster: &Forecaster,
    methods: &[ForecastMethod],
) -> ForecastClip {
    let partner = clip.partner();
    let skeleton = partner.skeleton();
    let own = skeleton.own();
    let hand = skeleton.part(Part::Hand(clip.contact().hands.partner));
    let horizons = forecaster.horizons();
    let truths = Truths::new(partner, forecaster);
    let mut workspace = forecaster.workspace();
    let mut moment = Moment::new(skeleton, clip.partner_base());
    let mut sums = vec![vec![Sum::default(); horizons.len()]; methods.len()];
    for frame in truths.asked() {
        moment.observe(skeleton, &partner.frames()[..=frame], forecaster.velocity_window());
        for (method, sums) in methods.iter().zip(&mut sums) {
            let joints = forecaster.forecast(*method, &moment, &mut workspace);
            for (horizon, sum) in sums.iter_mut().enumerate() {
                let Some(truth) = truths.at(frame, horizon) else { continue };
                let said = &joints[horizon * own..][..own];
                let off = |joint: usize| 100.0 * (said[joint] - truth[joint]).norm();
                sum.count += 1.0;
                sum.wrist += hand.map_or(f64::NAN, |hand| off(hand.index()));
                sum.joint += (0..own).map(off).sum::<f64>() / own as f64;
            }
        }
    }
    let mean = |value: fn(&Sum) -> f64| {
        move |sum: &Sum| {
            (sum.count > 0.0).then(|| value(sum) / sum.count).filter(|off| !off.is_nan())
        }
    };
    let errors = sums.iter().map(|sums| ForecastErrors {
        wrist: sums.iter().map(mean(|sum| sum.wrist)).collect(),
        joint: sums.iter().map(mean(|sum| sum.joint)).collect(),
    });
    let name = clip.recording().name().to_owned();
    ForecastClip { name, frames: partner.len(), methods: errors.collect() }
}

/// Sums over frames `[cm]`.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    count: f64,
    wrist: f64,
    joint: f64,
}

/// Where the joints came to be, after each frame and horizon.
struct Truths<'a> {
    motion: &'a Sequence,
    /// Frames with enough past.
    first: usize,
    /// `frames × horizons`.
    joints: Vec<Option<Box<[Point]>>>,
    horizons: usize,
}

impl<'a> Truths<'a> {
    fn new(motion: &'a Sequence, forecaster: &Forecaster) -> Self {
        let horizons = forecaster.horizons();
        let past = forecaster.velocity_window().max(SEEN);
        let stamps: Vec<_> = motion.stamps().collect();
        let (start, last) = (stamps[0], stamps[stamps.len() - 1]);
        // A nanosecond of rounding asks for no more past.
        let first = stamps.partition_point(|stamp| (*stamp - start).seconds() < past - 1e-6);
        let pairs = stamps.iter().flat_map(|stamp| horizons.iter().map(move |h| (*stamp, *h)));
        let joints = pairs.map(|(stamp, horizon)| {
            let then = stamp + Span::from_seconds(horizon)?;
            let pose = (then <= last).then(|| motion.resampled(&[then]).ok())??;
            Some(pose.frames()[0].positions.clone())
        });
        Self { motion, first, joints: joints.collect(), horizons: horizons.len() }
    }

    fn asked(&self) -> impl Iterator<Item = usize> + use<> {
        self.first..self.motion.len()
    }

    fn at(&self, frame: usize, horizon: usize) -> Option<&[Point]> {
        self.joints[frame * self.horizons + horizon].as_deref()
    }
}

impl ForecastEvaluation {
    fn new(protocol: &ForecastProtocol, clips: Vec<ForecastClip>) -> Self {
        let summaries = |of: fn(&ForecastErrors) -> &Vec<Option<f64>>| {
            let summary = |method: usize, horizon: usize| {
                let values = clips.iter().filter_map(|clip| of(&clip.methods[method])[horizon]);
                Summary::of(&values.collect::<Vec<_>>())
            };
            let each = 0..protocol.methods.len();
            let horizons = protocol.settings.horizons.len();
            each.map(|m| (0..horizons).map(|h| summary(m, h)).collect()).collect()
        };
        Self {
            methods: protocol.methods.clone(),
            horizons: protocol.settings.horizons.clone(),
            wrist: summaries(|errors| &errors.wrist),
            joint: summaries(|errors| &errors.joint),
            clips,
        }
    }

    /// `{"protocol":"forecast","role","horizons_ms":[…],"clips":[{"name","frames","methods":{METHOD:
    /// {"wrist_cm":[…],"joint_cm":[…]}}}],"summary":{METHOD:{"wrist_cm":[{"mean","median","low",
    /// "high","n"}],"joint_cm":[…]}}}`: a number or null per horizon.
    ///
    /// - `role`: the robot's; its partner is who was forecast.
    pub fn to_json(&self, role: &str) -> Value {
        let each = |value: &dyn Fn(usize) -> Value| {
            let methods = self.methods.iter().enumerate();
            Value::Object(
                methods.map(|(at, m)| (m.name().to_owned(), value(at))).collect::<Map<_, _>>(),
            )
        };
        let clips = self.clips.iter().map(|clip| {
            let errors = |at: usize| {
                let ForecastErrors { wrist, joint } = &clip.methods[at];
                json!({ "wrist_cm": wrist, "joint_cm": joint })
            };
            json!({ "name": clip.name, "frames": clip.frames, "methods": each(&errors) })
        });
        let summary = |summaries: &[Option<Summary>]| -> Vec<Value> {
            let of = |s: &Summary| json!({ "mean": s.mean, "median": s.median, "low": s.low, "high": s.high, "n": s.n });
            summaries.iter().map(|s| s.as_ref().map_or(Value::Null, of)).collect()
        };
        let milliseconds = self.horizons.iter().map(|horizon| (1e3 * horizon).round());
        json!({
            "protocol": "forecast",
            "role": role,
            "horizons_ms": milliseconds.collect::<Vec<_>>(),
            "clips": clips.collect::<Vec<_>>(),
            "summary": each(&|at| json!({
                "wrist_cm": summary(&self.wrist[at]),
                "joint_cm": summary(&self.joint[at]),
            })),
        })
    }
}
