//! The live robot, whatever brings its messages: bodies as trackers say them → the tick → messages.
//!
//! One way: [`Inputs`] → into the world ([`Frames`]) → which body is the partner (`choice`) →
//! [`crate::online::Pipeline::tick`] → where the handover is (`state`) → [`Outputs`].
//!
//! Knows no ROS, no clock and no file: a shell brings messages and the time, and sends what comes
//! out. Trouble with a message is never an error: it is left out, and [`Outputs`] say so.

mod choice;
mod frames;
mod outputs;
mod rest;
mod robot;
mod state;

use std::sync::Arc;

use crate::bodies::Body;
use crate::config::{NodeSettings, RobotState};
use crate::filter::Sighting;
use crate::geometry::{Point, Vector};
use crate::messages::{PoseStamped, TransformTree};
use crate::online::{OnlineError, OnlineModel, TickInput};
use crate::safety::HoldReason;
use crate::time::Stamp;
use crate::track::Who;
use choice::Choice;
pub use frames::{Frames, UnknownFrame};
pub use outputs::Outputs;
use outputs::{Report, Throttle};
use rest::Rest;
use robot::Robot;
pub use state::HandoverState;
use state::{Hands, Progress};

/// What came in since the last tick; of each kind the newest, in the order in which it came.
#[derive(Debug, Clone, Default)]
pub struct Inputs {
    /// Whoever is seen: the partner is chosen among them.
    pub bodies: Vec<Body>,
    /// Where the robot's joints are.
    pub robot: Option<Body>,
    /// Where the object is.
    pub object: Option<PoseStamped>,
    /// Edges of the tree of frames.
    pub transforms: Vec<TransformTree>,
    /// What came in and could not be read, and why.
    pub refused: Option<String>,
}

/// A robot and whoever it meets.
#[derive(Debug, Clone)]
pub struct Live {
    model: Arc<OnlineModel>,
    node: NodeSettings,
    frames: Frames,
    choice: Choice,
    robot: Robot,
    progress: Progress,
    /// The newest object's place `[m]` in the world, and of when.
    object: Option<(Stamp, Point)>,
    /// The sighting's joints `[m]`: room.
    seen: Vec<Point>,
    throttle: Throttle,
    /// Why something that came in was not taken, and when.
    refused: Option<(Stamp, String)>,
    is_cancelled: bool,
}

impl Live {
    /// Nobody was seen yet.
    ///
    /// # Errors
    /// [`OnlineError`] if the demonstrations' robot cannot be moved with the model's settings.
    pub fn new(model: Arc<OnlineModel>, node: NodeSettings) -> Result<Self, OnlineError> {
        let joints = model.library().skeleton(Who::Partner).len();
        let rest = Rest::of(model.library());
        // What is wrong with limits or bones is said now, not when the robot first speaks.
        Robot::pipeline(&model, &rest.bone_lengths, node.edges)?;
        let robot = match node.robot_state {
            RobotState::Reported => Robot::unknown(&model, node.edges),
            RobotState::Demonstrated => {
                let pose = rest.placed(&node.world_from_base);
                Robot::at(&model, node.edges, pose, &rest.bone_lengths)?
            }
        };
        Ok(Self {
            frames: Frames::new(&node),
            choice: Choice::default(),
            robot,
            progress: Progress::default(),
            object: None,
            seen: vec![Point::from(Vector::repeat(f64::NAN)); joints],
            throttle: Throttle::default(),
            refused: None,
            is_cancelled: false,
            model,
            node,
        })
    }

    /// What is learned.
    pub fn model(&self) -> &Arc<OnlineModel> {
        &self.model
    }

    /// Changes what may change while it runs: who the partner is, where they are taken up, what
    /// counts as approach and contact, what is published how often.
    pub fn set(&mut self, node: &NodeSettings) {
        let NodeSettings { partner, start_zone, approach, contact_distance, .. } = *node;
        let NodeSettings { markers_rate, diagnostics_rate, .. } = *node;
        let before = self.node.clone();
        self.node = NodeSettings {
            partner,
            start_zone,
            approach,
            contact_distance,
            markers_rate,
            diagnostics_rate,
            ..before
        };
    }

    /// Calls it off: the robot brakes and stands until [`Self::reset`].
    pub fn cancel(&mut self) {
        self.is_cancelled = true;
        if let Some(pipeline) = self.robot.pipeline_mut() {
            pipeline.cancel();
        }
    }

    /// What comes next is a new interaction.
    pub fn reset(&mut self) {
        self.is_cancelled = false;
        self.robot.reset();
        self.choice = Choice::default();
        self.progress = Progress::default();
        self.object = None;
        self.refused = None;
    }

    /// One tick: what is to be sent.
    ///
    /// - `now`: the instant of the tick, on the clock of the messages' stamps.
    /// - `took`: how long the last tick took `[us]`, if that is known.
    pub fn tick(&mut self, now: Stamp, inputs: &Inputs, took: Option<f64>) -> Outputs {
        for tree in &inputs.transforms {
            self.frames.take(tree);
        }
        self.take_robot(now, inputs.robot.as_ref());
        self.take_object(now, inputs.object.as_ref());
        let chosen = self.choose(now, &inputs.bodies);
        if let Some(reason) = &inputs.refused {
            self.refuse(now, reason.clone());
        }
        let sighting = chosen.map(|(stamp, body)| Sighting {
            stamp,
            body,
            positions: &self.seen,
            confidences: &[],
        });
        if self.is_cancelled
            && let Some(pipeline) = self.robot.pipeline_mut()
        {
            // Also one that was made only after it was called off.
            pipeline.cancel();
        }
        self.refused.take_if(|(then, _)| (now - *then).seconds().abs() > Self::REFUSED_FOR);
        let tick = self.robot.tick(&TickInput { now, sighting, robot: None });
        let hands = Hands::of(&self.model, tick.as_ref());
        let object = self.object.filter(|(stamp, _)| (now - *stamp).seconds() <= Self::OBJECT_FOR);
        let reason = tick.as_ref().map_or(Some(HoldReason::NoRobot), |tick| tick.reason);
        let object = object.map(|(_, place)| place);
        let state = self.progress.update(reason, hands.as_ref(), object, &self.node);
        let report = Report {
            now,
            state,
            hands,
            body: self.choice.current(),
            refused: self.refused.as_ref().map(|(_, reason)| reason.as_str()),
            took,
        };
        report.outputs(&self.model, &self.node, tick.as_ref(), &mut self.throttle)
    }

    /// For so long it is told that something was not taken `[s]`.
    const REFUSED_FOR: f64 = 1.0;

    /// An object not heard of for this long `[s]` is where it is no more.
    const OBJECT_FOR: f64 = 0.5;

    fn take_robot(&mut self, now: Stamp, body: Option<&Body>) {
        let Some(body) = body else { return };
        if self.node.robot_state == RobotState::Demonstrated {
            return self.refuse(now, "robot_skeleton: node.robot_state is demonstrated".to_owned());
        }
        match self.frames.world_from(&body.frame) {
            Ok(world_from_body) => {
                let place = |name: &str| body.place(name).map(|place| world_from_body * place);
                if let Err(problem) = self.robot.report(place) {
                    self.refuse(now, format!("robot_skeleton: {problem}"));
                }
            }
            Err(unknown) => self.refuse(now, format!("robot_skeleton: {unknown}")),
        }
    }

    fn take_object(&mut self, now: Stamp, object: Option<&PoseStamped>) {
        let Some(object) = object else { return };
        match self.frames.world_from(&object.header.frame_id) {
            Ok(world_from_object) => {
                let stamp = or_now(object.header.stamp.stamp(), now);
                let place = world_from_object * Point::from(object.pose.position);
                self.object = Some((stamp, place)).filter(|(_, p)| crate::geometry::is_finite(p));
            }
            Err(unknown) => self.refuse(now, format!("object_pose: {unknown}")),
        }
    }

    /// Fills `seen` with the partner's joints, if the partner is among the bodies.
    fn choose(&mut self, now: Stamp, bodies: &[Body]) -> Option<(Stamp, Option<u32>)> {
        let library = self.model.library();
        let (skeleton, base) = (library.skeleton(Who::Partner), library.base(Who::Partner));
        let forget = self.model.settings().filter.forget;
        let (mut candidates, mut refused) = (Vec::with_capacity(bodies.len()), None);
        for body in bodies {
            match self.frames.world_from(&body.frame) {
                Ok(world_from_body) => candidates.push((body, world_from_body)),
                Err(unknown) => refused = Some(format!("skeleton: {unknown}")),
            }
        }
        let base = skeleton.name(base);
        let chosen =
            self.choice.choose(now, &candidates, base, self.robot.base(), &self.node, forget);
        let sighting = chosen.map(|(body, world_from_body)| {
            let mut known = 0;
            for (joint, seen) in skeleton.joints().zip(&mut self.seen) {
                let place = body.place(skeleton.name(joint)).map(|p| world_from_body * p);
                known += usize::from(place.is_some());
                *seen = place.unwrap_or_else(|| Point::from(Vector::repeat(f64::NAN)));
            }
            if known == 0 {
                let names: Vec<&str> = body.joints.iter().map(|(name, _)| name.as_str()).collect();
                let has = if names.is_empty() {
                    "no joint is tracked".to_owned()
                } else {
                    names.join(", ")
                };
                refused = Some(format!("skeleton: no joint of the model's; {has}"));
            }
            (or_now(body.stamp, now), body.id)
        });
        if let Some(reason) = refused {
            self.refuse(now, reason);
        }
        sighting
    }

    fn refuse(&mut self, now: Stamp, reason: String) {
        self.refused = Some((now, reason));
    }
}

/// Messages without a stamp are of now.
fn or_now(stamp: Stamp, now: Stamp) -> Stamp {
    if stamp == Stamp(0) { now } else { stamp }
}
