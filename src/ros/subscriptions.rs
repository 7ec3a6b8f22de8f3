//! What the handover node hears: bytes → messages → the inbox.

use anyhow::Result;
use r2r::{Node, QosProfile};

use super::inbox::Inbox;
use super::shell::Messages;
use crate::bodies::{self, TransformAssembler};
use crate::config::Source;
use crate::messages::{MarkerArray, MultiDofJointState, PoseStamped, TransformTree};

/// Where frames are told that never move.
const FIXED: &str = "/tf_static";

/// The subscriptions of the handover node.
pub(super) struct Subscriptions {
    skeleton: Option<Messages<MultiDofJointState>>,
    markers: Option<Messages<MarkerArray>>,
    robot: Messages<MultiDofJointState>,
    object: Messages<PoseStamped>,
    /// Moving and fixed frames; none where `tf2_msgs` was not installed where this was built.
    transforms: Vec<Messages<TransformTree>>,
    /// Puts together bodies whose joints are frames, if that is where the partner is seen.
    assembler: Option<TransformAssembler>,
}

impl Subscriptions {
    /// # Errors
    /// If a topic cannot be subscribed to, or frames are where the partner is to be seen and their
    /// messages are not known here.
    pub(super) fn new(node: &mut Node, source: Source) -> Result<Self> {
        let newest = QosProfile::sensor_data().keep_last(1);
        let skeleton = (source == Source::Skeleton)
            .then(|| Messages::new(node, "skeleton", newest.clone()))
            .transpose()?;
        let markers = (source == Source::Markers)
            .then(|| Messages::new(node, "skeleton_markers", newest.clone()))
            .transpose()?;
        let moving = QosProfile::default().keep_last(100).best_effort();
        let fixed = QosProfile::default().keep_last(100).transient_local();
        let transforms = [("/tf", moving), (FIXED, fixed)];
        let transforms: Result<Vec<_>> = transforms
            .into_iter()
            .map(|(topic, quality)| Messages::new(node, topic, quality))
            .collect();
        let transforms = match transforms {
            Ok(transforms) => transforms,
            Err(error) if source == Source::Transforms => {
                return Err(error.context("node.source is tf, but this was built without tf2_msgs"));
            }
            Err(error) => {
                r2r::log_info!(
                    node.logger(),
                    "no frames from /tf: built without tf2_msgs ({error:#})"
                );
                Vec::new()
            }
        };
        Ok(Self {
            skeleton,
            markers,
            robot: Messages::new(node, "robot_skeleton", newest.clone())?,
            object: Messages::new(node, "object_pose", newest)?,
            transforms,
            assembler: (source == Source::Transforms).then(TransformAssembler::default),
        })
    }

    /// Puts into the inbox all that has come in; says whether somebody is seen.
    pub(super) fn drain(&mut self, inbox: &Inbox) -> bool {
        let mut complain = |topic: &'static str, problem: &dyn std::fmt::Display| {
            inbox.refuse(topic, problem.to_string());
        };
        let mut sees = false;
        if let Some(skeleton) = &mut self.skeleton {
            skeleton.each(&mut complain, |message, complain| {
                match bodies::from_joint_state(&message) {
                    Ok(body) => {
                        inbox.body(body);
                        sees = true;
                    }
                    Err(error) => complain("skeleton", &error),
                }
            });
        }
        if let Some(markers) = &mut self.markers {
            markers.each(&mut complain, |message, _| {
                for body in bodies::from_markers(&message) {
                    inbox.body(body);
                    sees = true;
                }
            });
        }
        self.robot.each(&mut complain, |message, complain| {
            match bodies::from_joint_state(&message) {
                Ok(body) => inbox.robot(body),
                Err(error) => complain("robot_skeleton", &error),
            }
        });
        self.object.each(&mut complain, |message, _| inbox.object(message));
        for transforms in &mut self.transforms {
            let is_fixed = transforms.topic == FIXED;
            transforms.each(&mut complain, |message, _| {
                if let Some(assembler) = &mut self.assembler {
                    for body in assembler.take(&message) {
                        inbox.body(body);
                        sees = true;
                    }
                }
                inbox.transforms(message, is_fixed);
            });
        }
        sees
    }
}
