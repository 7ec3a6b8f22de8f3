//! The lines of `:root` → where the root is at rest, and in which order its values come.

use super::super::error::{Reason, Violations};
use super::super::field;
use super::axes::{Axis, Order};
use super::lines::{AngleUnit, numbers, one_word, unknown};
use super::read_skeleton::{Slot, needed, put};
use super::skeleton::{RootAtRest, RootChannel};
use crate::geometry::Vector;

const POSITION: [&str; 3] = ["position x", "position y", "position z"];
const ORIENTATION: [&str; 3] = ["orientation x", "orientation y", "orientation z"];

/// What the lines so far say of the root.
#[derive(Default)]
pub(super) struct RootDraft {
    order: Slot<[RootChannel; 6]>,
    /// The order of the orientation's turns.
    axis: Slot<Order>,
    /// `[file's unit]`.
    position: Slot<[f64; 3]>,
    /// `[file's unit]`.
    orientation: Slot<[f64; 3]>,
}

impl RootDraft {
    /// Reads one line: a key and what it says.
    pub(super) fn line(&mut self, key: &str, rest: &str, line: u64, violations: &mut Violations) {
        match key {
            "order" => {
                let order = root_order(rest, line, violations);
                put(&mut self.order, order, key, line, violations);
            }
            "axis" => {
                let letters = one_word(rest, line, violations);
                let order = letters.and_then(|letters| axis_order(letters, line, violations));
                put(&mut self.axis, order, key, line, violations);
            }
            "position" => {
                let position = numbers(rest, POSITION, line, violations);
                put(&mut self.position, position, key, line, violations);
            }
            "orientation" => {
                let orientation = numbers(rest, ORIENTATION, line, violations);
                put(&mut self.orientation, orientation, key, line, violations);
            }
            _ => {
                let known = "order, axis, position, orientation";
                violations.add(line, unknown("key of the root", key, known));
            }
        }
    }

    /// The root at rest, unless something is wrong, which is noted.
    ///
    /// - `section`: the line that the root's section starts at, 0 if it has none.
    /// - `scale`: the file's unit of length `[m]`.
    pub(super) fn finish(
        self,
        section: u64,
        scale: f64,
        unit: AngleUnit,
        violations: &mut Violations,
    ) -> Option<RootAtRest> {
        let order = needed(self.order, "'order'", section, violations);
        let axis = needed(self.axis, "'axis'", section, violations);
        let position = needed(self.position, "'position'", section, violations);
        let orientation = needed(self.orientation, "'orientation'", section, violations);
        let position = position.map(|position| Vector::from(position) * scale);
        for (metres, name) in position.iter().flatten().zip(POSITION) {
            if let Err(reason) = field::within_reach(*metres, || name.into()) {
                violations.add(section, reason);
            }
        }
        let order = order?;
        Some(RootAtRest {
            order,
            turns: turning_order(&order),
            position: position?,
            frame: axis?.rotation(&orientation?.map(|angle| unit.to_radians(angle))),
        })
    }
}

/// `TX TY TZ RX RY RZ`, in any order.
fn root_order(text: &str, line: u64, violations: &mut Violations) -> Option<[RootChannel; 6]> {
    let words = text.split_ascii_whitespace();
    let got = words.clone().count();
    if got != 6 {
        violations.add(line, Reason::FieldCount { expected: 6, got });
        return None;
    }
    let mut order: Vec<RootChannel> = Vec::new();
    for word in words {
        let Some(channel) = root_channel(word) else {
            violations.add(line, unknown("value of the root", word, "TX, TY, TZ, RX, RY, RZ"));
            continue;
        };
        if order.contains(&channel) {
            violations.add(line, Reason::Repeated { what: format!("'{word}'") });
        }
        order.push(channel);
    }
    order.try_into().ok()
}

fn root_channel(word: &str) -> Option<RootChannel> {
    let mut letters = word.chars();
    let (kind, axis) = (letters.next()?, Axis::from_letter(letters.next()?)?);
    match (kind.to_ascii_lowercase(), letters.next()) {
        ('t', None) => Some(RootChannel::Translation(axis)),
        ('r', None) => Some(RootChannel::Rotation(axis)),
        _ => None,
    }
}

/// The axes in the order that the root's values name them.
fn turning_order(order: &[RootChannel; 6]) -> Order {
    let mut axes = order.iter().filter_map(|channel| match channel {
        RootChannel::Rotation(axis) => Some(*axis),
        RootChannel::Translation(_) => None,
    });
    let mut next = |otherwise| axes.next().unwrap_or(otherwise);
    Order([next(Axis::X), next(Axis::Y), next(Axis::Z)])
}

/// `XYZ` and its like.
pub(super) fn axis_order(letters: &str, line: u64, violations: &mut Violations) -> Option<Order> {
    let order = Order::from_letters(letters);
    if order.is_none() {
        let known = "XYZ, XZY, YXZ, YZX, ZXY, ZYX";
        violations.add(line, unknown("order of axes", letters, known));
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_roots_values_come_in_any_order() {
        let mut violations = Violations::default();
        let order = root_order("RZ TX rx TY TZ RY", 1, &mut violations).unwrap();
        assert_eq!(order[2], RootChannel::Rotation(Axis::X));
        assert_eq!(turning_order(&order), Order([Axis::Z, Axis::X, Axis::Y]));
        for text in ["TX TY TZ RX RY", "TX TY TZ RX RY RX", "TX TY TZ RX RY RW", "TX TY TZ RX RY é"]
        {
            let mut violations = Violations::default();
            let order = root_order(text, 1, &mut violations);
            assert!(violations.or(order).is_err(), "{text}");
        }
    }
}
