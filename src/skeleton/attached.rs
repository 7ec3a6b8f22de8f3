//! Points that ride on a joint as if they had grown there: a thing in a hand, the hull of a link.
//!
//! They are joints like others, behind a person's own in a [`Skeleton`], each at the end of a bone
//! from the joint that it rides on; so whatever is made of joints has them. A joint has a place and
//! no orientation, so what rides on it is turned by its bone: by the smallest rotation from the
//! direction that the bone had to the one that it has.

use std::sync::Arc;

use super::{Frame, JointId, Recording, Role, Sequence, SequenceError, Skeleton, SkeletonError};
use crate::geometry::{Point, Vector, is_finite, smallest_rotation};

/// Where the attached joints of a skeleton sit on the joints that they ride on.
///
/// ```
/// use handover_mesh::{Point, Skeleton, Vector, skeleton::Riders};
/// let bare = Skeleton::nite();
/// let hand = bare.joint("right_hand").unwrap();
/// let skeleton = bare.with_attached(hand, &["cup".to_owned()])?;
/// let mut pose = vec![Point::origin(); 16];
/// pose[8] = Point::new(0.3, 0.0, 0.0); // the hand, its elbow at the origin
/// pose[15] = Point::new(0.4, 0.0, 0.0);
/// let cup = Riders::new(&skeleton, &pose);
/// pose[8] = Point::new(0.0, 0.3, 0.0);
/// cup.place(&mut pose);
/// assert!((pose[15] - Point::new(0.0, 0.4, 0.0)).norm() < 1e-12);
/// # Ok::<(), handover_mesh::skeleton::SkeletonError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Riders(Vec<Rider>);

/// Why points cannot ride on a joint.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AttachError {
    /// Their names are there already, or they are too many.
    #[error(transparent)]
    Skeleton(#[from] SkeletonError),
    /// They are nowhere.
    #[error(transparent)]
    Sequence(#[from] SequenceError),
}

/// One attached joint.
#[derive(Debug, Clone, PartialEq)]
struct Rider {
    at: usize,
    joint: usize,
    /// Where the bone begins that ends at the joint; none at the root.
    from: Option<usize>,
    /// From the joint to the rider `[m]`, when the bone was along `along` `[m]`.
    offset: Vector,
    along: Vector,
}

impl Rider {
    fn along(&self, pose: &[Point]) -> Vector {
        self.from.map_or(Vector::zeros(), |from| pose[self.joint] - pose[from])
    }
}

impl Riders {
    /// As they sit in a pose.
    ///
    /// - `pose`: `[m]`, one point per joint, finite.
    ///
    /// # Panics
    /// If the pose has another number of joints: the caller's bug.
    pub fn new(skeleton: &Skeleton, pose: &[Point]) -> Self {
        assert_eq!(pose.len(), skeleton.len(), "one point per joint");
        let bone = |child: JointId| skeleton.bones().find(|bone| bone.child == child);
        let riders = skeleton.attached().filter_map(|rider| {
            let joint = bone(rider)?.parent;
            let from = bone(joint).map(|bone| bone.parent.index());
            let (at, joint) = (rider.index(), joint.index());
            Some(Rider { at, joint, from, offset: Vector::zeros(), along: Vector::zeros() })
        });
        let mut riders = Self(riders.collect());
        riders.take(pose);
        riders
    }

    /// As they sit in another pose; whichever is not finite there, or rides on what is not, sits as
    /// before. Allocates nothing.
    ///
    /// - `pose`: `[m]`, one point per joint.
    pub fn take(&mut self, pose: &[Point]) {
        for rider in &mut self.0 {
            let ends = [Some(rider.at), Some(rider.joint), rider.from];
            if ends.into_iter().flatten().all(|end| is_finite(&pose[end])) {
                rider.offset = pose[rider.at] - pose[rider.joint];
                rider.along = rider.along(pose);
            }
        }
    }

    /// Puts them where they are in a pose. Allocates nothing.
    ///
    /// - `pose`: `[m]`, one point per joint; the attached ones are overwritten.
    pub fn place(&self, pose: &mut [Point]) {
        for rider in &self.0 {
            let turn = smallest_rotation(rider.along, rider.along(pose));
            pose[rider.at] = pose[rider.joint] + turn * rider.offset;
        }
    }
}

impl Skeleton {
    /// As [`Self::new`], where the last joints are attached: each rides on one of the others.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn new_with_attached(
        mut names: Vec<String>,
        bones: &[[usize; 2]],
        attached: usize,
    ) -> Result<Self, SkeletonError> {
        let own = names.len().saturating_sub(attached);
        let riders = names.split_off(own);
        let (last, first): (Vec<_>, Vec<_>) = bones.iter().partition(|[_, child]| *child >= own);
        let mut skeleton = Self::new(names, &first)?;
        for (at, name) in (own..).zip(&riders) {
            let mut ends = last.iter().filter(|[_, child]| *child == at);
            let joint = match (ends.next(), ends.next()) {
                (Some([parent, _]), None) => skeleton.joints().take(own).nth(*parent),
                _ => None,
            };
            let fault = || {
                let problem = "to ride on one joint of the body";
                SkeletonError::NotATree { joint: name.clone(), problem }
            };
            skeleton =
                skeleton.with_attached(joint.ok_or_else(fault)?, std::slice::from_ref(name))?;
        }
        match last.into_iter().find(|[_, child]| *child >= own + riders.len()) {
            Some([_, child]) => {
                let problem = "a bone but is no joint";
                Err(SkeletonError::NotATree { joint: format!("#{child}"), problem })
            }
            None => Ok(skeleton),
        }
    }

    /// Shifts a joint, and what rides on it, `by` `[m]`.
    ///
    /// - `pose`: `[m]`, one point per joint.
    pub fn shift_with_riders(&self, joint: JointId, by: Vector, pose: &mut [Point]) {
        pose[joint.index()] += by;
        // Their bones are the last ones.
        for bone in self.bones().skip(self.own() - 1).filter(|bone| bone.parent == joint) {
            pose[bone.child.index()] += by;
        }
    }
}

impl Sequence {
    /// The same motion with points that ride on a joint.
    ///
    /// - `frame`: at which they are where they are said to be.
    /// - `points`: by name, `[m]` in the world, finite.
    ///
    /// # Errors
    /// [`AttachError`] on names that are there already, too many joints, a place that is not finite.
    ///
    /// # Panics
    /// If there is no such frame: the caller's bug.
    pub fn with_attached(
        &self,
        joint: JointId,
        frame: usize,
        points: &[(String, Point)],
    ) -> Result<Self, AttachError> {
        let names: Vec<String> = points.iter().map(|(name, _)| name.clone()).collect();
        let skeleton = self.skeleton().with_attached(joint, &names)?;
        let with = |at: usize| -> Box<[Point]> {
            let own = self.frames()[at].positions.iter().copied();
            own.chain(points.iter().map(|(_, place)| *place)).collect()
        };
        let riders = Riders::new(&skeleton, &with(frame));
        let frames = (0..self.len()).map(|at| {
            let mut positions = with(at);
            // A place that is nowhere stays so, and is refused.
            if points.iter().all(|(_, place)| is_finite(place)) {
                riders.place(&mut positions);
            }
            Frame { stamp: self.frames()[at].stamp, positions }
        });
        Ok(Self::new(Arc::new(skeleton), frames.collect())?)
    }
}

impl Recording {
    /// The same with points that ride on a joint of one person: see [`Sequence::with_attached`].
    ///
    /// # Errors
    /// As [`Sequence::with_attached`].
    ///
    /// # Panics
    /// As [`Sequence::with_attached`].
    pub fn with_attached(
        &self,
        role: Role,
        joint: JointId,
        frame: usize,
        points: &[(String, Point)],
    ) -> Result<Self, AttachError> {
        let motion = self.person(role).motion.with_attached(joint, frame, points)?;
        Ok(self.replacing(role, motion))
    }
}
