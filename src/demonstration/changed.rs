//! Observations that nobody recorded: the partner elsewhere, or another robot.
//!
//! What a method knows is changed, and nothing else: the partner's whole motion by one shift, or
//! the robot's size by one factor about the floor under its base.

use super::Observation;
use crate::geometry::{Point, Vector};
use crate::skeleton::JointId;

impl Observation {
    /// The same with the partner's whole motion shifted `by` `[m]` in the world; the robot's base,
    /// bones and first pose stay.
    pub fn with_partner_moved(self, by: Vector) -> Self {
        let partner = self.partner.map_frames(|_, points| points.iter_mut().for_each(|p| *p += by));
        Self { partner, ..self }
    }

    /// The same for a robot `scale` `[-]` times as large: its bones, the height of its base and its
    /// first pose, about the floor (z = 0) under its base. The base stays above the same place of
    /// the floor, the partner as it is.
    pub fn with_robot_scaled(mut self, scale: f64) -> Self {
        let start = self.first_pose[self.robot_base.index()];
        let floor = Point::new(start.x, start.y, 0.0);
        self.bone_lengths.iter_mut().for_each(|length| *length *= scale);
        self.base.iter_mut().for_each(|base| base.z *= scale);
        self.first_pose.iter_mut().for_each(|p| *p = floor + (*p - floor) * scale);
        self
    }

    /// How far a robot's joint may be from its base `[m]`: the lengths of the bones between them,
    /// stretched out along the skeleton.
    pub fn reach(&self, joint: JointId) -> f64 {
        let bones = || self.robot_skeleton.bones();
        let parent = |joint: &JointId| bones().find(|bone| bone.child == *joint).map(|b| b.parent);
        let up_from = |joint: JointId| -> Vec<JointId> {
            std::iter::successors(Some(joint), parent).collect()
        };
        let (here, there) = (up_from(self.robot_base), up_from(joint));
        // A bone above both is on no way between them.
        let between = bones()
            .zip(&self.bone_lengths)
            .filter(|(bone, _)| here.contains(&bone.child) != there.contains(&bone.child));
        between.map(|(_, length)| length).sum()
    }
}
