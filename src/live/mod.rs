//! The live robot, whatever brings its messages: bodies as trackers say them → the tick → messages.
//!
//! One way: [`Inputs`] → into the world (`frames`) → which body is the partner (`choice`) →
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

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::bodies::Body;
use crate::config::{NodeSettings, RobotState};
use crate::filter::Sighting;
use crate::frames::FrameTree;
use crate::geometry::{Point, Vector, is_finite};
use crate::messages::PoseStamped;
use crate::online::{OnlineError, OnlineModel, TickInput};
use crate::safety::HoldReason;
use crate::time::Stamp;
use crate::track::Who;
use choice::Choice;
use frames::Frames;
pub use frames::UnknownFrame;
pub use outputs::{News, Outputs};
use outputs::{Report, Throttle};
use rest::Rest;
use robot::Robot;
pub use state::HandoverState;
use state::{HandTarget, Hands, Progress};

/// What came in since the last tick, of each kind the newest, in the order in which it came; and how
/// frames lie to each other, as far as anybody ever said.
#[derive(Debug, Clone, Default)]
pub struct Inputs {
    /// Whoever is seen: the partner is chosen among them.
    pub bodies: Vec<Body>,
    /// Where the robot's joints are.
    pub robot: Option<Body>,
    /// Where the object is.
    pub object: Option<PoseStamped>,
    /// The tree of frames: it outlives any robot that ticks.
    pub frames: FrameTree,
    /// A topic on which something came in that could not be read, and why.
    pub refused: Option<(&'static str, String)>,
}

/// A robot and whoever it meets.
#[derive(Debug, Clone)]
pub struct Live {
    model: Arc<OnlineModel>,
    node: NodeSettings,
    frames: Frames,
    choice: Choice,
    robot: Robot,
    rest: Rest,
    progress: Progress,
    /// The newest object's place `[m]` in the world, and when it was heard of.
    object: Option<(Stamp, Point)>,
    /// The sighting's joints `[m]`: room.
    seen: Vec<Point>,
    throttle: Throttle,
    /// By topic, why something that came in was not taken, and when.
    refused: BTreeMap<&'static str, (Stamp, String)>,
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
            RobotState::Demonstrated => Robot::told(&model, node.edges, &rest.bone_lengths)?,
        };
        Ok(Self {
            frames: Frames::new(&node),
            choice: Choice::default(),
            robot,
            rest,
            progress: Progress::default(),
            object: None,
            seen: vec![Point::from(Vector::repeat(f64::NAN)); joints],
            throttle: Throttle::default(),
            refused: BTreeMap::new(),
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
        self.refused.clear();
    }

    /// Where the robot will stand if nothing more is said, and from when on; none before it was told
    /// anything.
    pub fn standstill(&self) -> Option<(Vec<Point>, Stamp)> {
        self.robot.standstill()
    }

    /// A robot that only does as it is told, begins where it stands, not as demonstrated.
    ///
    /// - `pose`: the joints `[m]` in the world, as [`Self::standstill`] has them; of another number
    ///   of joints it is not taken.
    pub fn begin_at(&mut self, pose: &[Point]) {
        self.robot.place(pose);
    }

    /// One tick: what is to be sent.
    ///
    /// - `now`: the instant of the tick, on the clock of the messages' stamps.
    /// - `took`: how long the last tick took `[us]`, if that is known.
    pub fn tick(&mut self, now: Stamp, inputs: &Inputs, took: Option<f64>) -> Outputs {
        self.place_robot(now, inputs);
        self.take_object(now, inputs);
        let chosen = self.choose(now, inputs);
        if let Some((topic, reason)) = &inputs.refused {
            self.refuse(now, topic, reason.clone());
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
        self.refused.retain(|_, (then, _)| (now - *then).seconds().abs() <= Self::REFUSED_FOR);
        let refused = self.refused.iter().map(|(topic, (_, reason))| format!("{topic}: {reason}"));
        let refused: Vec<String> = refused.collect();
        let robot_age = self.robot.age(now);
        let tick = self.robot.tick(&TickInput { now, sighting, robot: None });
        if tick.as_ref().is_some_and(|tick| tick.filter.partner().is_ok_and(|p| p.is_fresh())) {
            self.choice.confirm(now);
        }
        let hands = Hands::of(&self.model, tick.as_ref());
        let hand = HandTarget::of(&self.model, tick.as_ref());
        let is_there = |heard: Stamp| (now - heard).seconds().abs() <= Self::OBJECT_FOR;
        let object = self.object.filter(|(heard, _)| is_there(*heard));
        let reason = tick.as_ref().map_or(Some(HoldReason::NoRobot), |tick| tick.reason);
        let object = object.map(|(_, place)| place);
        let state = self.progress.update(reason, hands.as_ref(), object, &self.node);
        let report = Report {
            now,
            state,
            hands,
            hand,
            body: self.choice.current(),
            robot_age,
            refused: refused.join("; "),
            took,
        };
        report.outputs(&self.model, &self.node, tick.as_ref(), &mut self.throttle)
    }

    /// For so long it is told that something was not taken `[s]`.
    const REFUSED_FOR: f64 = 1.0;

    /// An object not heard of for this long `[s]` is where it is no more.
    const OBJECT_FOR: f64 = 0.5;

    /// Takes in what the robot says; one that says nothing is put where it begins.
    fn place_robot(&mut self, now: Stamp, inputs: &Inputs) {
        if self.node.robot_state == RobotState::Demonstrated {
            if !self.robot.is_placed() {
                let base = self.frames.world_from(&self.node.base_frame, &inputs.frames, [now; 2]);
                match base {
                    Ok(world_from_frame) => {
                        let base = world_from_frame * self.node.world_from_base;
                        self.robot.place(&self.rest.placed(&base));
                    }
                    Err(unknown) => self.refuse(now, "node.base_frame", unknown.to_string()),
                }
            }
            if inputs.robot.is_some() {
                let reason = "node.robot_state is demonstrated";
                self.refuse(now, "robot_skeleton", reason.to_owned());
            }
            return;
        }
        let Some(body) = &inputs.robot else { return };
        if let Some(reason) = self.untimely(now, body.stamp) {
            return self.refuse(now, "robot_skeleton", reason);
        }
        let when = [or_now(body.stamp, now), now];
        match self.frames.world_from(&body.frame, &inputs.frames, when) {
            Ok(world_from_body) => {
                let place = |name: &str| body.place(name).map(|place| world_from_body * place);
                if let Err(problem) = self.robot.report(now, place) {
                    self.refuse(now, "robot_skeleton", problem.to_string());
                }
            }
            Err(unknown) => self.refuse(now, "robot_skeleton", unknown.to_string()),
        }
    }

    fn take_object(&mut self, now: Stamp, inputs: &Inputs) {
        let Some(object) = &inputs.object else { return };
        if let Some(reason) = self.untimely(now, object.header.stamp.stamp()) {
            return self.refuse(now, "object_pose", reason);
        }
        let when = [or_now(object.header.stamp.stamp(), now), now];
        match self.frames.world_from(&object.header.frame_id, &inputs.frames, when) {
            Ok(world_from_object) => {
                let place = world_from_object * Point::from(object.pose.position);
                if is_finite(&place) {
                    self.object = Some((now, place));
                } else {
                    self.refuse(now, "object_pose", "its place is no number".to_owned());
                }
            }
            Err(unknown) => self.refuse(now, "object_pose", unknown.to_string()),
        }
    }

    /// Why a message of that stamp is not one of now, if it is not.
    fn untimely(&self, now: Stamp, stamp: Stamp) -> Option<String> {
        let tolerance = self.model.settings().filter.clock_tolerance;
        let age = (now - or_now(stamp, now)).seconds();
        (age.abs() > tolerance).then(|| {
            let (age, word) = (age.abs(), if age < 0.0 { "ahead" } else { "old" });
            format!(
                "its stamp is {age:.3} s {word}, not within filter.clock_tolerance, {tolerance} (hint: \
                 use_sim_time, or the machines' clocks)"
            )
        })
    }

    /// Fills `seen` with the partner's joints, if the partner is among the bodies.
    fn choose(&mut self, now: Stamp, inputs: &Inputs) -> Option<(Stamp, Option<u32>)> {
        let library = self.model.library();
        let (skeleton, base) = (library.skeleton(Who::Partner), library.base(Who::Partner));
        let forget = self.model.settings().filter.forget;
        let (mut candidates, mut refused) = (Vec::with_capacity(inputs.bodies.len()), None);
        for body in &inputs.bodies {
            let when = [or_now(body.stamp, now), now];
            match self.frames.world_from(&body.frame, &inputs.frames, when) {
                _ if self.untimely(now, body.stamp).is_some() => {
                    refused = self.untimely(now, body.stamp);
                }
                Ok(world_from_body) => candidates.push((body, world_from_body)),
                Err(unknown) => refused = Some(unknown.to_string()),
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
                refused = Some(format!("no joint of the model's; {has}"));
            }
            (or_now(body.stamp, now), body.id)
        });
        if let Some(reason) = refused {
            self.refuse(now, "skeleton", reason);
        }
        sighting
    }

    /// Words of strangers are kept short, and fit for a log.
    fn refuse(&mut self, now: Stamp, topic: &'static str, reason: String) {
        /// As long as our own words may become.
        const LONGEST: usize = 400;
        let fit = |c: char| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c };
        let reason = reason.chars().take(LONGEST).map(fit).collect();
        self.refused.insert(topic, (now, reason));
    }
}

/// Messages without a stamp are of now.
fn or_now(stamp: Stamp, now: Stamp) -> Stamp {
    if stamp == Stamp(0) { now } else { stamp }
}
