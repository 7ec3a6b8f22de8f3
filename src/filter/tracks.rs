//! Each joint's places over time: believed, smoothed, or carried with its parent.

use super::body::Body;
use super::bones::Bones;
use super::smoother::Smoother;
use super::{FilterSettings, damped, seconds_since};
use crate::geometry::{Point, Vector, direction_or};
use crate::time::Stamp;

/// Longer absences `[s]` allow no longer ways.
const LONGEST_ABSENCE: f64 = 0.3;

/// One joint.
#[derive(Debug, Clone, Copy)]
struct Track {
    smoother: Smoother,
    /// Where it was last believed to be seen `[m]`, and when; `None`: never.
    seen: Option<(Point, Stamp)>,
    /// Where it is seen against belief: since when, when last, where.
    elsewhere: Option<(Stamp, Stamp, Point)>,
    /// From the parent, when last seen `[m]`, and how fast that changed `[m/s]`.
    offset: Vector,
    offset_velocity: Vector,
}

impl Track {
    fn unseen() -> Self {
        Self {
            smoother: Smoother::at(Point::origin()),
            seen: None,
            elsewhere: None,
            offset: Vector::zeros(),
            offset_velocity: Vector::zeros(),
        }
    }
}

/// All joints of a person.
#[derive(Debug, Clone)]
pub(super) struct Tracks {
    tracks: Box<[Track]>,
    stamp: Stamp,
    /// Of the sighting before: the places, and which joints were seen themselves.
    before: Box<[Point]>,
    was_seen: Box<[bool]>,
    /// Filtered `[m]` and `[m/s]`, as the partner shows them.
    pub(super) places: Box<[Point]>,
    pub(super) velocities: Box<[Vector]>,
}

impl Tracks {
    pub(super) fn new(joints: usize) -> Self {
        Self {
            tracks: vec![Track::unseen(); joints].into(),
            stamp: Stamp(0),
            before: vec![Point::origin(); joints].into(),
            was_seen: vec![false; joints].into(),
            places: vec![Point::origin(); joints].into(),
            velocities: vec![Vector::zeros(); joints].into(),
        }
    }

    pub(super) fn forget(&mut self) {
        self.tracks.fill(Track::unseen());
        self.places.fill(Point::origin());
        self.velocities.fill(Vector::zeros());
    }

    /// Forgets one joint: the next sighting of it is believed.
    pub(super) fn forget_joint(&mut self, joint: usize) {
        self.tracks[joint] = Track::unseen();
    }

    /// The sighting that places are of.
    pub(super) fn stamp(&self) -> Stamp {
        self.stamp
    }

    /// For how long a joint has not been seen `[s]`; `None`: never seen.
    pub(super) fn absence(&self, joint: usize, stamp: Stamp) -> Option<f64> {
        self.tracks[joint].seen.map(|(_, seen)| seconds_since(stamp, seen))
    }

    /// Where a joint ever seen is, carried by damped velocity for at most `longest` `[s]`.
    pub(super) fn carried(
        &self,
        body: &Body,
        joint: usize,
        stamp: Stamp,
        longest: f64,
        settings: &FilterSettings,
    ) -> Point {
        let elapsed = seconds_since(stamp, self.stamp).min(longest);
        let of_body = self.velocities[body.base];
        let own = self.velocities[joint] - of_body;
        self.places[joint]
            + of_body * damped(elapsed, settings.body_damping)
            + own * damped(elapsed, settings.joint_damping)
    }

    /// Takes a sighting of this person: each joint by what is seen of it, or with its parent.
    pub(super) fn take(
        &mut self,
        body: &Body,
        seen: &[Option<Point>],
        stamp: Stamp,
        bones: &mut Bones,
        settings: &FilterSettings,
    ) {
        let elapsed = seconds_since(stamp, self.stamp);
        let carried_base = self.carried(body, body.base, stamp, settings.bridge, settings);
        let base_shift = carried_base - self.places[body.base];
        self.before.copy_from_slice(&self.places);
        for joint in 0..body.len() {
            self.was_seen[joint] = self.is_seen(joint, self.stamp);
        }
        for joint in 0..body.len() {
            let believed = seen[joint].filter(|place| {
                let carried = self.carried(body, joint, stamp, settings.bridge, settings);
                self.believes(joint, *place, carried, stamp, bones.is_off(joint), settings)
            });
            let Some(place) = believed else { continue };
            let track = &mut self.tracks[joint];
            let moved = track.elsewhere.take().is_some();
            if moved {
                bones.forget_joint(body, joint);
            }
            if moved || track.seen.is_none_or(|(_, at)| seconds_since(stamp, at) > settings.bridge)
            {
                track.smoother = Smoother::at(place);
            } else {
                track.smoother.take(place, elapsed, settings);
            }
            track.seen = Some((place, stamp));
        }
        // Carried by what the body did before this sighting, so the order of joints is nothing.
        for joint in 0..body.len() {
            if self.is_seen(joint, stamp) {
                self.show(joint);
            }
        }
        for &joint in &body.order {
            if !self.is_seen(joint, stamp) {
                self.bridge(body, joint, stamp, base_shift, elapsed, settings);
            }
        }
        self.stamp = stamp;
        for joint in 0..body.len() {
            let Some(parent) = body.joints[joint].parent else { continue };
            if self.is_seen(joint, stamp) {
                self.tracks[joint].offset = self.places[joint] - self.places[parent];
                self.tracks[joint].offset_velocity =
                    self.velocities[joint] - self.velocities[parent];
            }
        }
    }

    /// Whether a joint is where it is seen, `elsewhere` left if that is new: not too fast and with bones of their length, or there
    /// for so long that it has to be.
    fn believes(
        &mut self,
        joint: usize,
        place: Point,
        carried: Point,
        stamp: Stamp,
        is_off: bool,
        settings: &FilterSettings,
    ) -> bool {
        let track = &mut self.tracks[joint];
        let Some((before, at)) = track.seen else { return true };
        let reach = |since: Stamp| {
            let elapsed = seconds_since(stamp, since).min(LONGEST_ABSENCE);
            settings.joint_slack + settings.joint_speed * elapsed
        };
        // One that was hidden comes back where it was, or where it was carried.
        let off = (place - before).norm().min((place - carried).norm());
        if !is_off && off <= reach(at) {
            track.elsewhere = None;
            return true;
        }
        let since = match track.elsewhere {
            Some((since, last, there))
                if seconds_since(stamp, last) <= LONGEST_ABSENCE
                    && (place - there).norm() <= reach(last) =>
            {
                since
            }
            _ => stamp,
        };
        track.elsewhere = Some((since, stamp, place));
        seconds_since(stamp, since) >= settings.believe
    }

    /// Moves a joint that is not seen with its parent; the root goes where its children go.
    fn bridge(
        &mut self,
        body: &Body,
        joint: usize,
        stamp: Stamp,
        base_shift: Vector,
        elapsed: f64,
        settings: &FilterSettings,
    ) {
        let track = self.tracks[joint];
        let (place, velocity) = match (body.joints[joint].parent, track.seen) {
            (Some(parent), Some((_, at))) => {
                let absent = seconds_since(stamp, at).min(settings.bridge);
                let turned =
                    track.offset + track.offset_velocity * damped(absent, settings.joint_damping);
                // Bones keep their length.
                let offset = direction_or(turned, Vector::zeros()) * track.offset.norm();
                let fades = if seconds_since(stamp, at) > settings.bridge {
                    0.0
                } else {
                    (-absent / settings.joint_damping).exp()
                };
                let velocity = self.velocities[parent] + track.offset_velocity * fades;
                (self.places[parent] + offset, velocity)
            }
            (Some(parent), None) => {
                let offset = body.guessed_offset(joint, |joint| self.places[joint]);
                (self.places[parent] + offset, self.velocities[parent])
            }
            (None, Some(_)) => {
                let shift = self.shift_of_children(body, joint, stamp).unwrap_or(base_shift);
                let fades = (-elapsed / settings.body_damping).exp();
                (self.before[joint] + shift, self.velocities[joint] * fades)
            }
            (None, None) => (self.places[joint], Vector::zeros()),
        };
        self.tracks[joint].smoother.place = place;
        self.tracks[joint].smoother.velocity = velocity;
        self.show(joint);
    }

    /// How far a joint's children that are seen have moved, on average `[m]`, if any are.
    fn shift_of_children(&self, body: &Body, joint: usize, stamp: Stamp) -> Option<Vector> {
        let (mut shift, mut count) = (Vector::zeros(), 0.0);
        for (child, other) in body.joints.iter().enumerate() {
            // One that was not seen before may have jumped.
            let is_known = self.is_seen(child, stamp) && self.was_seen[child];
            if other.parent == Some(joint) && is_known {
                shift += self.places[child] - self.before[child];
                count += 1.0;
            }
        }
        (count > 0.0).then(|| shift / count)
    }

    fn is_seen(&self, joint: usize, stamp: Stamp) -> bool {
        self.tracks[joint].seen.is_some_and(|(_, at)| at == stamp)
    }

    fn show(&mut self, joint: usize) {
        self.places[joint] = self.tracks[joint].smoother.place;
        self.velocities[joint] = self.tracks[joint].smoother.velocity;
    }
}
