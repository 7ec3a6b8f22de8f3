//! What a method may know of an interaction, and what it learns from.

use std::sync::Arc;

use super::{Contact, Hands};
use crate::geometry::{Point, Vector, yaw_isometry};
use crate::kinematics::minimum_jerk;
use crate::skeleton::{JointId, Recording, Role, Sequence, Skeleton};

/// A recording of which the robot may take one role.
#[derive(Debug, Clone)]
pub struct Demonstration {
    recording: Arc<Recording>,
    robot: Role,
    bases: [JointId; 2],
    contact: Contact,
}

/// Why a recording demonstrates nothing.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DemonstrationError {
    /// No person of that name.
    #[error("{clip}: no person '{role}', only '{first}' and '{second}'", first = names[0], second = names[1])]
    Role {
        /// The recording.
        clip: String,
        /// The name asked for.
        role: String,
        /// The names there are.
        names: [String; 2],
    },
    /// A skeleton without hands hands nothing over.
    #[error("{clip}: both people need a hand, a left_hand or a right_hand joint")]
    NoHands {
        /// The recording.
        clip: String,
    },
}

impl Demonstration {
    /// Looks up the robot's role by name and finds the contact.
    ///
    /// - `base`: name of the joint that a person's place is known by; a skeleton without it uses
    ///   its root.
    ///
    /// # Errors
    /// [`DemonstrationError`] if there is no such role, or no hands.
    pub fn new(
        recording: Arc<Recording>,
        role: &str,
        base: &str,
    ) -> Result<Self, DemonstrationError> {
        let clip = || recording.name().to_owned();
        let Some(robot) = recording.role(role) else {
            let names = recording.people().each_ref().map(|person| person.name.clone());
            return Err(DemonstrationError::Role { clip: clip(), role: role.to_owned(), names });
        };
        let bases = recording.people().each_ref().map(|person| {
            let skeleton = person.motion.skeleton();
            skeleton.joint(base).unwrap_or_else(|| skeleton.root())
        });
        let Some(contact) = Contact::closest(&recording, robot) else {
            return Err(DemonstrationError::NoHands { clip: clip() });
        };
        Ok(Self { recording, robot, bases, contact })
    }

    /// The same demonstration, both people smoothed by `sigma` `[s]`, the contact found anew.
    pub fn smoothed(&self, sigma: f64) -> Self {
        let recording = Arc::new(self.recording.smoothed(sigma));
        // The hands are there: they were found before.
        let contact = Contact::closest(&recording, self.robot).unwrap_or(self.contact);
        Self { recording, contact, ..self.clone() }
    }

    /// The recording.
    pub fn recording(&self) -> &Arc<Recording> {
        &self.recording
    }

    /// The role the robot takes.
    pub fn robot_role(&self) -> Role {
        self.robot
    }

    /// The robot role's motion.
    pub fn robot(&self) -> &Sequence {
        &self.recording.person(self.robot).motion
    }

    /// The partner's motion.
    pub fn partner(&self) -> &Sequence {
        &self.recording.person(self.robot.partner()).motion
    }

    /// The joint the robot's place is known by.
    pub fn robot_base(&self) -> JointId {
        self.bases[self.robot as usize]
    }

    /// The joint the partner's place is taken by.
    pub fn partner_base(&self) -> JointId {
        self.bases[self.robot.partner() as usize]
    }

    /// Where and when the closest hands met.
    pub fn contact(&self) -> &Contact {
        &self.contact
    }

    /// Where and when these hands were closest.
    pub fn contact_of(&self, hands: Hands) -> Option<Contact> {
        Contact::of(&self.recording, self.robot, hands)
    }

    /// The same interaction without the robot role's truth.
    pub fn observation(&self) -> Observation {
        let base = self.robot_base();
        Observation {
            robot_role: self.robot,
            partner: self.partner().clone(),
            partner_base: self.partner_base(),
            robot_skeleton: self.robot().skeleton().clone(),
            robot_base: base,
            base: (0..self.recording.len()).map(|k| self.robot().position(k, base)).collect(),
            bone_lengths: self.robot().bone_lengths(),
            first_pose: self.robot().frames()[0].positions.to_vec(),
        }
    }
}

/// All that a method may know of the interaction at hand.
#[derive(Debug, Clone)]
pub struct Observation {
    /// The role the robot takes.
    pub robot_role: Role,
    /// The partner's motion.
    pub partner: Sequence,
    /// The joint the partner's place is taken by.
    pub partner_base: JointId,
    /// The robot's joints and bones.
    pub robot_skeleton: Arc<Skeleton>,
    /// The joint the robot's place is known by.
    pub robot_base: JointId,
    /// Where the robot's base is: `[m]`, one per frame.
    pub base: Vec<Point>,
    /// The robot's own bone lengths `[m]`, in its skeleton's bone order.
    pub bone_lengths: Vec<f64>,
    /// Where the robot's joints are at the first frame `[m]`: its own state, not its motion.
    pub first_pose: Vec<Point>,
}

impl Observation {
    /// The number of frames.
    #[expect(clippy::len_without_is_empty, reason = "a sequence has frames")]
    pub fn len(&self) -> usize {
        self.partner.len()
    }

    /// The time `[s]` of a fractional frame, held beyond the last.
    pub fn seconds(&self, frame: f64) -> f64 {
        let at = |k: f64| self.partner.frames()[(k as usize).min(self.len() - 1)].stamp.seconds();
        at(frame.floor()) + (at(frame.ceil()) - at(frame.floor())) * frame.fract()
    }

    /// How near a frame is to a moment (a fractional frame): 1 there, 0 from `fade` `[s]` off,
    /// smoothly between.
    pub fn nearness(&self, frame: usize, moment: f64, fade: f64) -> f64 {
        let off = (self.seconds(frame as f64) - self.seconds(moment)).abs();
        minimum_jerk(1.0 - off / fade)
    }

    /// Where the partner's base is at a frame `[m]`.
    pub fn partner_place(&self, frame: usize) -> Point {
        self.partner.position(frame, self.partner_base)
    }

    /// A gap `[m]` in the partner's heading frame → in the world, at a frame.
    pub fn gap_in_world(&self, frame: usize, gap_in_heading: Vector) -> Vector {
        yaw_isometry(self.partner.heading(frame), Vector::zeros()) * gap_in_heading
    }

    /// A gap `[m]` in the world → in the partner's heading frame, at a frame.
    pub fn gap_in_heading(&self, frame: usize, gap_in_world: Vector) -> Vector {
        yaw_isometry(-self.partner.heading(frame), Vector::zeros()) * gap_in_world
    }
}
