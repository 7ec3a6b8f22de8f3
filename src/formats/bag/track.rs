//! Somebody's messages → places of the same joints at rising stamps, where they are known.
//!
//! A joint is one of the person's if it is tracked in at least half of the messages; what is
//! tracked now and then only is left out, which is said.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::super::error::{Place, Reason, Violations, shortened};
use super::super::field::FARTHEST;
use super::super::rate;
use super::super::up::UpAxis;
use super::collect::Track;
use super::people::Candidate;
use crate::frames::FrameTree;
use crate::geometry::Point;
use crate::skeleton::{Part, Skeleton, SkeletonError};
use crate::time::Stamp;

/// Places by frame and joint; at least one frame.
pub(super) struct Timeline {
    pub(super) name: String,
    pub(super) topic: String,
    pub(super) skeleton: Arc<Skeleton>,
    /// Rising.
    pub(super) stamps: Vec<Stamp>,
    /// The message of each stamp.
    pub(super) numbers: Vec<u64>,
    /// `frames × joints`.
    pub(super) places: Vec<Option<Point>>,
}

impl Timeline {
    /// The place of a message in the file.
    pub(super) fn message(&self, frame: usize) -> Place {
        Place::Message { topic: self.topic.clone(), number: self.numbers[frame] }
    }

    /// Notes where the rate changes: it may where frames are not at these stamps.
    pub(super) fn check_rate(&self, violations: &mut Violations) {
        let messages: Vec<Place> = (0..self.stamps.len()).map(|at| self.message(at)).collect();
        rate::check(&self.stamps, &messages, violations);
    }

    /// Where the joints are at a frame.
    pub(super) fn frame(&self, frame: usize) -> &[Option<Point>] {
        let joints = self.skeleton.len();
        &self.places[frame * joints..(frame + 1) * joints]
    }
}

/// How a track's places are seen from the frame of all: nothing changes in that frame itself.
pub(super) struct View<'a> {
    pub(super) frame: &'a str,
    pub(super) tree: &'a FrameTree,
    pub(super) up: UpAxis,
}

impl View<'_> {
    /// Turns a track's places into the frame of all, which is noted.
    pub(super) fn turn(
        &self,
        track: &mut Track,
        notes: &mut Vec<String>,
        violations: &mut Violations,
    ) {
        let mut turned = None;
        for seen in &mut track.seen {
            let place = || Place::Message { topic: track.topic.clone(), number: seen.number };
            if *seen.frame != *self.frame {
                let between = self.tree.between(self.frame, &seen.frame, [seen.stamp; 2]);
                let Some(here_from_there) = between else {
                    let (frame, other) = (shortened(&seen.frame), shortened(self.frame));
                    violations.add(place(), Reason::Frames { frame, other });
                    continue;
                };
                for point in &mut seen.places {
                    *point = here_from_there * *point;
                }
                turned.get_or_insert((seen.frame.clone(), 0)).1 += 1;
            }
            for (name, point) in seen.names.iter().zip(&mut seen.places) {
                if let Some(metres) = point.iter().copied().find(|c| c.abs() > FARTHEST) {
                    violations.add(place(), Reason::TooFar { field: shortened(name), metres });
                }
                *point = self.up.to_z_up(*point);
            }
        }
        if let Some((from, count)) = turned {
            let (from, to) = (shortened(&from), shortened(self.frame));
            let (topic, total) = (shortened(&track.topic), track.seen.len());
            notes.push(format!(
                "brought from frame '{from}' into '{to}': {count} of {total} messages of {topic}"
            ));
        }
    }
}

/// Sorts out joints and stamps; `None` if the joints are no skeleton, which is noted.
pub(super) fn timeline(
    candidate: Candidate,
    notes: &mut Vec<String>,
    violations: &mut Violations,
) -> Option<Timeline> {
    let Candidate { name, mut track } = candidate;
    in_time(&mut track, violations);
    let names = joints(&name, &track, notes, violations);
    let skeleton = match Skeleton::from_names(names) {
        Ok(skeleton) => Arc::new(skeleton),
        // Which are not known has been noted.
        Err(SkeletonError::Unknown { .. }) => return None,
        Err(source) => {
            violations.add(Place::File, Reason::Skeleton { person: name, source });
            return None;
        }
    };
    let mut places = vec![None; track.seen.len() * skeleton.len()];
    for (seen, row) in track.seen.iter().zip(places.chunks_exact_mut(skeleton.len())) {
        for (joint, place) in seen.names.iter().zip(&seen.places) {
            if let Some(joint) = skeleton.joint(joint) {
                row[joint.index()] = Some(*place);
            }
        }
    }
    let (numbers, stamps): (Vec<u64>, Vec<Stamp>) =
        track.seen.iter().map(|seen| (seen.number, seen.stamp)).unzip();
    Some(Timeline { name, topic: track.topic, skeleton, stamps, numbers, places })
}

/// Leaves out what was sent twice, and notes stamps that do not rise.
pub(super) fn in_time(track: &mut Track, violations: &mut Violations) {
    track.seen.dedup_by(|next, seen| next.same(seen));
    for pair in track.seen.windows(2) {
        let [seen, next] = pair else { continue };
        if next.stamp <= seen.stamp {
            let place = Place::Message { topic: track.topic.clone(), number: next.number };
            violations.add(place, Reason::StampOrder { time: next.stamp, before: seen.stamp });
        }
    }
}

/// The names of the joints that are tracked in at least half of the messages, in canonical order.
fn joints(
    person: &str,
    track: &Track,
    notes: &mut Vec<String>,
    violations: &mut Violations,
) -> Vec<String> {
    let mut counts: BTreeMap<&str, (usize, u64)> = BTreeMap::new();
    for seen in &track.seen {
        for joint in seen.names.iter() {
            counts.entry(joint).or_insert((0, seen.number)).0 += 1;
        }
    }
    let frames = track.seen.len();
    let mut names = Vec::new();
    for (joint, (count, first)) in counts {
        if Part::from_name(joint).is_none() {
            let (person, joint) = (person.to_owned(), shortened(joint));
            let place = Place::Message { topic: track.topic.clone(), number: first };
            violations.add(place, Reason::UnknownJoint { person, joint });
        }
        if 2 * count >= frames {
            names.push(joint.to_owned());
        } else {
            let joint = shortened(joint);
            notes.push(format!(
                "left out: '{joint}' of {person}, tracked in {count} of {frames} messages"
            ));
        }
    }
    Skeleton::sort_names(&mut names);
    names
}
