//! The mirror image: a left-handed handover made of a right-handed one.

use super::{JointId, Sequence, Skeleton};

impl Skeleton {
    /// The joint on the other side of the body; itself for the spine and for unknown names.
    pub fn mirrored_joint(&self, joint: JointId) -> JointId {
        self.part_of(joint).and_then(|part| self.part(part.mirrored())).unwrap_or(joint)
    }
}

impl Sequence {
    /// The motion as a mirror in the vertical x-z plane shows it: y changes sign, and what was
    /// the left hand is the right one.
    pub fn mirrored(&self) -> Self {
        let skeleton = self.skeleton();
        let partner: Vec<usize> =
            skeleton.joints().map(|joint| skeleton.mirrored_joint(joint).index()).collect();
        self.map_frames(|at, points| {
            let original = &self.frames()[at].positions;
            for (point, &from) in points.iter_mut().zip(&partner) {
                *point = original[from];
                point.y = -point.y;
            }
        })
    }
}
