//! From the thread that spins to the one that ticks: the newest of each kind, without a lock.

use crossbeam_queue::ArrayQueue;

use crate::bodies::Body;
use crate::live::Inputs;
use crate::messages::{PoseStamped, TransformTree};

/// What came in since the last tick. What is full gives up its oldest.
#[derive(Debug)]
pub(super) struct Inbox {
    bodies: ArrayQueue<Body>,
    robot: ArrayQueue<Body>,
    object: ArrayQueue<PoseStamped>,
    transforms: ArrayQueue<TransformTree>,
    refused: ArrayQueue<String>,
}

impl Default for Inbox {
    fn default() -> Self {
        Self {
            bodies: ArrayQueue::new(16),
            robot: ArrayQueue::new(1),
            object: ArrayQueue::new(1),
            transforms: ArrayQueue::new(64),
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

    pub(super) fn transforms(&self, tree: TransformTree) {
        self.transforms.force_push(tree);
    }

    pub(super) fn refuse(&self, reason: String) {
        self.refused.force_push(reason);
    }

    /// Whether somebody is seen: not to be kept waiting.
    pub(super) fn has_body(&self) -> bool {
        !self.bodies.is_empty()
    }

    /// Takes all there is.
    pub(super) fn take(&self, inputs: &mut Inputs) {
        inputs.bodies.clear();
        inputs.bodies.extend(std::iter::from_fn(|| self.bodies.pop()).take(self.bodies.capacity()));
        inputs.transforms.clear();
        let trees = std::iter::from_fn(|| self.transforms.pop());
        inputs.transforms.extend(trees.take(self.transforms.capacity()));
        inputs.robot = self.robot.pop();
        inputs.object = self.object.pop();
        inputs.refused = self.refused.pop();
    }
}
