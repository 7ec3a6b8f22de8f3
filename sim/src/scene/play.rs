//! A checked scene, played: poses at any instant, recordings at given stamps.

use std::collections::BTreeMap;
use std::sync::Arc;

use handover_mesh::geometry::{direction_or, yaw_isometry};
use handover_mesh::{
    Frame, Isometry, ObjectTrack, Person, Point, Recording, RecordingError, Role, Sequence,
    SequenceError, Skeleton, Stamp, Vector,
};

use super::config::SceneConfig;
use super::moments::Moments;
use super::people::Trunk;
use super::{GIVER, OBJECT, RECEIVER};
use crate::body::Body;
use crate::check::Violations;

/// Both people, giver first.
pub(super) const ROLES: [Role; 2] = [Role::First, Role::Second];

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
    pub(super) config: SceneConfig,
    pub(super) moments: Moments,
    pub(super) bodies: [Body; 2],
    world_from_pair: Isometry,
    /// Midway between the hands at contact, `[m]` in `pair`.
    pub(super) meeting: Point,
    /// Where each active hand goes, `[m]` in `pair`.
    pub(super) goals: [Point; 2],
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
        self.record_at(name, stamps, |seconds| seconds)
    }

    /// Records the scene at these instants, played at another pace.
    ///
    /// - `scene_time`: seconds from stamp 0 → seconds of the scene.
    ///
    /// # Errors
    /// As [`Self::record`].
    pub fn record_at(
        &self,
        name: &str,
        stamps: &[Stamp],
        scene_time: impl Fn(f64) -> f64,
    ) -> Result<Take, RecordError> {
        let skeleton = Skeleton::nite();
        let mut clamped_frames = [0; 2];
        let mut person = |role: Role, name: &str| -> Result<Person, SequenceError> {
            let frames = stamps.iter().map(|&stamp| {
                let pose = self.pose(role, scene_time(stamp.seconds()));
                clamped_frames[role as usize] += usize::from(pose.shortfall > 0.0);
                Frame { stamp, positions: pose.positions.into() }
            });
            let motion = Sequence::new(Arc::clone(&skeleton), frames.collect())?;
            Ok(Person { name: name.into(), motion })
        };
        let people = [person(Role::First, GIVER)?, person(Role::Second, RECEIVER)?];
        let places = stamps.iter().map(|&stamp| (stamp, self.object(scene_time(stamp.seconds()))));
        let object = ObjectTrack::of_point(OBJECT, places.collect());
        let class = BTreeMap::from([("class".into(), "handover".into())]);
        let truth = Recording::new(name, people, Some(object), class)?;
        Ok(Take { truth, clamped_frames })
    }
}
