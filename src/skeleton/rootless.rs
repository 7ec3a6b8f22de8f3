//! A person's pose without where they stand and which way they face.

use super::{JointId, Sequence, Skeleton};
use crate::geometry::{Isometry, Point, Vector, yaw_isometry};

impl Skeleton {
    /// The frame of a person's own: its origin at a joint, x the way they face (see
    /// [`Skeleton::heading`]), z up. Takes points in the world there: `root_from_world`.
    ///
    /// - `positions`: `[m]` in the world, one frame in skeleton order.
    pub fn root_from_world(&self, positions: &[Point], root: JointId) -> Isometry {
        let turn = yaw_isometry(-self.heading(positions), Vector::zeros());
        turn * Isometry::translation(
            -positions[root.index()].x,
            -positions[root.index()].y,
            -positions[root.index()].z,
        )
    }
}

impl Sequence {
    /// All joints at a frame, seen from the person's own frame: `[m]`, see
    /// [`Skeleton::root_from_world`].
    pub fn rootless(&self, frame: usize, root: JointId) -> impl Iterator<Item = Point> + '_ {
        let positions = &self.frames()[frame].positions;
        let root_from_world = self.skeleton().root_from_world(positions, root);
        positions.iter().map(move |p| root_from_world * p)
    }
}
