//! What a tick was given and what it said, as a line of JSON: what replays write down.
//!
//! Inputs are written to the bit, so that a trace can be replayed; the rest to a tenth of a
//! millimetre. No clock is in it: the same input gives the same bytes.

use serde_json::{Value, json};

use super::{OnlineModel, Tick, TickInput};
use crate::geometry::{Point, is_finite};
use crate::track::Who;

/// The first line of a trace: what the numbers in the others are.
#[derive(Debug, Clone, Copy)]
pub struct TraceHeader<'a> {
    /// What was replayed.
    pub recording: &'a str,
    /// The person the robot stands in for.
    pub role: &'a str,
    /// The names of the demonstrations, in the model's order.
    pub demonstrations: &'a [String],
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
            "robot_joints": names(Who::Robot),
            "partner_joints": names(Who::Partner),
            "horizon_step_ns": model.library().step().0,
            "demonstrations": self.demonstrations,
        })
        .to_string()
    }
}

/// One tick as a line of JSON, without its end: `{"now","sighting":{"stamp","positions"},"robot",
/// "partner","phase":{"followed":[{"demonstration","weight","time","yaw"}],"hands","contact_in",
/// "tempo","distance","familiar"},"reference","solution","residual":{"steps","last_step","bones"},
/// "target","velocity","stands_in","reason"}`; points are `[x, y, z]`, what is not known is null.
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
                "yaw": rounded(followed.yaw),
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
        })),
        "robot": input.robot.map(|robot| points(robot, |value| value)),
        "partner": tick.partner.map(|partner| points(partner, rounded)),
        "phase": {
            "followed": followed,
            "hands": sides,
            "contact_in": rounded(belief.contact * step),
            "tempo": rounded(belief.tempo),
            "distance": rounded(belief.distance),
            "familiar": belief.is_familiar,
        },
        "reference": tick.solved.map(|solved| points(solved.reference, rounded)),
        "solution": tick.solved.map(|solved| points(&solved.poses[..joints], rounded)),
        "residual": tick.solved.map(|solved| json!({
            "steps": solved.residual.steps,
            "last_step": rounded(solved.residual.last_step),
            "bones": rounded(solved.residual.bones),
        })),
        "target": tick.target.map(|target| points(target.positions(), rounded)),
        "stands_in": tick.target.map(|target| rounded(target.stands_in().seconds())),
        "reason": tick.reason.map(|reason| reason.name()),
    });
    line.to_string()
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
