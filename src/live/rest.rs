//! The robot as the demonstrations begin.

use crate::geometry::{Isometry, Point, Vector, yaw_isometry};
use crate::statistics::quantile;
use crate::track::{Library, Who};

/// The demonstrations' mean first pose of the robot's role, and its bones.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rest {
    /// From the base, facing along x: `[m]`, one per joint.
    from_base: Vec<Vector>,
    /// Medians over all frames `[m]`, in bone order.
    pub(super) bone_lengths: Vec<f64>,
}

impl Rest {
    /// The mean over all demonstrations, each turned to face along x.
    pub(super) fn of(library: &Library) -> Self {
        let skeleton = library.skeleton(Who::Robot);
        let base = library.base(Who::Robot);
        let count = library.exemplars().len();
        let mut from_base = vec![Vector::zeros(); skeleton.len()];
        for exemplar in 0..count {
            let pose = library.pose(exemplar, Who::Robot, 0.0);
            let places: Vec<Point> = skeleton.joints().map(|joint| pose.position(joint)).collect();
            let turn = yaw_isometry(-skeleton.heading(&places), Vector::zeros());
            for (sum, place) in from_base.iter_mut().zip(&places) {
                *sum += turn * (place - places[base.index()]) / count as f64;
            }
        }
        let lengths = skeleton.bones().map(|bone| {
            let frames = library.exemplars().iter().enumerate();
            let frames =
                frames.flat_map(|(at, exemplar)| (0..exemplar.len()).map(move |k| (at, k)));
            let lengths = frames.map(|(at, frame)| {
                let pose = library.pose(at, Who::Robot, frame as f64);
                (pose.position(bone.child) - pose.position(bone.parent)).norm()
            });
            quantile(lengths.collect(), 0.5).unwrap_or(0.1)
        });
        Self { bone_lengths: lengths.collect(), from_base }
    }

    /// The joints `[m]` in the world, with the base where it is said to be, facing as it does.
    pub(super) fn placed(&self, world_from_base: &Isometry) -> Vec<Point> {
        let place = |vector: &Vector| world_from_base * Point::from(*vector);
        self.from_base.iter().map(place).collect()
    }
}
