//! Frames of the transform tree → bodies: a tracker may send a message for each joint.
//!
//! Trackers stamp the joints of one body all alike, or (openni_tracker) each as it is sent, so that
//! what is near in time belongs together, and a joint that comes again begins the next body.
//! Joints may hang from each other (REP-155): places are then those along the chain, from the first
//! frame that is not the body's own.

use std::collections::BTreeMap;

use super::names::joint_of_frame;
use super::{Body, frame};
use crate::frames::rotation;
use crate::geometry::{Point, Vector, is_finite};
use crate::messages::{Transform, TransformTree};
use crate::time::{Span, Stamp};

/// Joints of one body are stamped within this time; bodies are farther apart.
const TOGETHER: Span = Span(12_000_000);
/// More frames than any tracker gives a body, and more bodies than any follows.
const MOST_FRAMES: usize = 128;
const MOST_BODIES: usize = 64;

/// Puts together what belongs together; holds a bounded amount whatever comes.
///
/// ```
/// use handover_mesh::bodies::{Body, TransformAssembler, to_transforms};
/// use handover_mesh::{Point, Stamp};
/// let body = |stamp| Body {
///     stamp,
///     frame: "camera".to_owned(),
///     id: Some(1),
///     joints: vec![("head".into(), Point::new(0., 0., 2.)), ("torso".into(), Point::origin())],
/// };
/// let mut assembler = TransformAssembler::default();
/// // How many joints there are is known from the second body on, which is there at once.
/// assert_eq!(assembler.take(&to_transforms(&body(Stamp(0)))), []);
/// let later = body(Stamp(33_000_000));
/// assert_eq!(assembler.take(&to_transforms(&later)), [body(Stamp(0)), later]);
/// assert_eq!(assembler.finish(), []);
/// ```
#[derive(Debug, Clone, Default)]
pub struct TransformAssembler {
    open: BTreeMap<u32, Open>,
}

/// A body that may not be whole yet.
#[derive(Debug, Clone, Default)]
struct Open {
    stamp: Stamp,
    /// Parent and transform of each joint's frame, by its name.
    joints: BTreeMap<String, (String, Transform)>,
    /// The newest of frames with the body's number that are no joints: these may hang from them, as
    /// REP-155's do. A robot's `link_1` is called like that too, so they say nothing of when.
    others: BTreeMap<String, (Stamp, (String, Transform))>,
    /// How many joints the body before had.
    expected: Option<usize>,
    /// With how many joints it was handed out already.
    handed_out: Option<usize>,
}

impl TransformAssembler {
    /// Takes some edges; returns the bodies that are whole with them, by their stamps' order.
    ///
    /// A body is whole when it has as many joints as it had before, or when its next one begins;
    /// one that then turns out to have more joints is returned again, with the same stamp.
    pub fn take(&mut self, message: &TransformTree) -> Vec<Body> {
        let mut whole = Vec::new();
        let mut touched = Vec::new();
        for edge in &message.transforms {
            let child = frame(&edge.child_frame_id);
            let Some(name) = joint_of_frame(&child) else { continue };
            if !self.open.contains_key(&name.id) && self.open.len() >= MOST_BODIES {
                self.forget_oldest();
            }
            let open = self.open.entry(name.id).or_default();
            let place = (frame(&edge.header.frame_id), edge.transform);
            let stamp = edge.header.stamp.stamp();
            if name.joint.is_none() {
                if open.others.len() < MOST_FRAMES || open.others.contains_key(&child) {
                    open.others.insert(child, (stamp, place));
                }
                continue;
            }
            let apart = (stamp - open.stamp).0.saturating_abs() > TOGETHER.0;
            if !open.joints.is_empty() && (apart || open.joints.contains_key(&child)) {
                whole.extend(open.close(name.id));
            }
            if open.joints.is_empty() {
                open.stamp = stamp;
            }
            if open.joints.len() < MOST_FRAMES {
                open.joints.insert(child, place);
                touched.push(name.id);
            }
        }
        touched.sort_unstable();
        touched.dedup();
        for id in touched {
            let Some(open) = self.open.get_mut(&id) else { continue };
            if open.expected.is_some_and(|expected| open.joints.len() >= expected) {
                whole.extend(open.hand_out(id));
            }
        }
        whole
    }

    /// What was not handed out yet, as it is; the assembler is as new.
    pub fn finish(&mut self) -> Vec<Body> {
        let open = std::mem::take(&mut self.open);
        open.into_iter().filter_map(|(id, mut open)| open.close(id)).collect()
    }

    /// Whoever was seen the longest time ago is not coming back under that number.
    fn forget_oldest(&mut self) {
        let oldest = self.open.iter().min_by_key(|(_, open)| open.stamp).map(|(id, _)| *id);
        if let Some(id) = oldest {
            self.open.remove(&id);
        }
    }
}

impl Open {
    /// The body, unless it was handed out with as many joints; begins the next.
    fn close(&mut self, id: u32) -> Option<Body> {
        let body = self.hand_out(id);
        let expected = Some(self.joints.len()).filter(|joints| *joints > 0).or(self.expected);
        let mut others = std::mem::take(&mut self.others);
        others.retain(|_, (stamp, _)| self.is_near(*stamp));
        *self = Self { expected, others, ..Self::default() };
        body
    }

    fn hand_out(&mut self, id: u32) -> Option<Body> {
        if self.joints.is_empty() || self.handed_out == Some(self.joints.len()) {
            return None;
        }
        self.handed_out = Some(self.joints.len());
        let mut root = None;
        let mut joints: Vec<(String, Point)> = Vec::new();
        for name in self.joints.keys() {
            let Some(joint) = joint_of_frame(name).and_then(|name| name.joint) else { continue };
            let Some((parent, place)) = self.place(name) else { continue };
            // One frame for all: a joint that hangs from elsewhere is not where the others are.
            if *root.get_or_insert(parent) == parent && is_finite(&place) {
                let known = joints.iter().any(|(known, _)| known == joint);
                joints.extend((!known).then(|| (joint.to_owned(), place)));
            }
        }
        let frame = root?.to_owned();
        Some(Body { stamp: self.stamp, frame, id: Some(id), joints })
    }

    /// Whether what was said then still holds for this body; else the tree of frames may know more.
    fn is_near(&self, stamp: Stamp) -> bool {
        (self.stamp - stamp).0.saturating_abs() <= TOGETHER.0
    }

    /// Where a frame is, in the first frame up its chain that is not the body's; `None` in a ring.
    fn place(&self, name: &str) -> Option<(&str, Point)> {
        let other = |name: &str| {
            let (stamp, edge) = self.others.get(name)?;
            self.is_near(*stamp).then_some(edge)
        };
        let edge = |name: &str| self.joints.get(name).or_else(|| other(name));
        let (parent, transform) = edge(name)?;
        let mut above = parent.as_str();
        let mut place = Point::from(transform.translation);
        let mut steps = 0;
        while let Some((next, transform)) = edge(above) {
            place = rotation(transform)? * place + Vector::from(transform.translation);
            above = next.as_str();
            steps += 1;
            if steps > 2 * MOST_FRAMES {
                return None;
            }
        }
        Some((above, place))
    }
}

#[cfg(test)]
mod tests {
    use super::super::to_transforms;
    use super::*;
    use crate::messages::Quaternion as Turn;
    use crate::messages::{Header, Time, TransformStamped};

    fn body(id: u32, stamp: i64, joints: &[&str]) -> Body {
        let place = |k: usize| Point::new(stamp as f64 * 1e-9, f64::from(id), k as f64);
        let joints = joints.iter().enumerate().map(|(k, name)| ((*name).to_owned(), place(k)));
        Body { stamp: Stamp(stamp), frame: "camera".into(), id: Some(id), joints: joints.collect() }
    }

    #[test]
    fn a_message_for_each_joint_makes_whole_bodies() {
        let joints = ["head", "neck", "torso"];
        let mut assembler = TransformAssembler::default();
        let mut found = Vec::new();
        for frame in 0..4 {
            for id in [1, 7] {
                let tree = to_transforms(&body(id, frame * 33_000_000, &joints));
                for (k, mut edge) in tree.transforms.into_iter().enumerate() {
                    // As openni_tracker does: each stamped when it is sent.
                    edge.header.stamp.nanosec += 100_000 * k as u32;
                    found.extend(assembler.take(&TransformTree { transforms: vec![edge] }));
                }
            }
        }
        found.extend(assembler.finish());
        let of_seven: Vec<Body> = found.iter().filter(|body| body.id == Some(7)).cloned().collect();
        let expected = (0..4).map(|frame| body(7, frame * 33_000_000, &joints));
        assert_eq!(of_seven, expected.collect::<Vec<_>>());
        assert_eq!(found.len(), 8);
    }

    #[test]
    fn a_joint_lost_and_found_changes_what_whole_is() {
        let mut assembler = TransformAssembler::default();
        let mut take = |stamp, joints: &[&str]| {
            let bodies = assembler.take(&to_transforms(&body(1, stamp, joints)));
            bodies.iter().map(|body| (body.stamp.0, body.joints.len())).collect::<Vec<_>>()
        };
        assert_eq!(take(0, &["head", "neck", "torso"]), []);
        assert_eq!(take(30_000_000, &["head", "neck"]), [(0, 3)]);
        assert_eq!(take(60_000_000, &["head", "neck"]), [(30_000_000, 2), (60_000_000, 2)]);
        // The third comes back: the body is known with two, and again with all.
        assert_eq!(take(90_000_000, &["head", "neck"]), [(90_000_000, 2)]);
        assert_eq!(take(90_000_000, &["torso"]), [(90_000_000, 3)]);
        assert_eq!(take(120_000_000, &["head", "neck", "torso"]), [(120_000_000, 3)]);
    }

    #[test]
    fn a_robots_links_with_a_number_are_nobodys_joints() {
        let joints = ["head", "neck", "torso"];
        let mut assembler = TransformAssembler::default();
        let mut found = Vec::new();
        for at in (0..400).map(|k| i64::from(k) * 1_000_000) {
            // A link at 100 Hz, a body at 25 Hz in three messages, none at the same moment.
            if at % 10_000_000 == 3_000_000 {
                let mut link = to_transforms(&body(1, at, &["head"])).transforms.remove(0);
                link.child_frame_id = "link_1".into();
                found.extend(assembler.take(&TransformTree { transforms: vec![link] }));
            }
            let part = usize::try_from(at % 40_000_000 / 1_000_000).unwrap();
            if let Some(joint) = [2, 5, 8].iter().position(|known| *known == part) {
                let mut edge = to_transforms(&body(1, at - 1, &joints)).transforms;
                let transforms = vec![edge.swap_remove(joint)];
                found.extend(assembler.take(&TransformTree { transforms }));
            }
        }
        found.extend(assembler.finish());
        let seen: Vec<_> = found.iter().map(|body| (body.stamp.0, body.joints.len())).collect();
        let expected = (0..10).map(|k| (k * 40_000_000 + 1_999_999, 3));
        assert_eq!(seen, expected.collect::<Vec<_>>());
    }

    #[test]
    fn chains_are_followed_and_rings_are_not() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let edge = |parent: &str, child: &str, x: f64, turn: Turn| TransformStamped {
            header: Header { stamp: Time::of(Stamp(5)), frame_id: parent.into() },
            child_frame_id: child.into(),
            transform: Transform {
                translation: crate::messages::Vector3 { x, y: 0.0, z: 0.0 },
                rotation: turn,
            },
        };
        let quarter = Turn { x: 0.0, y: 0.0, z: half, w: half };
        let mut assembler = TransformAssembler::default();
        let transforms = vec![
            edge("world", "body_1", 1.0, quarter),
            edge("body_1", "torso_1", 0.5, Turn::default()),
            edge("torso_1", "l_wrist_1", 0.25, Turn::default()),
            edge("r_wrist_1", "r_elbow_1", 1.0, Turn::default()),
            edge("r_elbow_1", "r_wrist_1", 1.0, Turn::default()),
        ];
        assert_eq!(assembler.take(&TransformTree { transforms }), []);
        let [body] = &assembler.finish()[..] else { panic!("one body") };
        assert_eq!((body.frame.as_str(), body.joints.len()), ("world", 2));
        let apart = |joint: &str, x: f64, y: f64| {
            (body.place(joint).unwrap() - Point::new(x, y, 0.0)).norm() < 1e-12
        };
        assert!(apart("torso", 1.0, 0.5) && apart("left_hand", 1.0, 0.75), "{body:?}");
    }

    #[test]
    fn what_is_held_is_bounded() {
        let mut assembler = TransformAssembler::default();
        for id in 0..10_000 {
            assembler.take(&to_transforms(&body(id, i64::from(id), &["head", "torso"])));
        }
        assert!(assembler.finish().len() <= MOST_BODIES);
        let names: Vec<String> = (0..10_000).map(|k| format!("joint{k}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        assembler.take(&to_transforms(&body(1, 0, &names)));
        assert!(assembler.open[&1].joints.len() <= MOST_FRAMES);
        assert!(assembler.open[&1].others.len() <= MOST_FRAMES);
    }
}
