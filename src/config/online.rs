//! The keys of the online tick: filter, tracker, window, safety.

use serde_json::{Value, json};

use super::fields::Fields;
use crate::filter::FilterSettings;
use crate::geometry::Point;
use crate::online::OnlineSettings;
use crate::safety::SafetySettings;
use crate::track::TrackSettings;

/// Every key of the tick, with its bounds.
pub(super) fn take(fields: &mut Fields, online: &mut OnlineSettings) {
    fields.float("tick.rate", &mut online.tick_rate, 1.0, 10_000.0);
    fields.float("tick.stop_after", &mut online.stop_after, 0.01, 60.0);
    take_filter(fields, &mut online.filter);
    take_track(fields, &mut online.track);
    fields.count("window.past", &mut online.past, 0, 60);
    fields.count("window.future", &mut online.future, 1, 120);
    fields.count("window.steps", &mut online.steps, 1, 10_000);
    fields.float("window.trust", &mut online.trust, 0.001, 60.0);
    fields.float("window.guess", &mut online.guess, 0.001, 600.0);
    fields.float("window.contact_hold", &mut online.contact_hold, 0.0, 60.0);
    fields.float("window.refactor", &mut online.refactor, 0.0, 1.0);
    take_safety(fields, &mut online.safety);
}

fn take_filter(fields: &mut Fields, filter: &mut FilterSettings) {
    fields.float("filter.confidence", &mut filter.confidence, 0.0, 1.0);
    fields.float("filter.joint_speed", &mut filter.joint_speed, 0.5, 50.0);
    fields.float("filter.joint_slack", &mut filter.joint_slack, 0.0, 1.0);
    fields.float("filter.bone_share", &mut filter.bone_share, 0.05, 5.0);
    fields.float("filter.believe", &mut filter.believe, 0.0, 5.0);
    fields.float("filter.min_cutoff", &mut filter.min_cutoff, 0.01, 100.0);
    fields.float("filter.cutoff_per_speed", &mut filter.cutoff_per_speed, 0.0, 100.0);
    fields.float("filter.speed_cutoff", &mut filter.speed_cutoff, 0.01, 100.0);
    fields.float("filter.bridge", &mut filter.bridge, 0.0, 2.0);
    fields.float("filter.joint_damping", &mut filter.joint_damping, 0.01, 10.0);
    fields.float("filter.body_damping", &mut filter.body_damping, 0.01, 10.0);
    fields.float("filter.carry", &mut filter.carry, 0.0, 2.0);
    fields.float("filter.body_speed", &mut filter.body_speed, 0.1, 20.0);
    fields.float("filter.body_slack", &mut filter.body_slack, 0.05, 2.0);
    fields.float("filter.settle", &mut filter.settle, 0.0, 10.0);
    fields.float("filter.forget", &mut filter.forget, 0.1, 60.0);
    fields.float("filter.stale", &mut filter.stale, 0.01, 10.0);
    fields.float("filter.swap", &mut filter.swap, 0.0, 10.0);
    fields.float("filter.clock_tolerance", &mut filter.clock_tolerance, 0.01, 10.0);
}

fn take_track(fields: &mut Fields, track: &mut TrackSettings) {
    fields.float("track.rate", &mut track.rate, 5.0, 120.0);
    fields.count("track.demonstrations", &mut track.demonstrations, 1, 1000);
    fields.float("track.velocity_window", &mut track.velocity_window, 0.001, 10.0);
    fields.float("track.velocity_weight", &mut track.velocity_weight, 0.0, 1000.0);
    fields.float("track.distance_weight", &mut track.distance_weight, 0.0, 100.0);
    fields.count("track.dimensions", &mut track.dimensions, 1, 1000);
    fields.float("track.spread", &mut track.spread, 0.001, 10.0);
    fields.float("track.start", &mut track.start, 0.01, 600.0);
    fields.float("track.pause", &mut track.pause, 0.0, 0.45);
    fields.float("track.hurry", &mut track.hurry, 0.0, 0.45);
    fields.float("track.restart", &mut track.restart, 0.01, 600.0);
    fields.float("track.leap", &mut track.leap, 0.0, 0.5);
    fields.float("track.memory", &mut track.memory, 0.001, 60.0);
    fields.float("track.pace_memory", &mut track.pace_memory, 0.001, 60.0);
    fields.float("track.strangeness", &mut track.strangeness, 0.01, 1000.0);
}

fn take_safety(fields: &mut Fields, safety: &mut SafetySettings) {
    fields.float("safety.speed", &mut safety.speed, 0.01, 10.0);
    fields.float("safety.acceleration", &mut safety.acceleration, 0.1, 100.0);
    fields.float("safety.jerk", &mut safety.jerk, 1.0, 10_000.0);
    fields.take(
        "safety.workspace",
        &mut safety.workspace,
        workspace,
        |workspace| json!(workspace.map_or(Vec::new(), |corners| corners.map(numbers).concat())),
        || {
            "no numbers, or six: the lowest x, y, z and the highest, each lower one below"
                .to_owned()
        },
    );
    fields.float("safety.separation", &mut safety.separation, 0.0, 5.0);
    fields.float("safety.partner_speed", &mut safety.partner_speed, 0.0, 5.0);
    fields.float("safety.lead", &mut safety.lead, 0.005, 0.5);
    fields.float("safety.aim", &mut safety.aim, 0.05, 1.0);
    if safety.aim < safety.lead {
        fields.refuse(
            "safety.aim",
            format!("is {}, must be at least safety.lead, {}", safety.aim, safety.lead),
        );
    }
    fields.float("safety.recover", &mut safety.recover, 0.0, 10.0);
}

fn numbers(corner: Point) -> Vec<f64> {
    corner.iter().copied().collect()
}

/// Two corners of a box, or none.
fn workspace(value: &Value) -> Option<Option<[Point; 2]>> {
    let numbers: Option<Vec<f64>> = value.as_array()?.iter().map(Value::as_f64).collect();
    let numbers = numbers?;
    if numbers.is_empty() {
        return Some(None);
    }
    let [low, high] = [numbers.get(..3)?, numbers.get(3..6)?].map(Point::from_slice);
    let fits = numbers.len() == 6 && (0..3).all(|axis| low[axis] < high[axis]);
    fits.then_some(Some([low, high]))
}
