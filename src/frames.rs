//! The tree of frames: what `/tf` and `/tf_static` say of how frames lie to each other.
//!
//! `to_from_from = ancestor_from_to⁻¹ · ancestor_from_from` at the nearest frame that both hang
//! from. Fixed edges hold for ever, moving ones as long as they are heard of. A frame without a name
//! is any frame.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{Quaternion, UnitQuaternion};

use crate::geometry::{Isometry, Vector};
use crate::messages::{Transform, TransformTree};
use crate::time::Stamp;

/// The newest edge of each child, or what they were at any time.
///
/// ```
/// use handover_mesh::frames::FrameTree;
/// use handover_mesh::messages::{Header, Transform, TransformStamped, TransformTree, Vector3};
/// use handover_mesh::{Point, Stamp};
/// let up = Transform { translation: Vector3 { x: 0., y: 0., z: 2. }, ..Transform::default() };
/// let edge = TransformStamped {
///     header: Header { frame_id: "world".into(), ..Header::default() },
///     child_frame_id: "camera".into(),
///     transform: up,
/// };
/// let mut tree = FrameTree::default();
/// tree.fix(&TransformTree { transforms: vec![edge] });
/// let world_from_camera = tree.between("world", "/camera", Stamp(0)).unwrap();
/// assert_eq!(world_from_camera * Point::origin(), Point::new(0., 0., 2.));
/// assert_eq!(tree.between("world", "moon", Stamp(0)), None);
/// ```
#[derive(Debug, Clone, Default)]
pub struct FrameTree {
    fixed: BTreeMap<String, Edge>,
    /// The newest last.
    moving: BTreeMap<String, Vec<(Stamp, Edge)>>,
}

#[derive(Debug, Clone)]
struct Edge {
    parent: Arc<str>,
    parent_from_child: Isometry,
}

impl FrameTree {
    /// A moving edge not heard of for so long `[s]` holds no more.
    pub const STALE: f64 = 1.0;
    /// No tree has so many frames; more are not kept.
    const MOST: usize = 1 << 14;
    /// No frame is so deep in the tree; a ring ends here.
    const DEEPEST: usize = 64;

    /// Takes in edges that hold for ever; one that is no rigid motion is left out.
    pub fn fix(&mut self, tree: &TransformTree) {
        for (child, _, edge) in edges(tree) {
            if self.fixed.len() < Self::MOST || self.fixed.contains_key(child) {
                self.fixed.insert(child.to_owned(), edge);
            }
        }
    }

    /// Takes in edges that move, as of `now`, in place of those before; one that is no rigid motion
    /// is left out.
    pub fn take(&mut self, tree: &TransformTree, now: Stamp) {
        for (child, _, edge) in edges(tree) {
            if let Some(known) = self.moving_edges(child) {
                known.clear();
                known.push((now, edge));
            }
        }
    }

    /// Takes in edges that move, each as of its own stamp, beside those before: what is asked about
    /// the past is answered by the newest that was known then.
    pub fn record(&mut self, tree: &TransformTree) {
        for (child, stamp, mut edge) in edges(tree) {
            if let Some(known) = self.moving_edges(child) {
                let at = known.partition_point(|(known, _)| *known <= stamp);
                // The parent is mostly the same: a recording has very many edges.
                let same = at.checked_sub(1).map(|before| &known[before].1.parent);
                if let Some(same) = same.filter(|same| **same == edge.parent) {
                    edge.parent = same.clone();
                }
                known.insert(at, (stamp, edge));
            }
        }
    }

    /// Those of a child; none if there are too many children.
    fn moving_edges(&mut self, child: &str) -> Option<&mut Vec<(Stamp, Edge)>> {
        if self.moving.len() >= Self::MOST && !self.moving.contains_key(child) {
            return None;
        }
        Some(self.moving.entry(child.to_owned()).or_default())
    }

    /// `to_from_from` `[m]` at `now`, if the tree joins the two.
    pub fn between(&self, to: &str, from: &str, now: Stamp) -> Option<Isometry> {
        let (to, from) = (bare(to), bare(from));
        if to == from || to.is_empty() || from.is_empty() {
            return Some(Isometry::identity());
        }
        let above_to: Vec<(&str, Isometry)> = self.above(to, now).collect();
        self.above(from, now).find_map(|(ancestor, ancestor_from_from)| {
            let (_, ancestor_from_to) = above_to.iter().find(|(name, _)| *name == ancestor)?;
            Some(ancestor_from_to.inverse() * ancestor_from_from)
        })
    }

    /// Whether a frame is another one or hangs from it, at `now`.
    pub fn is_below(&self, frame: &str, ancestor: &str, now: Stamp) -> bool {
        self.above(bare(frame), now).any(|(name, _)| name == bare(ancestor))
    }

    /// A frame and those above it, each with `that_from_frame`.
    fn above<'a>(
        &'a self,
        frame: &'a str,
        now: Stamp,
    ) -> impl Iterator<Item = (&'a str, Isometry)> {
        let up = move |(name, from_frame): &(&'a str, Isometry)| {
            let Edge { parent, parent_from_child } = self.edge(name, now)?;
            Some((&**parent, parent_from_child * from_frame))
        };
        std::iter::successors(Some((frame, Isometry::identity())), up).take(Self::DEEPEST)
    }

    fn edge(&self, child: &str, now: Stamp) -> Option<&Edge> {
        let newest = self.moving.get(child).and_then(|known| {
            // Who is told as of a moment that is still to come, is told of now too.
            let after = known.partition_point(|(stamp, _)| *stamp <= now);
            known.get(after.saturating_sub(1))
        });
        let fresh = |heard: Stamp| (now - heard).seconds().abs() <= Self::STALE;
        let moving = newest.filter(|(heard, _)| fresh(*heard)).map(|(_, edge)| edge);
        moving.or_else(|| self.fixed.get(child))
    }
}

/// Each child with its edge, as of when.
fn edges(tree: &TransformTree) -> impl Iterator<Item = (&str, Stamp, Edge)> {
    tree.transforms.iter().filter_map(|edge| {
        let parent_from_child = rigid(&edge.transform)?;
        let edge_now = Edge { parent: bare(&edge.header.frame_id).into(), parent_from_child };
        Some((bare(&edge.child_frame_id), edge.header.stamp.stamp(), edge_now))
    })
}

/// A frame's name without the `/` that ROS 1 put before it.
pub fn bare(frame: &str) -> &str {
    frame.strip_prefix('/').unwrap_or(frame)
}

/// The rotation, if the four numbers are one.
pub fn rotation(transform: &Transform) -> Option<UnitQuaternion<f64>> {
    let q = transform.rotation;
    let turn = UnitQuaternion::try_new(Quaternion::new(q.w, q.x, q.y, q.z), 1e-6)?;
    turn.coords.iter().all(|value| value.is_finite()).then_some(turn)
}

/// The rigid motion, if it is one.
fn rigid(transform: &Transform) -> Option<Isometry> {
    let shift = Vector::from(transform.translation);
    let is_finite = shift.iter().all(|value| value.is_finite());
    rotation(transform).filter(|_| is_finite).map(|turn| Isometry::from_parts(shift.into(), turn))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, yaw_isometry};
    use crate::messages::{Header, Quaternion as Turn, TransformStamped};

    fn edge(parent: &str, child: &str, motion: &Isometry) -> TransformStamped {
        let q = motion.rotation.coords;
        TransformStamped {
            header: Header { frame_id: parent.to_owned(), ..Header::default() },
            child_frame_id: child.to_owned(),
            transform: Transform {
                translation: motion.translation.vector.into(),
                rotation: Turn { x: q.x, y: q.y, z: q.z, w: q.w },
            },
        }
    }

    #[test]
    fn frames_are_found_up_and_down_the_tree() {
        let mount = yaw_isometry(0.7, Vector::new(1.0, 2.0, 3.0));
        let lens = Isometry::new(Vector::new(0.0, 0.1, 0.0), Vector::new(1.2, -0.3, 0.4));
        let world = yaw_isometry(-0.4, Vector::new(5.0, 0.0, 0.0));
        let mut tree = FrameTree::default();
        tree.fix(&TransformTree {
            transforms: vec![edge("/map", "world", &world), edge("map", "/camera", &mount)],
        });
        let now = Stamp(5_000_000_000);
        tree.take(&TransformTree { transforms: vec![edge("camera", "depth", &lens)] }, now);
        let expected = world.inverse() * mount * lens;
        let found = tree.between("world", "/depth", now).unwrap();
        let p = Point::new(0.3, -0.2, 1.4);
        assert!((found * p - expected * p).norm() < 1e-12);
        assert_eq!(tree.between("world", "", now), Some(Isometry::identity()));
        assert_eq!(tree.between("world", "elsewhere", now), None);
        // What moves and is heard of no more is nowhere; what is fixed stays.
        let later = Stamp(now.0 + 1_100_000_000);
        assert_eq!(tree.between("world", "depth", later), None);
        assert!(tree.between("world", "camera", later).is_some());
    }

    #[test]
    fn what_was_recorded_is_known_of_every_moment() {
        let at = |k: i64| Stamp(k * 100_000_000);
        let place = |k: i64| yaw_isometry(0.1 * k as f64, Vector::new(k as f64, 0.0, 0.0));
        let mut tree = FrameTree::default();
        // Not quite in order, as publishers are heard.
        for k in [1, 2, 4, 3, 5] {
            let mut edge = edge("world", "head", &place(k));
            edge.header.stamp = crate::messages::Time::of(at(k));
            tree.record(&TransformTree { transforms: vec![edge] });
        }
        let known = |now: Stamp| tree.between("world", "head", now);
        let near = |a: Isometry, b: Isometry| {
            (a.inverse() * b).translation.vector.norm() < 1e-12
                && a.rotation.angle_to(&b.rotation) < 1e-12
        };
        for k in 1..=5 {
            assert!(near(known(at(k)).unwrap(), place(k)), "{k}");
            assert!(near(known(Stamp(at(k).0 + 99_999_999)).unwrap(), place(k)), "{k}");
        }
        // Just before the first, and long after the last.
        assert!(near(known(Stamp(0)).unwrap(), place(1)));
        assert!(known(Stamp(at(5).0 + 1_000_000_001)).is_none());
        assert!(known(Stamp(at(1).0 - 1_000_000_001)).is_none());
    }

    #[test]
    fn rings_end_and_what_is_no_motion_is_left_out() {
        let lens = yaw_isometry(0.2, Vector::x());
        let mut broken = edge("world", "broken", &lens);
        broken.transform.rotation.w = f64::NAN;
        let mut tree = FrameTree::default();
        tree.fix(&TransformTree {
            transforms: vec![edge("a", "b", &lens), edge("b", "a", &lens), broken],
        });
        assert_eq!(tree.between("world", "a", Stamp(0)), None);
        assert_eq!(tree.between("world", "broken", Stamp(0)), None);
    }
}
