//! The keys of the online tick: filter, tracker, window, safety.

use serde_json::{Value, json};

use super::Kind;
use super::fields::Fields;
use crate::geometry::Point;
use crate::online::OnlineSettings;
use crate::safety::SafetySettings;

/// Every key of the tick, with its bounds.
pub(super) fn take(fields: &mut Fields, online: &mut OnlineSettings) {
    fields.numbers(online.settings());
    fields.numbers(online.filter.settings());
    fields.numbers(online.track.settings());
    take_safety(fields, &mut online.safety);
}

fn take_safety(fields: &mut Fields, safety: &mut SafetySettings) {
    fields.float("safety.speed", &mut safety.speed, 0.01, 10.0);
    fields.float("safety.acceleration", &mut safety.acceleration, 0.1, 100.0);
    fields.float("safety.jerk", &mut safety.jerk, 1.0, 10_000.0);
    fields.take(
        "safety.workspace",
        Kind::Reals,
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
