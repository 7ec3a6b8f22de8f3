//! The lines between `begin` and `end` of a bone → a [`Bone`].

use super::super::error::{Reason, Violations, shortened};
use super::super::field;
use super::axes::{Axis, Order};
use super::lines::{AngleUnit, first_word, numbers, one_word, unknown};
use super::read_root::axis_order;
use super::read_skeleton::{Slot, put, take};
use super::skeleton::{Bone, Dof};
use crate::geometry::Vector;

/// What the lines so far say of a bone.
pub(super) struct BoneDraft<'a> {
    /// The line of its `begin`.
    pub(super) start: u64,
    pub(super) name: Slot<&'a str>,
    pub(super) id: Slot<u64>,
    /// As the file has it.
    direction: Slot<Vector>,
    /// `[file's unit]`.
    length: Slot<f64>,
    /// Angles `[file's unit]` about x, y and z.
    axis: Slot<([f64; 3], Order)>,
    dofs: Slot<Vec<Axis>>,
    /// Pairs `[file's unit]`.
    limits: Slot<Vec<[f64; 2]>>,
    limits_line: u64,
    /// The line before was one of limits, so one that starts with a bracket goes on with them.
    in_limits: bool,
}

const DIRECTION: [&str; 3] = ["direction x", "direction y", "direction z"];
const KEYS: &str = "id, name, direction, length, axis, dof, limits, bodymass, cofmass";

impl<'a> BoneDraft<'a> {
    pub(super) fn new(start: u64) -> Self {
        Self {
            start,
            name: None,
            id: None,
            direction: None,
            length: None,
            axis: None,
            dofs: None,
            limits: None,
            limits_line: start,
            in_limits: false,
        }
    }

    /// What messages call the bone.
    pub(super) fn label(&self) -> &'a str {
        self.name.flatten().unwrap_or("?")
    }

    /// Reads one line.
    pub(super) fn line(&mut self, text: &'a str, line: u64, violations: &mut Violations) {
        if text.starts_with('(') && self.in_limits {
            return self.more_limits(text, line, violations);
        }
        let (word, rest) = first_word(text);
        self.in_limits = word == "limits";
        match word {
            "name" => {
                let name = one_word(rest, line, violations);
                put(&mut self.name, name, word, line, violations);
            }
            "id" => {
                let id = one_word(rest, line, violations).and_then(|id| {
                    let id = field::frame_number(id, || word.into());
                    id.map_err(|reason| violations.add(line, reason)).ok()
                });
                put(&mut self.id, id, word, line, violations);
            }
            "direction" => {
                let direction = numbers(rest, DIRECTION, line, violations).map(Vector::from);
                put(&mut self.direction, direction, word, line, violations);
            }
            "length" => {
                let length = length(rest, line, violations);
                put(&mut self.length, length, word, line, violations);
            }
            "axis" => {
                let axis = axis(rest, line, violations);
                put(&mut self.axis, axis, word, line, violations);
            }
            "dof" => {
                let dofs = dofs(rest, line, violations);
                put(&mut self.dofs, dofs, word, line, violations);
            }
            "limits" => {
                put(&mut self.limits, Some(Vec::new()), word, line, violations);
                self.limits_line = line;
                self.more_limits(rest, line, violations);
            }
            // Masses move nothing here.
            "bodymass" | "cofmass" => {}
            _ => violations.add(line, unknown("key of a bone", word, KEYS)),
        }
    }

    /// Pairs in brackets, some on a line.
    fn more_limits(&mut self, text: &str, line: u64, violations: &mut Violations) {
        let mut rest = text.trim();
        while !rest.is_empty() {
            let inside = rest.strip_prefix('(').and_then(|inside| inside.split_once(')'));
            let found = inside.and_then(|(inside, after)| Some((pair(inside)?, after)));
            let Some((pair, after)) = found else {
                violations.add(line, Reason::NotLimits { value: shortened(rest) });
                self.limits = Some(None);
                return;
            };
            if let Some(Some(limits)) = &mut self.limits {
                limits.push(pair);
            }
            rest = after.trim_start();
        }
    }

    /// The bone, unless something is wrong, which is noted. Where it hangs is not known here.
    ///
    /// - `scale`: the file's unit of length `[m]`.
    pub(super) fn finish(
        self,
        scale: f64,
        unit: AngleUnit,
        first_channel: usize,
        violations: &mut Violations,
    ) -> Option<Bone> {
        let label = shortened(self.label());
        let key = |key: &str| format!("'{key}' of bone '{label}'");
        let name = take(self.name, || key("name"), self.start, violations);
        let direction = take(self.direction, || key("direction"), self.start, violations);
        let length = take(self.length, || key("length"), self.start, violations);
        let axis = take(self.axis, || key("axis"), self.start, violations);
        let direction = direction.and_then(|direction| {
            let unit = at_unit_length(direction);
            if unit.is_none() {
                violations.add(self.start, Reason::NoDirection { bone: label.clone() });
            }
            unit
        });
        let length = length.and_then(|length| {
            let metres = field::within_reach(length * scale, || format!("length of {label}"));
            metres.map_err(|reason| violations.add(self.start, reason)).ok()
        });
        let axes = self.dofs.unwrap_or(Some(Vec::new()));
        let limits = self.limits.unwrap_or(Some(Vec::new()));
        if let (Some(axes), Some(limits)) = (&axes, &limits) {
            let (expected, got) = (axes.len(), limits.len());
            // Limits may be left out, but not some of them.
            if got != expected && (got > 0 || self.limits_line != self.start) {
                let of = format!("limits of {label}");
                violations.add(self.limits_line, Reason::ValueCount { of, expected, got });
            }
        }
        let limits = limits?;
        let limits = |at: usize| Some(limits.get(at)?.map(|angle| unit.to_radians(angle)));
        let dofs = axes?.into_iter().enumerate();
        let (angles, order) = axis?;
        Some(Bone {
            name: name?.to_owned(),
            id: self.id.flatten(),
            parent: None,
            length: length?,
            direction: direction?,
            frame: order.rotation(&angles.map(|angle| unit.to_radians(angle))),
            dofs: dofs.map(|(at, axis)| Dof { axis, limits: limits(at) }).collect(),
            first_channel,
        })
    }
}

fn length(text: &str, line: u64, violations: &mut Violations) -> Option<f64> {
    let [value] = numbers(text, ["length"], line, violations)?;
    if value < 0.0 {
        let (field, bound) = ("length".into(), "0 or more");
        violations.add(line, Reason::OutOfBounds { field, value, bound });
        return None;
    }
    Some(value)
}

/// `0 0 20 XYZ`: angles about x, y and z, and which turns first.
fn axis(text: &str, line: u64, violations: &mut Violations) -> Option<([f64; 3], Order)> {
    let text = text.trim_end();
    let cut = text.rfind(|letter: char| letter.is_ascii_whitespace()).map_or(0, |at| at + 1);
    let got = text.split_ascii_whitespace().count();
    if got != 4 {
        violations.add(line, Reason::FieldCount { expected: 4, got });
        return None;
    }
    let (angles, letters) = text.split_at(cut);
    let angles = numbers(angles, ["axis x", "axis y", "axis z"], line, violations);
    let order = axis_order(letters, line, violations);
    Some((angles?, order?))
}

/// `rx ry rz`, or some of them, each once.
fn dofs(text: &str, line: u64, violations: &mut Violations) -> Option<Vec<Axis>> {
    let (mut found, mut good) = (Vec::new(), true);
    for word in text.split_ascii_whitespace() {
        let axis = match word.to_ascii_lowercase().as_str() {
            "rx" => Axis::X,
            "ry" => Axis::Y,
            "rz" => Axis::Z,
            _ => {
                violations.add(line, unknown("degree of freedom", word, "rx, ry, rz"));
                good = false;
                continue;
            }
        };
        if found.contains(&axis) {
            violations.add(line, Reason::Repeated { what: format!("'{word}'") });
            good = false;
        } else {
            found.push(axis);
        }
    }
    good.then_some(found)
}

/// `-160 20`: the least and the greatest; `-inf` and `inf` leave an end open.
fn pair(text: &str) -> Option<[f64; 2]> {
    let mut words = text.split_ascii_whitespace().map(|word| word.parse::<f64>().ok());
    let pair = [words.next()??, words.next()??];
    // NaN is in no order.
    (words.next().is_none() && pair[0] <= pair[1]).then_some(pair)
}

/// The direction at length 1, whatever its own; `None` if it has none.
fn at_unit_length(direction: Vector) -> Option<Vector> {
    let largest = direction.amax();
    // By the largest first: squares of the largest numbers there are would overflow.
    (largest > 0.0).then(|| (direction / largest).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_pairs_in_order() {
        assert_eq!(pair("-160.0 20.0"), Some([-160.0, 20.0]));
        assert_eq!(pair(" -inf  inf "), Some([f64::NEG_INFINITY, f64::INFINITY]));
        for text in ["", "1", "1 2 3", "2 1", "NaN 1", "a b"] {
            assert_eq!(pair(text), None, "{text}");
        }
    }

    #[test]
    fn directions_of_any_length_have_length_one() {
        for scale in [1e-320, 1e-9, 1.0, 1e300] {
            let unit = at_unit_length(Vector::new(3.0, 0.0, -4.0) * scale).unwrap();
            assert!((unit - Vector::new(0.6, 0.0, -0.8)).norm() < 1e-3, "{scale}: {unit}");
            assert!((unit.norm() - 1.0).abs() < 1e-15, "{scale}: {unit}");
        }
        assert_eq!(at_unit_length(Vector::zeros()), None);
    }
}
