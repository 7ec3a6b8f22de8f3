//! From the thread that spins to the one that ticks: the newest of each kind, without a lock.

use crossbeam_queue::ArrayQueue;

use crate::bodies::Body;
use crate::live::Inputs;
use crate::messages::{PoseStamped, TransformTree};
use crate::time::Stamp;

/// What came in since the last tick. What is full gives up its oldest.
#[derive(Debug)]
pub(super) struct Inbox {
    bodies: ArrayQueue<Body>,
    robot: ArrayQueue<Body>,
    object: ArrayQueue<PoseStamped>,
    moving: ArrayQueue<TransformTree>,
    /// Said once and kept: they must not give way to those that move.
    fixed: ArrayQueue<TransformTree>,
    refused: ArrayQueue<(&'static str, String)>,
}

impl Default for Inbox {
    fn default() -> Self {
        Self {
            bodies: ArrayQueue::new(16),
            robot: ArrayQueue::new(1),
            object: ArrayQueue::new(1),
            moving: ArrayQueue::new(64),
            fixed: ArrayQueue::new(256),
            refused: ArrayQueue::new(1),
        }
    }
}

impl Inbox {
    pub(super) fn body(&self, body: Body) {
        self.bodies.force_push(body);
    }

    pub(super) fn robot(&self, body: Body) {
        self.robot.force_push(body);
    }

    pub(super) fn object(&self, pose: PoseStamped) {
        self.object.force_push(pose);
    }

    pub(super) fn transforms(&self, tree: TransformTree, is_fixed: bool) {
        let queue = if is_fixed { &self.fixed } else { &self.moving };
        queue.force_push(tree);
    }

    pub(super) fn refuse(&self, topic: &'static str, reason: String) {
        self.refused.force_push((topic, reason));
    }

    /// Whether somebody is seen: not to be kept waiting.
    pub(super) fn has_body(&self) -> bool {
        !self.bodies.is_empty()
    }

    /// Takes all there is at `now`; frames are added to those that are known.
    pub(super) fn take(&self, inputs: &mut Inputs, now: Stamp) {
        inputs.bodies.clear();
        inputs.bodies.extend(drain(&self.bodies));
        drain(&self.fixed).for_each(|tree| inputs.frames.fix(&tree));
        drain(&self.moving).for_each(|tree| inputs.frames.take(&tree, now));
        inputs.robot = self.robot.pop();
        inputs.object = self.object.pop();
        inputs.refused = self.refused.pop();
    }
}

/// No more than there can be at once: somebody may be filling it.
fn drain<T>(queue: &ArrayQueue<T>) -> impl Iterator<Item = T> + '_ {
    std::iter::from_fn(|| queue.pop()).take(queue.capacity())
}
