//! What a tick was given and what it said, as a line of JSON: what replays write down.
//!
//! Inputs are written to the bit, but for places that are no numbers; the target to a micrometre, so
//! that its speed and acceleration can be looked at; the rest to a tenth of a millimetre. No clock
//! is in it: the same input gives the same bytes.

use serde_json::{Map, Value, json};

use super::{OnlineModel, Tick, TickInput};
use crate::filter::{Doubt, Filter, Partner};
use crate::geometry::{Point, is_finite};
use crate::skeleton::JointId;
use crate::track::Who;

/// The first line of a trace: what the numbers in the others are.
#[derive(Debug, Clone, Copy)]
pub struct TraceHeader<'a> {
    /// What was replayed.
    pub recording: &'a str,
    /// The person the robot stands in for.
    pub role: &'a str,
    /// How the robot's joints are found: the name of a [`crate::predict::Method`].
    pub method: &'a str,
    /// The names of the demonstrations, in the model's order.
    pub demonstrations: &'a [String],
    /// Every parameter by its key, as `Config::values` has them.
    pub parameters: &'a [(String, Value)],
}

impl TraceHeader<'_> {
    /// The version of the format.
    pub const VERSION: u32 = 1;

    /// The line, without its end.
    pub fn line(&self, model: &OnlineModel) -> String {
        let names = |who| model.library().skeleton(who).names();
        json!({
            "format": "handover_trace",
            "version": Self::VERSION,
            "units": "m, s, rad; stamps in ns",
            "recording": self.recording,
            "role": self.role,
            "method": self.method,
            "robot_joints": names(Who::Robot),
            "partner_joints": names(Who::Partner),
            "demonstrations": self.demonstrations,
            "parameters": self.parameters.iter().cloned().collect::<Map<_, _>>(),
        })
        .to_string()
    }
}

/// One tick as a line of JSON, without its end: the lines that follow [`TraceHeader::line`]. Of a
/// [`Replay`](super::Replay) `robot` is no measurement; what each key is says `docs/trace.md`:
///
#[doc = include_str!("../../docs/trace.md")]
///
/// # Example
///
/// ```
/// use handover_mesh::online::{OnlineModel, OnlineSettings, Pipeline, Replay, trace_line};
/// use serde_json::Value;
/// # use std::sync::Arc;
/// # use handover_mesh::demonstration::Demonstration;
/// # use handover_mesh::formats::{UpAxis, csv};
/// # use handover_mesh::predict::{PredictSettings, Predictor};
/// # use handover_mesh::track::TrackSettings;
/// # let demonstration = |far: f64| {
/// #     let mut text = "frame,time_s,person,joint,x,y,z\n".to_owned();
/// #     for frame in 0..40 {
/// #         let reach = 0.1 + far * (1.0 - (f64::from(frame) / 20.0 - 1.0).abs());
/// #         for (person, place, towards) in [("giver", 0.0, 1.0), ("receiver", 1.2, -1.0)] {
/// #             let height = 1.1 + far * (f64::from(frame) / 7.0).sin() / 5.0;
/// #             let arm = [("right_elbow", reach / 2.0, 1.2), ("right_hand", reach, height)];
/// #             let lean = (f64::from(frame) / 11.0).sin() / 20.0;
/// #             let body = [("neck", lean, 1.5), ("torso", 0.0, 1.2), ("right_shoulder", 0.0, 1.4)];
/// #             for (joint, out, height) in body.into_iter().chain(arm) {
/// #                 let time = f64::from(frame) / 30.0;
/// #                 let side = if joint.starts_with("right") { -0.2 * towards } else { 0.0 };
/// #                 let x = place + towards * out;
/// #                 text += &format!("{frame},{time},{person},{joint},{x},{side},{height}\n");
/// #             }
/// #         }
/// #     }
/// #     let recording = csv::read(text.as_bytes(), "clip", UpAxis::Z).unwrap();
/// #     Arc::new(Demonstration::new(Arc::new(recording), "giver", "torso").unwrap())
/// # };
/// # let demonstrations = [0.4, 0.45, 0.5].map(demonstration);
/// # let predictor = Predictor::fit(demonstrations.to_vec(), PredictSettings::default())?;
/// # // A few clean moments span no more.
/// # let track = TrackSettings { dimensions: 2, ..TrackSettings::default() };
/// # let settings = OnlineSettings { track, ..OnlineSettings::default() };
/// let model = Arc::new(OnlineModel::new(&predictor, settings)?);
/// let seen = demonstrations[0].observation();
/// let mut pipeline = Pipeline::new(model.clone(), &seen.bone_lengths, true)?;
/// let mut replay = Replay::new(&seen, model.settings().tick_rate);
/// let mut lines = Vec::new();
/// while let Some((_, input)) = replay.next_tick() {
///     lines.push(trace_line(&model, &input, &pipeline.tick(&input)));
/// }
/// let last: Value = serde_json::from_str(&lines[39])?;
/// assert_eq!(last["now"], seen.partner.frames()[39].stamp.0);
/// // What came in, to the bit; where the robot is to be.
/// assert_eq!(last["sighting"]["positions"][0][2], 1.5);
/// assert_eq!(last["target"].as_array().map(Vec::len), Some(5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn trace_line(model: &OnlineModel, input: &TickInput<'_>, tick: &Tick<'_>) -> String {
    let step = model.library().step().seconds();
    let belief = tick.belief;
    let followed: Vec<Value> = belief
        .followed
        .iter()
        .map(|followed| {
            json!({
                "demonstration": followed.exemplar,
                "weight": rounded(followed.weight),
                "time": rounded(followed.frame * step),
                "yaw": rounded(followed.turn.angle()),
            })
        })
        .collect();
    let sides = [belief.hands.robot, belief.hands.partner].map(|side| side.name());
    let joints = model.library().skeleton(Who::Robot).len();
    let line = json!({
        "now": input.now.0,
        "sighting": input.sighting.map(|sighting| json!({
            "stamp": sighting.stamp.0,
            "body": sighting.body,
            "positions": points(sighting.positions, |value| value),
            "confidences": sighting.confidences,
        })),
        "robot": input.robot.map(|robot| points(robot, |value| value)),
        "partner": tick.partner.map(|partner| points(partner, rounded)),
        "seen": seen(model, tick.filter),
        "phase": {
            "followed": followed,
            "hands": sides,
            "contact_in": rounded(belief.contact * step),
            "tempo": rounded(belief.tempo),
            "distance": rounded(belief.distance),
            "turned": rounded(belief.turned),
            "familiar": belief.is_familiar,
        },
        "reference": tick.solved.map(|solved| points(solved.reference, rounded)),
        "solution": tick.solved.map(|solved| points(&solved.poses[..joints], rounded)),
        "residual": tick.solved.map(|solved| json!({
            "steps": solved.residual.steps,
            "last_step": finely(solved.residual.last_step),
            "bones": finely(solved.residual.bones),
        })),
        "target": tick.target.map(|target| points(target.positions(), finely)),
        "stands_in": tick.target.map(|target| rounded(target.stands_in().seconds())),
        "reason": tick.reason.map(|reason| reason.name()),
    });
    line.to_string()
}

/// What of the partner's skeleton is seen, mended and missing.
fn seen(model: &OnlineModel, filter: &Filter) -> Value {
    let skeleton = model.library().skeleton(Who::Partner);
    let partner = filter.partner().ok();
    let names = |is_meant: &dyn Fn(Partner<'_>, JointId) -> bool| {
        partner.map(|partner| {
            let own = skeleton.joints().take(skeleton.own());
            let joints = own.filter(|joint| is_meant(partner, *joint));
            joints.map(|joint| skeleton.name(joint)).collect::<Vec<_>>()
        })
    };
    json!({
        "ignored": filter.ignored().map(Doubt::name),
        "unseen": names(&|partner, joint| !partner.is_tracked(joint)),
        "lost": names(&|partner, joint| partner.is_lost(joint)),
        "swapped": partner.map(|partner| partner.swapped()),
    })
}

/// `[[x, y, z], …]`; what is no place is null.
fn points(points: &[Point], number: impl Fn(f64) -> f64) -> Value {
    let points = points.iter().map(|point| {
        if is_finite(point) {
            json!([number(point.x), number(point.y), number(point.z)])
        } else {
            Value::Null
        }
    });
    Value::Array(points.collect())
}

/// To a tenth of a millimetre (and of a millisecond, and of a milliradian); never `-0`.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4 + 0.0
}

/// To a micrometre; never `-0`.
fn finely(metres: f64) -> f64 {
    (metres * 1e6).round() / 1e6 + 0.0
}
