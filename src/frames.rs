//! The tree of frames: what `/tf` and `/tf_static` say of how frames lie to each other.
//!
//! `to_from_from = ancestor_from_to⁻¹ · ancestor_from_from` at the nearest frame that both hang
//! from. Fixed edges hold for ever, moving ones as long as they are heard of. A frame without a name
//! is any frame.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use nalgebra::{Quaternion, UnitQuaternion};

use crate::geometry::{Isometry, Vector};
use crate::messages::{Transform, TransformTree};
use crate::time::Stamp;

/// How frames lie to each other, as of any moment that is remembered.
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
/// let world_from_camera = tree.between("world", "/camera", [Stamp(0); 2]).unwrap();
/// assert_eq!(world_from_camera * Point::origin(), Point::new(0., 0., 2.));
/// assert_eq!(tree.between("world", "moon", [Stamp(0); 2]), None);
/// ```
#[derive(Debug, Clone, Default)]
pub struct FrameTree {
    fixed: BTreeMap<String, Edge>,
    moving: BTreeMap<String, Moving>,
    /// When it was last gone through for what has not been heard of for long.
    swept: Option<Stamp>,
}

/// An edge that moves, as of some moments, the newest last.
#[derive(Debug, Clone, Default)]
struct Moving {
    /// When it was heard last; nobody asks of what was recorded.
    heard: Option<Stamp>,
    known: VecDeque<(Stamp, Edge)>,
}

#[derive(Debug, Clone)]
struct Edge {
    parent: Arc<str>,
    parent_from_child: Isometry,
}

impl FrameTree {
    /// A moving edge not heard of for so long `[s]` holds no more.
    pub const STALE: f64 = 1.0;
    /// Of how many moments an edge is remembered: a second, if it is told at 200 Hz.
    const REMEMBERED: usize = 200;
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

    /// Takes in edges that move, heard at `now`; one that is no rigid motion is left out. Those of
    /// the last second are remembered, so that what was seen a moment ago is put where its frame was
    /// then.
    pub fn take(&mut self, tree: &TransformTree, now: Stamp) {
        for (child, stamp, edge) in edges(tree) {
            let Some(moving) = self.moving(child, now) else { continue };
            if moving.heard.is_some_and(|heard| now < heard) {
                // The clock was set back: nothing of what was holds.
                moving.known.clear();
            }
            moving.heard = Some(now);
            let stamp = if stamp == Stamp(0) { now } else { stamp };
            if moving.known.back().is_some_and(|(last, _)| stamp < *last && !is_fresh(*last, stamp))
            {
                // What was known was of another clock.
                moving.known.clear();
            }
            moving.insert(stamp, edge);
            let newest = moving.known.back().map_or(now, |(stamp, _)| *stamp);
            while let Some((oldest, _)) = moving.known.front()
                && (moving.known.len() > Self::REMEMBERED
                    || (newest - *oldest).seconds() > Self::STALE)
            {
                moving.known.pop_front();
            }
        }
    }

    /// Takes in edges that move, all that there ever were: they are remembered for ever. Nothing may
    /// be asked before [`Self::sort`] is called.
    pub fn record(&mut self, tree: &TransformTree) {
        for (child, stamp, edge) in edges(tree) {
            if let Some(moving) = self.moving(child, stamp) {
                moving.push(stamp, edge);
            }
        }
    }

    /// Puts what was [recorded](Self::record) in the order of its stamps.
    pub fn sort(&mut self) {
        for moving in self.moving.values_mut() {
            moving.known.make_contiguous().sort_by_key(|(stamp, _)| *stamp);
        }
    }

    /// Those of a child; none if there are too many children.
    fn moving(&mut self, child: &str, now: Stamp) -> Option<&mut Moving> {
        let is_full = self.moving.len() >= Self::MOST && !self.moving.contains_key(child);
        // A tracker that gives ever new numbers is not to use up the room for ever.
        if is_full && self.swept.is_none_or(|swept| !is_fresh(swept, now)) {
            self.swept = Some(now);
            self.moving.retain(|_, moving| moving.is_heard(now));
        }
        if self.moving.len() >= Self::MOST && !self.moving.contains_key(child) {
            return None;
        }
        Some(self.moving.entry(child.to_owned()).or_default())
    }

    /// `to_from_from` `[m]`, if the tree joins the two. Between two moments that are known a moving
    /// edge is on the shortest way; before the first and after the last it is as there.
    ///
    /// - `when`: the moment that is asked about, by the edges' stamps; and now, by the clock that
    ///   [`Self::take`] is told.
    pub fn between(&self, to: &str, from: &str, when: [Stamp; 2]) -> Option<Isometry> {
        let (to, from) = (bare(to), bare(from));
        if to == from || to.is_empty() || from.is_empty() {
            return Some(Isometry::identity());
        }
        let above_to: Vec<(&str, Isometry)> = self.above(to, when).collect();
        self.above(from, when).find_map(|(ancestor, ancestor_from_from)| {
            let (_, ancestor_from_to) = above_to.iter().find(|(name, _)| *name == ancestor)?;
            Some(ancestor_from_to.inverse() * ancestor_from_from)
        })
    }

    /// The frame nearest to `frame` that does not move against the one that it and `other` hang from:
    /// `frame` itself where nothing joins them. Whether an edge moves is by how it was told, whenever
    /// that was.
    pub fn still<'a>(&'a self, frame: &'a str, other: &'a str) -> &'a str {
        let parent = |child: &&'a str| {
            let moving = self.moving.get(*child).and_then(|moving| moving.known.back());
            let edge = moving.map(|(_, edge)| edge).or_else(|| self.fixed.get(*child));
            edge.map(|edge| &*edge.parent)
        };
        let above = |frame: &'a str| std::iter::successors(Some(bare(frame)), parent);
        let (others, mut still): (Vec<&str>, _) =
            (above(other).take(Self::DEEPEST).collect(), frame);
        for child in above(frame).take(Self::DEEPEST) {
            if others.contains(&child) {
                return still;
            }
            if let (true, Some(parent)) = (self.moving.contains_key(child), parent(&child)) {
                still = parent;
            }
        }
        frame
    }

    /// Whether a frame is another one or hangs from it; `when` as of [`Self::between`].
    pub fn is_below(&self, frame: &str, ancestor: &str, when: [Stamp; 2]) -> bool {
        self.above(bare(frame), when).any(|(name, _)| name == bare(ancestor))
    }

    /// A frame and those above it, each with `that_from_frame`.
    fn above<'a>(
        &'a self,
        frame: &'a str,
        when: [Stamp; 2],
    ) -> impl Iterator<Item = (&'a str, Isometry)> {
        let up = move |(name, from_frame): &(&'a str, Isometry)| {
            let (parent, parent_from_child) = self.edge(name, when)?;
            Some((parent, parent_from_child * from_frame))
        };
        std::iter::successors(Some((frame, Isometry::identity())), up).take(Self::DEEPEST)
    }

    /// The parent, and how the child lies to it.
    fn edge(&self, child: &str, [at, now]: [Stamp; 2]) -> Option<(&str, Isometry)> {
        let moving = self.moving.get(child).filter(|moving| moving.is_heard(now));
        let fixed = || self.fixed.get(child).map(|edge| (&*edge.parent, edge.parent_from_child));
        moving.and_then(|moving| moving.at(at)).or_else(fixed)
    }
}

impl Moving {
    fn is_heard(&self, now: Stamp) -> bool {
        self.heard.is_none_or(|heard| is_fresh(heard, now))
    }

    /// Adds the newest.
    fn push(&mut self, stamp: Stamp, mut edge: Edge) {
        // The parent is mostly the same: a recording has very many edges.
        let last = self.known.back().map(|(_, edge)| &edge.parent);
        if let Some(same) = last.filter(|last| **last == edge.parent) {
            edge.parent = same.clone();
        }
        self.known.push_back((stamp, edge));
    }

    /// Adds one that may be older than others.
    fn insert(&mut self, stamp: Stamp, edge: Edge) {
        self.push(stamp, edge);
        let mut at = self.known.len() - 1;
        while at > 0 && self.known[at - 1].0 > stamp {
            self.known.swap(at - 1, at);
            at -= 1;
        }
    }

    /// The parent, and how the child lay to it; none where nothing near in time is known.
    fn at(&self, at: Stamp) -> Option<(&str, Isometry)> {
        let after = self.known.partition_point(|(stamp, _)| *stamp <= at);
        let known = |index: usize| self.known.get(index).filter(|(then, _)| is_fresh(*then, at));
        let before = after.checked_sub(1).and_then(known);
        let (then, edge) = before.or_else(|| known(after))?;
        let here = edge.parent_from_child;
        let next = known(after).filter(|(later, next)| later > then && next.parent == edge.parent);
        let between = next.and_then(|(later, next)| {
            let part = (at - *then).seconds() / (*later - *then).seconds();
            here.try_lerp_slerp(&next.parent_from_child, part, 1e-6)
        });
        Some((&*edge.parent, between.unwrap_or(here)))
    }
}

/// Whether something is near enough in time to hold.
fn is_fresh(then: Stamp, now: Stamp) -> bool {
    (now - then).seconds().abs() <= FrameTree::STALE
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
        let found = tree.between("world", "/depth", [now; 2]).unwrap();
        let p = Point::new(0.3, -0.2, 1.4);
        assert!((found * p - expected * p).norm() < 1e-12);
        assert_eq!(tree.between("world", "", [now; 2]), Some(Isometry::identity()));
        assert_eq!(tree.between("world", "elsewhere", [now; 2]), None);
        // What moves and is heard of no more is nowhere; what is fixed stays.
        let later = Stamp(now.0 + 1_100_000_000);
        assert_eq!(tree.between("world", "depth", [later; 2]), None);
        assert!(tree.between("world", "camera", [later; 2]).is_some());
    }

    #[test]
    fn what_stands_still_is_above_all_that_moves() {
        let lens = yaw_isometry(0.2, Vector::x());
        let mut tree = FrameTree::default();
        let fixed = [("map", "world"), ("head", "camera"), ("odom", "wheel"), ("world", "wall")];
        let transforms = fixed.map(|(parent, child)| edge(parent, child, &lens)).to_vec();
        tree.fix(&TransformTree { transforms });
        let moving = [("world", "odom"), ("odom", "base"), ("base", "head")];
        let transforms = moving.map(|(parent, child)| edge(parent, child, &lens)).to_vec();
        tree.record(&TransformTree { transforms });
        tree.sort();
        for (frame, other, still) in [
            ("camera", "world", "world"),
            ("world", "camera", "world"),
            ("/wall", "camera", "/wall"),
            ("camera", "wheel", "odom"),
            ("camera", "base", "base"),
            ("camera", "moon", "camera"),
            ("camera", "camera", "camera"),
        ] {
            assert_eq!(tree.still(frame, other), still, "{frame} {other}");
        }
    }

    #[test]
    fn what_was_recorded_is_known_of_every_moment() {
        let at = |k: i64| Stamp(k * 100_000_000);
        let place = |k: f64| yaw_isometry(0.1 * k, Vector::new(k, 0.0, 0.0));
        let mut tree = FrameTree::default();
        // Not quite in order, as publishers are heard.
        for k in [1, 2, 4, 3, 5] {
            let mut edge = edge("world", "head", &place(k as f64));
            edge.header.stamp = crate::messages::Time::of(at(k));
            tree.record(&TransformTree { transforms: vec![edge] });
        }
        tree.sort();
        let known = |now: Stamp| tree.between("world", "head", [now; 2]);
        let near = |a: Isometry, b: Isometry| {
            (a.inverse() * b).translation.vector.norm() < 1e-12
                && a.rotation.angle_to(&b.rotation) < 1e-12
        };
        for k in 1..5 {
            assert!(near(known(at(k)).unwrap(), place(k as f64)), "{k}");
            let later = known(Stamp(at(k).0 + 75_000_000)).unwrap();
            assert!(near(later, place(k as f64 + 0.75)), "{k}");
        }
        // Just before the first and after the last, and long after.
        assert!(near(known(Stamp(0)).unwrap(), place(1.0)));
        assert!(near(known(at(9)).unwrap(), place(5.0)));
        assert!(known(Stamp(at(5).0 + 1_000_000_001)).is_none());
        assert!(known(Stamp(at(1).0 - 1_000_000_001)).is_none());
    }

    #[test]
    fn what_is_heard_is_remembered_for_a_moment() {
        let place = |at: i64| yaw_isometry(at as f64 * 1e-9, Vector::x());
        let mut tree = FrameTree::default();
        // 50 Hz, heard 40 ms late.
        for at in (0..200).map(|k| k * 20_000_000 + 1_000_000_000) {
            let mut edge = edge("world", "head", &place(at));
            edge.header.stamp = crate::messages::Time::of(Stamp(at));
            tree.take(&TransformTree { transforms: vec![edge] }, Stamp(at + 40_000_000));
        }
        let (last, now) = (1_000_000_000 + 199 * 20_000_000, Stamp(1_000_000_000 + 4_020_000_000));
        let off = |tree: &FrameTree, at: i64| {
            let head = tree.between("world", "head", [Stamp(at), now])?;
            Some(head.rotation.angle_to(&place(at).rotation))
        };
        for before in [0, 7_000_000, 33_000_000, 90_000_000, 900_000_000] {
            assert!(off(&tree, last - before).unwrap() < 1e-9, "{before}");
        }
        assert!(tree.moving["head"].known.len() <= 51);
        // Nothing of what was holds when the clock is set back, or when nothing is heard any more.
        let mut back = tree.clone();
        let early = TransformTree { transforms: vec![edge("world", "head", &place(0))] };
        back.take(&early, Stamp(2_000_000_000));
        assert_eq!(back.moving["head"].known.len(), 1);
        assert!(
            tree.between("world", "head", [Stamp(last), now + crate::Span(1_000_000_001)])
                .is_none()
        );
        // Nor does what was said by the old clock and comes only now.
        let old = Moving::default();
        back.moving.insert("head".to_owned(), old);
        for k in 0..20 {
            let stamp = if k == 3 { 60_000_000_000 } else { 2_000_000_000 + k * 20_000_000 };
            let mut edge = edge("world", "head", &place(stamp));
            edge.header.stamp = crate::messages::Time::of(Stamp(stamp));
            let heard = Stamp(2_000_000_000 + k * 20_000_000);
            back.take(&TransformTree { transforms: vec![edge] }, heard);
            let head = back.between("world", "head", [heard; 2]);
            assert_eq!(head.is_some(), k != 3, "{k}");
        }
        // Ever new children do not use up the room.
        for k in 0..3 * FrameTree::MOST as i64 {
            let new =
                TransformTree { transforms: vec![edge("head", &format!("a_{k}"), &place(0))] };
            tree.take(&new, now + crate::Span(k * 1_000_000));
        }
        let at = now + crate::Span(3 * FrameTree::MOST as i64 * 1_000_000);
        let newest = format!("a_{}", 3 * FrameTree::MOST - 1);
        assert!(tree.between("head", &newest, [at; 2]).is_some());
        assert!(tree.moving.len() <= FrameTree::MOST);
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
        assert_eq!(tree.between("world", "a", [Stamp(0); 2]), None);
        assert_eq!(tree.between("world", "broken", [Stamp(0); 2]), None);
    }
}
