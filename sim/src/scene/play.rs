//! A checked scene, played: poses at any instant, recordings at given stamps.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

use handover_mesh::geometry::{direction_or, yaw_isometry};
use handover_mesh::{
    Frame, Isometry, ObjectTrack, Person, Point, Recording, RecordingError, Role, Sequence,
    SequenceError, Side, Skeleton, Stamp, Vector,
};

use super::config::{PersonConfig, SceneConfig};
use super::moments::Moments;
use super::people::{Limb, Stance, Trunk, ankle, pair_from_stand};
use super::{GIVER, OBJECT, RECEIVER};
use crate::body::{Body, sign};
use crate::check::Violations;
use crate::profile::{bell, idle_wave, step};

/// Both people, giver first.
const ROLES: [Role; 2] = [Role::First, Role::Second];
/// A hand meets comfortably at this part of the stretched arm, measured along the floor.
const COMFORTABLE_REACH: f64 = 0.75;
/// Objects change hands at this part of stature: between elbow (0.63) and shoulder (0.818).
const COMFORTABLE_HEIGHT: f64 = 0.66;

/// One person at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// The fifteen joints in [`Skeleton::nite`]'s order, `[m]` in `world`.
    pub positions: [Point; 15],
    /// How far the active hand is from where it should be, `[m]`: more than 0 where that is out
    /// of the arm's reach.
    pub shortfall: f64,
    /// Whether a foot could not be where it should (its leg is then straight, pointing there).
    pub foot_clamped: bool,
}

/// A recording of a scene, and how often something was out of reach in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Take {
    /// The truth: exactly what the two people did.
    pub truth: Recording,
    /// Frames in which each person's active hand was clamped to its reach: giver, receiver.
    pub clamped_frames: [usize; 2],
}

/// Why a scene could not be recorded at some stamps.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecordError {
    /// There are none, or they do not rise.
    #[error(transparent)]
    Sequence(#[from] SequenceError),
    /// The people and the object do not fit together.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}

/// A checked handover: a closed form in time of both people's joints and the object.
///
/// ```
/// use handover_mesh::{Role, Stamp};
/// use handover_sim::scene::{Scene, SceneConfig};
/// let scene = Scene::new(SceneConfig::default())?;
/// let contact = scene.moments().contact;
/// let hands = [Role::First, Role::Second].map(|role| scene.pose(role, contact).positions[8]);
/// assert!(((hands[0] - hands[1]).norm() - 0.12).abs() < 1e-9); // The default gap.
/// let take = scene.record("clip", &[Stamp(0), Stamp(33_333_333)]).unwrap();
/// assert_eq!(take.truth.len(), 2);
/// # Ok::<(), handover_sim::Violations>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    config: SceneConfig,
    moments: Moments,
    bodies: [Body; 2],
    world_from_pair: Isometry,
    /// Midway between the hands at contact, `[m]` in `pair`.
    meeting: Point,
    /// Where each active hand goes, `[m]` in `pair`.
    goals: [Point; 2],
    /// From the giver's hand to the receiver's at the transfer, `[m]` in `pair`.
    span: Vector,
}

impl Scene {
    /// Checks the parameters and places the meeting point.
    ///
    /// The meeting point lies over the line between the two reaching shoulders. Along it the
    /// giver's choice is their own comfortable reach from their shoulder, the receiver's likewise
    /// from theirs; its height is a comfortable part of stature; and
    /// [`SceneConfig::suit_receiver`] mixes the two choices.
    ///
    /// # Errors
    /// [`Violations`] names every parameter out of range.
    pub fn new(config: SceneConfig) -> Result<Self, Violations> {
        config.check()?;
        let bodies = ROLES.map(|role| Body::of_stature(config.person(role).stature));
        let [x, y] = config.centre;
        let mut scene = Self {
            moments: Moments::of(&config),
            bodies,
            world_from_pair: yaw_isometry(config.heading, Vector::new(x, y, 0.0)),
            meeting: Point::origin(),
            goals: [Point::origin(); 2],
            span: Vector::x(),
            config,
        };
        scene.place_meeting();
        let hands = ROLES.map(|role| scene.pose_in_pair(role, scene.moments.transfer).active.end);
        scene.span = hands[1] - hands[0];
        Ok(scene)
    }

    /// The parameters.
    pub fn config(&self) -> &SceneConfig {
        &self.config
    }

    /// When things happen, `[s]` from the start.
    pub fn moments(&self) -> &Moments {
        &self.moments
    }

    /// The bodies' lengths: giver, receiver.
    pub fn bodies(&self) -> &[Body; 2] {
        &self.bodies
    }

    /// The point midway between the hands at contact, as planned, `[m]` in `world`.
    pub fn meeting_point(&self) -> Point {
        self.world_from_pair * self.meeting
    }

    /// One person at an instant (`[s]` from the start; any, also before 0 and after the end).
    pub fn pose(&self, role: Role, seconds: f64) -> Pose {
        let pose = self.pose_in_pair(role, seconds);
        let Trunk { torso, neck, head, shoulders, hips, .. } = pose.trunk;
        let [left, right] = pose.arms;
        let [left_leg, right_leg] = pose.legs;
        let in_pair = [
            head,
            neck,
            torso,
            shoulders[0],
            left.middle,
            left.end,
            shoulders[1],
            right.middle,
            right.end,
            hips[0],
            left_leg.middle,
            left_leg.end,
            hips[1],
            right_leg.middle,
            right_leg.end,
        ];
        Pose {
            positions: in_pair.map(|point| self.world_from_pair * point),
            shortfall: pose.shortfall,
            foot_clamped: left_leg.clamped || right_leg.clamped,
        }
    }

    /// Where the object's middle is, `[m]` in `world`: at the giver's hand until the transfer,
    /// at the receiver's from then on.
    pub fn object(&self, seconds: f64) -> Point {
        let given = seconds >= self.moments.transfer;
        let (role, span) =
            if given { (Role::Second, -self.span) } else { (Role::First, self.span) };
        let arm = self.pose_in_pair(role, seconds).active;
        let half = span.norm() / 2.0;
        // Carried it sticks out along the forearm, offered it points at the other's hand.
        let forearm = direction_or(arm.end - arm.middle, Vector::x());
        let offered = direction_or(span, forearm);
        let progress = self.moments.progress(role, seconds);
        let ahead = direction_or(forearm.lerp(&offered, progress), offered);
        self.world_from_pair * (arm.end + ahead * half)
    }

    /// Records the scene at these instants; stamp 0 is its start.
    ///
    /// # Errors
    /// [`RecordError`] if there are no stamps or they do not rise.
    pub fn record(&self, name: &str, stamps: &[Stamp]) -> Result<Take, RecordError> {
        let skeleton = Skeleton::nite();
        let mut clamped_frames = [0; 2];
        let mut person = |role: Role, name: &str| -> Result<Person, SequenceError> {
            let frames = stamps.iter().map(|&stamp| {
                let pose = self.pose(role, stamp.seconds());
                clamped_frames[role as usize] += usize::from(pose.shortfall > 0.0);
                Frame { stamp, positions: pose.positions.into() }
            });
            let motion = Sequence::new(Arc::clone(&skeleton), frames.collect())?;
            Ok(Person { name: name.into(), motion })
        };
        let people = [person(Role::First, GIVER)?, person(Role::Second, RECEIVER)?];
        let places = stamps.iter().map(|&stamp| (stamp, self.object(stamp.seconds())));
        let object = ObjectTrack { name: OBJECT.into(), places: places.collect() };
        let class = BTreeMap::from([("class".into(), "handover".into())]);
        let truth = Recording::new(name, people, Some(object), class)?;
        Ok(Take { truth, clamped_frames })
    }

    fn place_meeting(&mut self) {
        let config = &self.config;
        let shoulders = ROLES.map(|role| {
            let person = config.person(role);
            let trunk = Trunk::of(&self.bodies[role as usize], &self.stance(role, 1.0, None));
            trunk.shoulders[person.hand as usize]
        });
        let between = shoulders[1] - shoulders[0];
        let across = Vector::new(between.x, between.y, 0.0);
        let ahead = direction_or(across, Vector::x());
        let comfort = self.bodies.map(|body| COMFORTABLE_REACH * body.arm() + config.gap / 2.0);
        let mix = |giver: f64, receiver: f64| giver + (receiver - giver) * config.suit_receiver;
        let along = mix(comfort[0], across.norm() - comfort[1]);
        // Never behind either shoulder, however near they stand.
        let along = along.clamp(0.25 * across.norm(), 0.75 * across.norm());
        let [giver, receiver] = self.bodies.map(|body| COMFORTABLE_HEIGHT * body.stature());
        let meeting = shoulders[0] + ahead * along;
        let meeting = Point::new(meeting.x, meeting.y, mix(giver, receiver));
        self.meeting = meeting + config.meeting_shift;
        self.goals = [-0.5, 0.5].map(|half| self.meeting + ahead * (half * config.gap));
    }

    /// Hips and trunk at a given progress of the reach; without `seconds` no idle motion and no
    /// walk.
    fn stance(&self, role: Role, progress: f64, seconds: Option<f64>) -> Stance {
        let person = self.config.person(role);
        let body = &self.bodies[role as usize];
        let wave = |rate: f64, phase: f64| {
            seconds.map_or(0.0, |seconds| idle_wave(seconds, rate, person.phase + phase))
        };
        let sway = Vector::new(wave(0.31, 0.0), wave(0.23, 1.1), 0.0) * person.sway;
        // A trunk of half a metre that sways as its hips do turns by about twice as many radians.
        let tilt = 2.0 * person.sway;
        let (behind, speed) = seconds.map_or((0.0, 0.0), |seconds| {
            let (distance, part) = self.walk(role, seconds);
            (distance * (crate::profile::minimum_jerk(part) - 1.0), bell(part, 0.0, 1.0))
        });
        // Longer steps need lower hips: 5 % of a leg frees its foot by 0.3 of it.
        let height = body.hip_height() * (1.0 - 0.05 * speed);
        let hips = Vector::new(behind, 0.0, height) + sway;
        Stance {
            pair_from_hips: self.stand(role) * yaw_isometry(tilt * wave(0.19, 2.2), hips),
            lean: person.lean * progress + tilt * wave(0.27, 3.3),
            twist: -sign(person.hand) * person.twist * progress,
            nod: 0.06 + 0.12 * progress,
        }
    }

    /// How far this person walks in all (0 for who stands), and the part of it done.
    fn walk(&self, role: Role, seconds: f64) -> (f64, f64) {
        match &self.config.approach {
            Some(approach) if approach.role == role => {
                let [start, end] = self.moments.walk;
                (approach.distance, ((seconds - start) / (end - start)).clamp(0.0, 1.0))
            }
            _ => (0.0, 1.0),
        }
    }

    /// `pair` from the upright frame of this person's stand at the handover.
    fn stand(&self, role: Role) -> Isometry {
        let (side, yaw) = match role {
            Role::First => (-0.5, 0.0),
            Role::Second => (0.5, PI),
        };
        pair_from_stand(side * self.config.distance, yaw + self.config.person(role).facing)
    }

    fn pose_in_pair(&self, role: Role, seconds: f64) -> PairPose {
        let person = self.config.person(role);
        let body = &self.bodies[role as usize];
        let progress = self.moments.progress(role, seconds);
        let stance = self.stance(role, progress, Some(seconds));
        let trunk = Trunk::of(body, &stance);
        let (distance, part) = self.walk(role, seconds);
        let striding = distance * bell(part, 0.0, 1.0);

        let hand_goal = |side: Side| {
            // Arms swing against each other, more while walking.
            let beat = idle_wave(seconds, 0.37, person.phase + sign(side)) * person.swing;
            let stride = 0.25 * striding * sign(side) * (std::f64::consts::TAU * part).sin();
            if side != person.hand {
                return trunk.resting_hand(body, side, 0.0, beat + stride);
            }
            self.active_hand_goal(role, person, &trunk, seconds, beat)
        };
        let goals = Side::BOTH.map(hand_goal);
        // The elbow's height over the hand wanders a little too.
        let swivel = person.swivel + 2.0 * person.swing * idle_wave(seconds, 0.17, person.phase);
        let arms = Side::BOTH.map(|side| trunk.arm(body, side, goals[side as usize], swivel));
        let legs = Side::BOTH.map(|side| {
            let target = self.stand(role) * ankle(body, side, distance, part);
            trunk.leg(body, &stance, side, target)
        });
        let active = arms[person.hand as usize];
        let missed = (active.end - goals[person.hand as usize]).norm();
        let shortfall = if active.clamped { missed } else { 0.0 };
        PairPose { trunk, arms, legs, active, shortfall }
    }

    /// Where the hand that gives or takes should be, `[m]` in `pair`.
    fn active_hand_goal(
        &self,
        role: Role,
        person: &PersonConfig,
        trunk: &Trunk,
        seconds: f64,
        beat: f64,
    ) -> Point {
        let moments = &self.moments;
        let body = &self.bodies[role as usize];
        // Who holds the object rests with a raised forearm. At the transfer both hands are at
        // the meeting point, so the change of rest is not seen.
        let holding = (role == Role::First) == (seconds < moments.transfer);
        let carry = if holding { person.carry } else { 0.0 };
        let rest = trunk.resting_hand(body, person.hand, carry, beat);
        let progress = moments.progress(role, seconds);
        let [start, end] = moments.reach[role as usize];
        let out = step(seconds, start, end);
        // 16 s²(1−s)² is 1 halfway and flat at both ends, so the path keeps its rest there.
        let rise = person.arc * 16.0 * (out * (1.0 - out)).powi(2);
        rest + (self.goals[role as usize] - rest) * progress + Vector::z() * rise
    }
}

/// One person in `pair`; arms and legs left, right.
struct PairPose {
    trunk: Trunk,
    arms: [Limb; 2],
    legs: [Limb; 2],
    active: Limb,
    shortfall: f64,
}
