//! Places that are known now and then → places at every frame, or why not.
//!
//! A joint that is not tracked for at most half a second is put on the line between where it was
//! and where it is again. Before and behind all that is known nothing is made up: such frames are
//! left out.

use super::super::error::{Reason, Violations};
use super::track::Timeline;
use crate::geometry::Point;
use crate::skeleton::Frame;
use crate::time::{Span, Stamp};

/// For so long a joint may be out of sight.
pub(super) const LONGEST: Span = Span(500_000_000);

/// A person whose joints are all known at every frame.
pub(super) struct Whole {
    pub(super) timeline: Timeline,
    pub(super) frames: Vec<Frame>,
}

/// Fills in and leaves out, and says so; what is too long is noted.
pub(super) fn whole(
    mut timeline: Timeline,
    notes: &mut Vec<String>,
    violations: &mut Violations,
) -> Whole {
    let mut filled = 0;
    for joint in 0..timeline.skeleton.len() {
        filled += fill(&mut timeline, joint, violations);
    }
    if filled > 0 {
        notes.push(format!(
            "filled in: {filled} places of joints of {} that were not tracked for at most {} s",
            timeline.name,
            LONGEST.seconds()
        ));
    }
    let all = timeline.stamps.len();
    let known = |frame: &usize| timeline.frame(*frame).iter().all(Option::is_some);
    let first = (0..all).find(known).unwrap_or(all);
    let last = (first..all).rev().find(known).map_or(first, |last| last + 1);
    if violations.none() && (first, last) != (0, all) {
        notes.push(format!(
            "left out: {} of {all} messages of {} at the beginning and {} at the end, where not \
             all joints are tracked",
            first,
            timeline.name,
            all - last
        ));
    }
    let frames = (first..last).map(|frame| {
        let places = timeline.frame(frame).iter();
        // Where a place is missing a violation is noted, and the frames are of no use.
        let positions = places.map(|place| place.unwrap_or_else(Point::origin)).collect();
        Frame { stamp: timeline.stamps[frame], positions }
    });
    let frames = frames.collect();
    Whole { timeline, frames }
}

/// Fills in one joint; returns how many places.
fn fill(timeline: &mut Timeline, joint: usize, violations: &mut Violations) -> usize {
    let joints = timeline.skeleton.len();
    let (mut filled, mut before) = (0, None::<usize>);
    for frame in 0..timeline.stamps.len() {
        let Some(place) = timeline.places[frame * joints + joint] else { continue };
        if let Some(known) = before.filter(|known| known + 1 < frame) {
            let (start, end) = (timeline.stamps[known], timeline.stamps[frame]);
            if (end - start) > LONGEST {
                let (person, seconds) = (timeline.name.clone(), (end - start).seconds());
                let joint = timeline.skeleton.names()[joint].clone();
                let at = timeline.message(known + 1);
                violations.add(at, Reason::Untracked { person, joint, seconds });
            } else if let Some(from) = timeline.places[known * joints + joint] {
                for between in known + 1..frame {
                    let stamp = timeline.stamps[between];
                    let place = on_line([start, end], [from, place], stamp);
                    timeline.places[between * joints + joint] = Some(place);
                    filled += 1;
                }
            }
        }
        before = Some(frame);
    }
    filled
}

/// Where something is at `stamp` that goes straight from one place to another.
pub(super) fn on_line(stamps: [Stamp; 2], places: [Point; 2], stamp: Stamp) -> Point {
    let part = (stamp - stamps[0]).seconds() / (stamps[1] - stamps[0]).seconds();
    places[0] + (places[1] - places[0]) * part
}
