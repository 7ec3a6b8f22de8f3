//! SBU Kinect Interaction text → a [`Recording`].
//!
//! A line is `frame, A 15×(x, y, z), B 15×(x, y, z)`, normalised to the depth image. In metres, z
//! up, right-handed: `x = 1.28 − 2.56·x'`, `y = −1.28·z'`, `z = 0.96 − 1.92·y'` (the set's own
//! document, K. Yun et al., HAU3D 2012, turned from y up to z up); x grows to the camera's left.
//! Everybody's right shoulder then lies on their right, which a test holds.
//!
//! Mends no lost tracking: what the sensor saw is what comes out.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::detect::without_mark;
use super::error::{ReadError, Reason, Violations};
use super::{field, rate};
use crate::geometry::Point;
use crate::skeleton::{Frame, Person, Recording, Sequence, Skeleton};
use crate::time::Stamp;

/// Fields of a line: the frame's number and 2·15·3 coordinates.
pub(super) const FIELDS: usize = 91;
const JOINTS: usize = 15;
/// Both people's names, in a line's order.
const NAMES: [&str; 2] = ["A", "B"];
const FRAMES_PER_SECOND: i128 = 15;

/// Reads SBU text; the people are called `A` and `B`, in metres, z up.
///
/// The first frame is at 0 s, the others at their numbers' distance from it over 15 Hz.
///
/// - `name`: what reports call the clip.
///
/// # Errors
/// [`ReadError`] lists every violation: fields, numbers, frames that do not rise, mixed rates.
pub fn read(bytes: &[u8], name: &str) -> Result<Recording, ReadError> {
    let skeleton = Skeleton::nite();
    let mut violations = Violations::default();
    let mut lines = Vec::new();
    for (number, line) in (1..).zip(without_mark(bytes).split(|byte| *byte == b'\n')) {
        if line.trim_ascii().is_empty() {
            continue;
        }
        if let Some((frame, people)) = read_line(line, number, &skeleton, &mut violations) {
            lines.push(Line { number, frame, people });
        }
    }
    if lines.is_empty() && violations.none() {
        violations.add(1, Reason::Empty);
    }
    let stamps = stamps(&lines, &mut violations);
    if violations.none() {
        let starts: Vec<u64> = lines.iter().map(|line| line.number).collect();
        rate::check(&stamps, &starts, &mut violations);
    }
    if !violations.none() {
        return violations.or(None);
    }
    let mut frames = [Vec::with_capacity(lines.len()), Vec::with_capacity(lines.len())];
    for (line, stamp) in lines.into_iter().zip(stamps) {
        for (frames, positions) in frames.iter_mut().zip(line.people) {
            frames.push(Frame { stamp, positions });
        }
    }
    let recording = recording(name, &skeleton, frames).map_err(|reason| violations.add(1, reason));
    violations.or(recording.ok())
}

/// What a line holds: both people's joints `[m]`, z up.
struct Line {
    number: u64,
    frame: u64,
    people: [Box<[Point]>; 2],
}

fn read_line(
    line: &[u8],
    number: u64,
    skeleton: &Skeleton,
    violations: &mut Violations,
) -> Option<(u64, [Box<[Point]>; 2])> {
    let Ok(text) = std::str::from_utf8(line) else {
        violations.add(number, Reason::NotUtf8);
        return None;
    };
    let got = text.split(',').count();
    if got != FIELDS {
        violations.add(number, Reason::FieldCount { expected: FIELDS, got });
        return None;
    }
    let mut fields = text.split(',');
    let mut frame = None;
    let mut values = [0.0; FIELDS - 1];
    let mut note = |reason| violations.add(number, reason);
    if let Some(first) = fields.next() {
        frame = field::frame_number(first, || "frame".into()).map_err(&mut note).ok();
    }
    let mut good = true;
    for (at, (text, value)) in fields.zip(&mut values).enumerate() {
        let label = || field_name(at, skeleton);
        match field::number(text, label) {
            Ok(number) => *value = number,
            Err(reason) => {
                good = false;
                note(reason);
            }
        }
    }
    if !good {
        return None;
    }
    let mut people = values.chunks_exact(3 * JOINTS).map(|person| {
        let points = person.chunks_exact(3);
        points.map(|at| metres(at[0], at[1], at[2])).collect::<Box<[Point]>>()
    });
    let people = [people.next()?, people.next()?];
    let coordinates = people.iter().flatten().flat_map(|point| point.iter());
    for (at, metres) in coordinates.enumerate() {
        if let Err(reason) = field::within_reach(*metres, || field_name(at, skeleton)) {
            good = false;
            note(reason);
        }
    }
    frame.filter(|_| good).map(|frame| (frame, people))
}

/// Normalised image coordinates → metres, z up.
fn metres(x: f64, y: f64, z: f64) -> Point {
    Point::new(1.28 - 2.56 * x, -1.28 * z, 0.96 - 1.92 * y)
}

/// `B right_hand y` for the coordinate at `at` of 90.
fn field_name(at: usize, skeleton: &Skeleton) -> String {
    let (person, joint, axis) = (at / (3 * JOINTS), at / 3 % JOINTS, at % 3);
    format!("{} {} {}", NAMES[person], skeleton.names()[joint], ["x", "y", "z"][axis])
}

fn stamps(lines: &[Line], violations: &mut Violations) -> Vec<Stamp> {
    let first = lines.first().map_or(0, |line| line.frame);
    for pair in lines.windows(2) {
        let (before, frame) = (pair[0].frame, pair[1].frame);
        if frame <= before {
            violations.add(pair[1].number, Reason::FrameOrder { frame, before });
        }
    }
    let stamp = |line: &Line, violations: &mut Violations| {
        let ticks = (i128::from(line.frame) - i128::from(first)) * 1_000_000_000;
        let nearest = (ticks + FRAMES_PER_SECOND / 2).div_euclid(FRAMES_PER_SECOND);
        i64::try_from(nearest).map(Stamp).unwrap_or_else(|_| {
            let value = line.frame.to_string();
            violations.add(line.number, Reason::TimeOutOfRange { field: "frame".into(), value });
            Stamp::default()
        })
    };
    lines.iter().map(|line| stamp(line, violations)).collect()
}

fn recording(
    name: &str,
    skeleton: &Arc<Skeleton>,
    frames: [Vec<Frame>; 2],
) -> Result<Recording, Reason> {
    let person = |name: &str, frames| {
        let motion = Sequence::new(skeleton.clone(), frames)?;
        Ok::<_, Reason>(Person { name: name.into(), motion })
    };
    let [a, b] = frames;
    let people = [person(NAMES[0], a)?, person(NAMES[1], b)?];
    Ok(Recording::new(name, people, None, BTreeMap::new())?)
}
