//! Rows → two people with the same joints in every frame, and the object's track.
//!
//! A person's joints are those in at least half of the person's frames: a joint missing in one
//! frame is then named there, and a stray one where it strays, not in all the others.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::super::error::{Reason, Violations};
use super::super::rate;
use super::rows::{Row, Table, Who};
use super::{OBJECT, rows::FrameStart};
use crate::geometry::Point;
use crate::skeleton::{Frame, ObjectTrack, Person, PointTrack, Recording, Sequence, Skeleton};
use crate::time::Stamp;

/// The recording, unless something is wrong, which is noted.
pub(super) fn recording(
    name: &str,
    table: &Table,
    metadata: BTreeMap<String, String>,
    violations: &mut Violations,
) -> Option<Recording> {
    check_times(&table.frames, violations);
    if let ([] | [_], false) = (&table.people[..], table.frames.is_empty()) {
        let found = table.people.first().map(|(name, _)| name.clone());
        violations.add(table.frames[0].line, Reason::TooFewPeople { found });
    }
    let presence = presence(table, violations);
    let people: Vec<Body> = (0..table.people.len())
        .filter_map(|person| body(table, person, &presence[person], violations))
        .collect();
    if table.people.len() < 2 || people.len() < 2 {
        return None;
    }
    let frames = fill(table, &people, violations);
    if !violations.none() {
        return None;
    }
    finish(name, table, people, frames, metadata).map_err(|reason| violations.add(1, reason)).ok()
}

/// Notes times that do not rise and, if all do, where the rate changes.
fn check_times(frames: &[FrameStart], violations: &mut Violations) {
    let known = || frames.iter().filter_map(|frame| Some((frame.stamp?, frame)));
    let mut rising = true;
    for ((before, earlier), (time, frame)) in known().zip(known().skip(1)) {
        // Where the numbers fall that is noted already.
        if frame.number > earlier.number && time <= before {
            violations.add(frame.line, Reason::TimeOrder { frame: frame.number, time, before });
        }
        rising &= time > before;
    }
    if rising {
        let (stamps, lines): (Vec<Stamp>, Vec<u64>) =
            known().map(|(stamp, frame)| (stamp, frame.line)).unzip();
        rate::check(&stamps, &lines, violations);
    }
}

/// In how many frames a person's joints are.
#[derive(Clone, Default)]
struct Presence {
    /// Frames with any joint of the person.
    frames: usize,
    /// Of each joint of the table: its frames and its first line.
    joints: Vec<(usize, u64)>,
}

/// Counts, and notes what is twice in a frame.
fn presence(table: &Table, violations: &mut Violations) -> [Presence; 2] {
    let empty = Presence { frames: 0, joints: vec![(0, 0); table.joints.len()] };
    let mut presence = [empty.clone(), empty];
    // One slot for each joint of both people and for each point of the object.
    let mut seen = vec![None; 2 * table.joints.len() + table.points.len()];
    let mut last = [None; 2];
    for row in &table.rows {
        let slot = match row.who {
            Who::Joint { person, joint } => person * table.joints.len() + joint,
            Who::Object { point } => 2 * table.joints.len() + point,
        };
        if seen[slot].replace(row.frame) == Some(row.frame) {
            violations.add(row.line, repeated(table, row));
        } else if let Who::Joint { person, joint } = row.who {
            let presence = &mut presence[person];
            presence.frames += usize::from(last[person].replace(row.frame) != Some(row.frame));
            let (frames, first) = &mut presence.joints[joint];
            *frames += 1;
            *first = if *first == 0 { row.line } else { *first };
        }
    }
    presence
}

fn repeated(table: &Table, row: &Row) -> Reason {
    let (person, joint) = match row.who {
        Who::Joint { person, joint } => {
            (table.people[person].0.clone(), table.joints[joint].clone())
        }
        Who::Object { point } => (OBJECT.into(), table.points[point].clone()),
    };
    Reason::RepeatedJoint { frame: table.frames[row.frame].number, person, joint }
}

/// A person's joints in canonical order.
struct Body {
    skeleton: Arc<Skeleton>,
    /// Of each joint of the table, its place in the skeleton.
    places: Vec<Option<usize>>,
}

fn body(
    table: &Table,
    person: usize,
    presence: &Presence,
    violations: &mut Violations,
) -> Option<Body> {
    let (name, line) = &table.people[person];
    let mut names = Vec::new();
    for (joint, (frames, first)) in table.joints.iter().zip(&presence.joints) {
        if *frames > 0 && 2 * frames >= presence.frames {
            names.push(joint.clone());
        } else if *frames > 0 {
            let (person, joint) = (name.clone(), joint.clone());
            let reason = Reason::RareJoint { person, joint, frames: *frames, of: presence.frames };
            violations.add(*first, reason);
        }
    }
    if names.is_empty() {
        // Named, but none of its rows could be read, which is noted.
        return None;
    }
    Skeleton::sort_names(&mut names);
    let skeleton = match Skeleton::from_names(names) {
        Ok(skeleton) => skeleton,
        Err(source) => {
            // Where no frame is whole, lost rows are the reason, and they are noted.
            if table.frames.iter().any(|frame| !frame.damaged) {
                violations.add(*line, Reason::Skeleton { person: name.clone(), source });
            }
            return None;
        }
    };
    let place = |joint: &String| skeleton.joint(joint).map(|id| id.index());
    let places = table.joints.iter().map(place).collect();
    Some(Body { skeleton: Arc::new(skeleton), places })
}

/// Both people's frames; what is missing is noted.
fn fill(table: &Table, people: &[Body], violations: &mut Violations) -> [Vec<Frame>; 2] {
    let mut frames = [Vec::new(), Vec::new()];
    let mut rows = &table.rows[..];
    for (at, start) in table.frames.iter().enumerate() {
        let count = rows.iter().take_while(|row| row.frame == at).count();
        let (here, rest) = rows.split_at(count);
        rows = rest;
        for (person, body) in people.iter().enumerate() {
            let mut points: Vec<Option<Point>> = vec![None; body.skeleton.len()];
            for row in here {
                let Who::Joint { person: whose, joint } = row.who else { continue };
                if let (true, Some(place)) = (whose == person, body.places[joint]) {
                    points[place] = Some(row.point);
                }
            }
            if !start.damaged {
                note_missing(table, (start, person, body), &points, violations);
            }
            let positions = points.into_iter().map(|p| p.unwrap_or_else(Point::origin)).collect();
            let stamp = start.stamp.unwrap_or_default();
            frames[person].push(Frame { stamp, positions });
        }
    }
    frames
}

fn note_missing(
    table: &Table,
    (start, person, body): (&FrameStart, usize, &Body),
    points: &[Option<Point>],
    violations: &mut Violations,
) {
    let (frame, person) = (start.number, &table.people[person].0);
    if points.iter().all(Option::is_none) {
        return violations.add(start.line, Reason::MissingPerson { frame, person: person.clone() });
    }
    for (joint, _) in body.skeleton.names().iter().zip(points).filter(|(_, p)| p.is_none()) {
        let (person, joint) = (person.clone(), joint.clone());
        violations.add(start.line, Reason::MissingJoint { frame, person, joint });
    }
}

fn finish(
    name: &str,
    table: &Table,
    bodies: Vec<Body>,
    [first, second]: [Vec<Frame>; 2],
    metadata: BTreeMap<String, String>,
) -> Result<Recording, Reason> {
    let person = |at: usize, frames| {
        // Equal skeletons are shared, so that later comparisons are of pointers.
        let same = bodies.iter().find(|body| body.skeleton == bodies[at].skeleton);
        let skeleton = same.unwrap_or(&bodies[at]).skeleton.clone();
        let motion = Sequence::new(skeleton, frames)?;
        Ok::<_, Reason>(Person { name: table.people[at].0.clone(), motion })
    };
    let people = [person(0, first)?, person(1, second)?];
    let mut points: Vec<PointTrack> = Vec::new();
    points
        .extend(table.points.iter().map(|name| PointTrack { name: name.clone(), places: vec![] }));
    for row in &table.rows {
        if let (Who::Object { point }, Some(stamp)) = (row.who, table.frames[row.frame].stamp) {
            points[point].places.push((stamp, row.point));
        }
    }
    let object = (!points.is_empty()).then_some(ObjectTrack { points });
    Ok(Recording::new(name, people, object, metadata)?)
}
