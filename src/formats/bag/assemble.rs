//! Two people's tracks and perhaps an object's → a [`Recording`].
//!
//! Frames are at the first person's stamps. Where the second was seen at the same stamp, their
//! places are taken as they are; else they are put on the line between the sightings around it, if
//! these are at most half a second apart.

use std::collections::BTreeMap;

use super::super::error::{Place, Reason, Violations};
use super::super::up::UpAxis;
use super::collect::{Collected, Kind, Track};
use super::fill::{self, Whole};
use super::people::{self, Candidate};
use super::track::{self, View};
use crate::geometry::Point;
use crate::skeleton::{Frame, ObjectTrack, Person, Recording, Sequence};
use crate::time::Stamp;

/// The recording, unless something is wrong, which is noted.
pub(super) fn recording(
    name: &str,
    mut collected: Collected,
    up: UpAxis,
    notes: &mut Vec<String>,
    violations: &mut Violations,
) -> Option<Recording> {
    collected.finish();
    std::mem::swap(violations, &mut collected.violations);
    let mut two = match people::two(&mut collected) {
        Ok(two) => two,
        Err(reason) => {
            violations.add(Place::File, reason);
            return None;
        }
    };
    let mut objects = collected.tracks(Kind::Object);
    if let [first, second, ..] = &objects[..] {
        let [first, second] = [first, second].map(object_name);
        violations.add(Place::File, Reason::SecondObject { first, second });
    }
    // A robot's frame is the one that it is to work in, unless that moves itself: people would fly.
    let frames = two.each_ref().map(|candidate| {
        candidate.track.seen.first().map_or_else(String::new, |seen| seen.frame.to_string())
    });
    let frame = collected.frames.still(&frames[1], &frames[0]);
    let view = View { frame, tree: &collected.frames, up };
    let tracks = two.iter_mut().map(|candidate| &mut candidate.track);
    tracks.chain(&mut objects).for_each(|track| view.turn(track, notes, violations));
    let mut whole = |candidate: Candidate, violations: &mut Violations| {
        let timeline = track::timeline(candidate, notes, violations)?;
        Some(fill::whole(timeline, notes, violations))
    };
    let two = two.map(|candidate| whole(candidate, violations));
    let [Some(first), Some(second)] = two else { return None };
    first.timeline.check_rate(violations);
    if let Some(object) = objects.first_mut() {
        track::in_time(object, violations);
    }
    if !violations.none() {
        return None;
    }
    let object = objects.pop();
    let metadata = std::mem::take(&mut collected.custom_data);
    finish(name, [first, second], object, metadata, notes)
        .map_err(|reason| violations.add(Place::File, reason))
        .ok()
}

fn object_name(track: &Track) -> String {
    people::parent(&track.topic).unwrap_or("object").to_owned()
}

fn finish(
    name: &str,
    [first, second]: [Whole; 2],
    object: Option<Track>,
    mut metadata: BTreeMap<String, String>,
    notes: &mut Vec<String>,
) -> Result<Recording, Reason> {
    let names = [&first, &second].map(|whole| whole.timeline.name.clone());
    let (frames, others) = together(&first, &second, notes);
    if frames.is_empty() {
        let [first, second] = names;
        return Err(Reason::NeverTogether { first, second });
    }
    let stamps: Vec<Stamp> = frames.iter().map(|frame| frame.stamp).collect();
    let skeleton = first.timeline.skeleton;
    // Equal skeletons are shared, so that later comparisons are of pointers.
    let same = skeleton == second.timeline.skeleton;
    let other = if same { skeleton.clone() } else { second.timeline.skeleton };
    let [first, second] = names;
    let people = [
        Person { name: first, motion: Sequence::new(skeleton, frames)? },
        Person { name: second, motion: Sequence::new(other, others)? },
    ];
    let object = object.map(|track| (object_name(&track), at_stamps(&track, &stamps, notes)));
    let object = object.filter(|(_, places)| !places.is_empty());
    let object = object.map(|(name, places)| ObjectTrack::of_point(name, places));
    metadata.remove(people::PEOPLE);
    Ok(Recording::new(name, people, object, metadata)?)
}

/// Both people's frames at the first one's stamps, where both are known.
fn together(first: &Whole, second: &Whole, notes: &mut Vec<String>) -> (Vec<Frame>, Vec<Frame>) {
    let stamps: Vec<Stamp> = second.frames.iter().map(|frame| frame.stamp).collect();
    let (mut frames, mut others, mut between) = (Vec::new(), Vec::new(), 0);
    for frame in &first.frames {
        let positions = match around(&stamps, frame.stamp) {
            Around::At(at) => second.frames[at].positions.clone(),
            Around::Between(before) => {
                between += 1;
                let [a, b] = [&second.frames[before], &second.frames[before + 1]];
                let pairs = a.positions.iter().zip(&b.positions);
                let place = |(from, to): (&Point, &Point)| {
                    fill::on_line([a.stamp, b.stamp], [*from, *to], frame.stamp)
                };
                pairs.map(place).collect()
            }
            Around::Unknown => continue,
        };
        frames.push(frame.clone());
        others.push(Frame { stamp: frame.stamp, positions });
    }
    let [first_name, second_name] = [first, second].map(|whole| &whole.timeline.name);
    if between > 0 {
        notes.push(format!(
            "interpolated: {second_name} at {between} stamps of {first_name}'s frames"
        ));
    }
    if frames.len() < first.frames.len() {
        notes.push(format!(
            "left out: {} of {} frames of {first_name} at which {second_name} is not known",
            first.frames.len() - frames.len(),
            first.frames.len()
        ));
    }
    (frames, others)
}

/// The object's places as they are, if all are at frames' stamps; else those at the frames.
fn at_stamps(track: &Track, stamps: &[Stamp], notes: &mut Vec<String>) -> Vec<(Stamp, Point)> {
    let known: Vec<(Stamp, Point)> = track
        .seen
        .iter()
        .filter_map(|seen| Some((seen.stamp, *seen.places.first()?)))
        .filter(|(_, place)| crate::geometry::is_finite(place))
        .collect();
    if known.iter().all(|(stamp, _)| stamps.binary_search(stamp).is_ok()) {
        return known;
    }
    let times: Vec<Stamp> = known.iter().map(|(stamp, _)| *stamp).collect();
    let place = |stamp: &Stamp| match around(&times, *stamp) {
        Around::At(at) => Some((*stamp, known[at].1)),
        Around::Between(at) => {
            let [a, b] = [known[at], known[at + 1]];
            Some((*stamp, fill::on_line([a.0, b.0], [a.1, b.1], *stamp)))
        }
        Around::Unknown => None,
    };
    notes.push(format!("interpolated: {} at the frames' stamps", object_name(track)));
    stamps.iter().filter_map(place).collect()
}

/// What is known of an instant.
enum Around {
    /// This sighting is at it.
    At(usize),
    /// It is between this sighting and the next.
    Between(usize),
    /// No sighting is near.
    Unknown,
}

fn around(stamps: &[Stamp], stamp: Stamp) -> Around {
    match stamps.binary_search(&stamp) {
        Ok(at) => Around::At(at),
        Err(after) if after == 0 || after == stamps.len() => Around::Unknown,
        Err(after) if stamps[after] - stamps[after - 1] > fill::LONGEST => Around::Unknown,
        Err(after) => Around::Between(after - 1),
    }
}
