//! A base point and directions of bones → joints.
//!
//! `pᵢ = base + Σ lengths × directions` along the tree, laid outwards from the base joint, so that
//! bones have their lengths whatever the directions do.

use std::ops::Add;

use super::jet::Jet;
use super::settings::SafetyError;
use crate::geometry::{Point, Vector, direction_or};
use crate::skeleton::{JointId, Skeleton};

/// A bone as laid from the base outwards.
#[derive(Debug, Clone, Copy)]
pub(super) struct Link {
    /// The end nearer the base.
    pub(super) from: usize,
    /// The end farther from it.
    pub(super) to: usize,
    /// `[m]`.
    pub(super) length: f64,
}

/// The tree. Its coordinates are the base point, then one direction a link.
#[derive(Debug, Clone)]
pub(super) struct Chain {
    base: usize,
    links: Box<[Link]>,
}

impl Chain {
    /// - `lengths`: `[m]`, in the skeleton's bone order.
    ///
    /// # Errors
    /// [`SafetyError::Bones`], [`SafetyError::Length`].
    pub(super) fn new(
        skeleton: &Skeleton,
        base: JointId,
        lengths: &[f64],
    ) -> Result<Self, SafetyError> {
        let bones = skeleton.bones().len();
        if lengths.len() != bones {
            return Err(SafetyError::Bones { lengths: lengths.len(), bones });
        }
        let is_length = |length: f64| length > 0.0 && length <= 10.0;
        if let Some(bone) = lengths.iter().position(|length| !is_length(*length)) {
            return Err(SafetyError::Length { bone, length: lengths[bone] });
        }
        let mut links: Vec<Link> = Vec::with_capacity(bones);
        let (mut reached, mut at) = (vec![base.index()], 0);
        while let Some(&from) = reached.get(at) {
            for (bone, &length) in skeleton.bones().zip(lengths) {
                let ends = [bone.parent.index(), bone.child.index()];
                for (near, to) in [(ends[0], ends[1]), (ends[1], ends[0])] {
                    if near == from && !reached.contains(&to) {
                        links.push(Link { from, to, length });
                        reached.push(to);
                    }
                }
            }
            at += 1;
        }
        Ok(Self { base: base.index(), links: links.into() })
    }

    /// The joint that all others are laid from.
    pub(super) fn base(&self) -> usize {
        self.base
    }

    /// Bones, from the base outwards.
    pub(super) fn links(&self) -> &[Link] {
        &self.links
    }

    pub(super) fn joints(&self) -> usize {
        self.links.len() + 1
    }

    /// The coordinates of a pose `[m]`: its base and its directions; a bone without length keeps
    /// the direction it has in `coordinates`, which are overwritten.
    pub(super) fn coordinates_of(&self, pose: impl Fn(usize) -> Point, coordinates: &mut [Vector]) {
        coordinates[0] = pose(self.base).coords;
        for (link, direction) in self.links.iter().zip(&mut coordinates[1..]) {
            *direction = direction_or(pose(link.to) - pose(link.from), *direction);
        }
    }

    /// Lays joints and their derivatives.
    ///
    /// - `coordinate`: base or direction, by its place among the coordinates.
    pub(super) fn lay(&self, mut coordinate: impl FnMut(usize) -> Jet, joints: &mut [Jet]) {
        joints[self.base] = coordinate(0);
        for (at, link) in self.links.iter().enumerate() {
            let (along, from) = (coordinate(at + 1), joints[link.from]);
            let to = &mut joints[link.to];
            for order in 0..4 {
                to[order] = from[order] + along[order] * link.length;
            }
        }
    }

    /// Lays joints alone: places, or velocities of coordinates that are velocities.
    pub(super) fn lay_values<T: Copy + From<Vector> + Add<Vector, Output = T>>(
        &self,
        mut coordinate: impl FnMut(usize) -> Vector,
        joints: &mut [T],
    ) {
        joints[self.base] = coordinate(0).into();
        for (at, link) in self.links.iter().enumerate() {
            joints[link.to] = joints[link.from] + coordinate(at + 1) * link.length;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::skeleton::Part;

    #[test]
    fn any_joint_may_be_the_base() {
        let skeleton = Skeleton::nite();
        let pose: Vec<Point> =
            (0..15).map(f64::from).map(|i| Point::new(i.sin(), (2.0 * i).cos(), 0.1 * i)).collect();
        let along =
            |bone: crate::skeleton::Bone| pose[bone.child.index()] - pose[bone.parent.index()];
        let lengths: Vec<f64> = skeleton.bones().map(|bone| along(bone).norm()).collect();
        for base in [Part::Torso, Part::Neck, Part::Hand(crate::skeleton::Side::Left)] {
            let base = skeleton.part(base).unwrap();
            let chain = Chain::new(&skeleton, base, &lengths).unwrap();
            let mut coordinates = vec![Vector::z(); chain.joints()];
            chain.coordinates_of(|joint| pose[joint], &mut coordinates);
            let mut laid = vec![Point::origin(); chain.joints()];
            chain.lay_values(|at| coordinates[at], &mut laid);
            assert!(laid.iter().zip(&pose).all(|(a, b)| (a - b).norm() < 1e-12));
        }
        let refused = |lengths: &[f64]| Chain::new(&skeleton, skeleton.root(), lengths).is_err();
        assert!(refused(&lengths[1..]) && refused(&[0.0; 14]) && refused(&[f64::NAN; 14]));
    }
}
