//! The past of a person → where they are now, how fast, and which way they face.

use crate::geometry::{Isometry, Point, Vector};
use crate::skeleton::{Frame, JointId, Skeleton};

/// A person at an instant, as the past tells: nothing later is known. What rides on a joint is not
/// looked at: it tells nothing that the joint does not.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    positions: Vec<Point>,
    velocities: Vec<Vector>,
    root: JointId,
    root_from_world: Isometry,
}

impl Moment {
    /// A person of whom nothing is known yet: all joints at the origin, standing still.
    pub fn new(skeleton: &Skeleton, root: JointId) -> Self {
        Self {
            positions: vec![Point::origin(); skeleton.own()],
            velocities: vec![Vector::zeros(); skeleton.own()],
            root,
            root_from_world: Isometry::identity(),
        }
    }

    /// Looks at the past, the last frame of which is now.
    ///
    /// A joint's velocity is the slope of the least-squares line through its places over the last
    /// `window` `[s]`, at least the last two; zero where there is one frame only. Without
    /// allocation.
    ///
    /// - `past`: rising stamps, `[m]` in the world, of the skeleton this was made for.
    ///
    /// # Panics
    /// If `past` is empty or of another skeleton: the caller's bug.
    pub fn observe(&mut self, skeleton: &Skeleton, past: &[Frame], window: f64) {
        let now = &past[past.len() - 1];
        self.positions.copy_from_slice(&now.positions[..skeleton.own()]);
        self.root_from_world = skeleton.root_from_world(&self.positions, self.root);
        // Jitter of a stamp leaves no frame out.
        const JITTER: f64 = 1e-3;
        let age = |frame: &Frame| (now.stamp - frame.stamp).seconds();
        let first = past.partition_point(|frame| age(frame) > window + JITTER);
        let recent = &past[first.min(past.len().saturating_sub(2))..];
        let mean_age = recent.iter().map(age).sum::<f64>() / recent.len() as f64;
        let spread: f64 = recent.iter().map(|frame| (age(frame) - mean_age).powi(2)).sum();
        self.velocities.fill(Vector::zeros());
        if spread == 0.0 {
            return;
        }
        for frame in recent {
            let share = (mean_age - age(frame)) / spread;
            for (velocity, place) in self.velocities.iter_mut().zip(&frame.positions) {
                *velocity += share * place.coords;
            }
        }
    }

    /// Where the person's own joints are: `[m]` in the world.
    pub fn positions(&self) -> &[Point] {
        &self.positions
    }

    /// How fast the joints are: `[m/s]` in the world.
    pub fn velocities(&self) -> &[Vector] {
        &self.velocities
    }

    /// The joint a person's place is taken by.
    pub fn root(&self) -> JointId {
        self.root
    }

    /// Takes points in the world to the person's own frame: see [`Skeleton::root_from_world`].
    pub fn root_from_world(&self) -> &Isometry {
        &self.root_from_world
    }

    /// The numbers that tell where a motion is: for every joint but the root its place from the
    /// root `[m]`, then its velocity relative to the root's times `velocity_weight` `[s]`, then
    /// the root's velocity times that; all in the person's own frame.
    ///
    /// - `features`: [`Self::feature_count`] numbers, overwritten.
    ///
    /// # Panics
    /// If `features` has another length: the caller's bug.
    pub fn features(&self, velocity_weight: f64, features: &mut [f64]) {
        assert_eq!(features.len(), Self::feature_count(self.positions.len()));
        let root = self.root.index();
        let turn = self.root_from_world.rotation;
        let others = || (0..self.positions.len()).filter(|joint| *joint != root);
        let places = others().map(|joint| turn * (self.positions[joint] - self.positions[root]));
        let root_velocity = self.velocities[root];
        let velocities = others()
            .map(|joint| self.velocities[joint] - root_velocity)
            .chain([root_velocity])
            .map(|velocity| turn * velocity * velocity_weight);
        for (feature, value) in features.chunks_exact_mut(3).zip(places.chain(velocities)) {
            feature.copy_from_slice(value.as_slice());
        }
    }

    /// How many features a person of this many joints has.
    pub fn feature_count(joints: usize) -> usize {
        3 * (2 * joints - 1)
    }
}
