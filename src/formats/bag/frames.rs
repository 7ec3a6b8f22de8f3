//! Static transforms → how frames of a bag lie to each other.

use std::collections::BTreeMap;

use nalgebra::{Quaternion, Translation3, UnitQuaternion};

use crate::geometry::{Isometry, Vector};
use crate::messages::{Transform, TransformTree};

/// More edges than any robot has between a sensor and the world.
const DEEPEST: usize = 64;
const MOST: usize = 1 << 14;

/// What `/tf_static` says, the latest of each frame.
#[derive(Debug, Default)]
pub(super) struct Statics {
    /// Parent, and parent from child.
    edges: BTreeMap<String, (String, Isometry)>,
}

impl Statics {
    pub(super) fn take(&mut self, message: &TransformTree) {
        for edge in &message.transforms {
            let [child, parent] = [&edge.child_frame_id, &edge.header.frame_id]
                .map(|frame| frame.trim_start_matches('/').to_owned());
            let parent_from_child = isometry(&edge.transform);
            if let Some(parent_from_child) = parent_from_child.filter(|_| self.edges.len() < MOST) {
                self.edges.insert(child, (parent, parent_from_child));
            }
        }
    }

    /// `to` from `from`, if static transforms join the two.
    pub(super) fn between(&self, to: &str, from: &str) -> Option<Isometry> {
        let (to_root, root_from_to) = self.root(to)?;
        let (from_root, root_from_from) = self.root(from)?;
        (to_root == from_root).then(|| root_from_to.inverse() * root_from_from)
    }

    /// The frame that all hangs from, and it from this one; `None` in a ring.
    fn root<'a>(&'a self, frame: &'a str) -> Option<(&'a str, Isometry)> {
        let (mut at, mut root_from_frame) = (frame, Isometry::identity());
        for _ in 0..DEEPEST {
            let Some((parent, parent_from_child)) = self.edges.get(at) else {
                return Some((at, root_from_frame));
            };
            root_from_frame = parent_from_child * root_from_frame;
            at = parent;
        }
        None
    }
}

/// The transform, if it is one.
fn isometry(transform: &Transform) -> Option<Isometry> {
    let (t, q) = (Vector::from(transform.translation), transform.rotation);
    let turn = UnitQuaternion::try_new(Quaternion::new(q.w, q.x, q.y, q.z), 1e-6)?;
    let finite = t.iter().chain(turn.coords.iter()).all(|value| value.is_finite());
    finite.then(|| Isometry::from_parts(Translation3::from(t), turn))
}
