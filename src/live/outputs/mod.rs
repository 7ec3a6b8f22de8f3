//! What a tick says → messages.

mod diagnostics;
mod markers;

use super::HandoverState;
use super::state::{HandTarget, Hands};
use crate::config::NodeSettings;
use crate::geometry::{Point, Vector, direction_or};
use crate::messages::{
    Diagnostic, DiagnosticArray, Duration, Header, MarkerArray, MultiDofPoint, MultiDofTrajectory,
    Pose, PoseStamped, Quaternion, Text, Time, Transform, Twist,
};
use crate::online::{OnlineModel, Tick};
use crate::safety::{HoldReason, Target};
use crate::time::{Span, Stamp};
use crate::track::Who;

/// What is to be sent after a tick; what is none is not.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    /// Where the robot's joints are to be from now on: ends in a standstill.
    pub joint_targets: Option<MultiDofTrajectory>,
    /// Where the active hand is to be now; x along the forearm.
    pub hand_target: Option<PoseStamped>,
    /// People, edges, targets.
    pub markers: Option<MarkerArray>,
    /// Where the handover is: a [`HandoverState`]'s name.
    pub state: Text,
    /// How the tick is doing.
    pub diagnostics: Option<DiagnosticArray>,
    /// Why the robot does not move as demonstrated; none: it does.
    pub reason: Option<HoldReason>,
    /// What there is to be told to whoever reads a log, if that has changed.
    pub news: Option<News>,
}

/// Something for whoever reads a log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct News {
    /// Whether it should be otherwise.
    pub is_warning: bool,
    /// In words.
    pub text: String,
}

/// When what is not sent at every tick was sent last.
#[derive(Debug, Clone, Default)]
pub(super) struct Throttle {
    markers: Option<Stamp>,
    diagnostics: Option<(Stamp, Option<HoldReason>)>,
    news: Option<News>,
}

/// What there is to say of a tick besides the tick.
pub(super) struct Report {
    pub(super) now: Stamp,
    pub(super) state: HandoverState,
    pub(super) hands: Option<Hands>,
    pub(super) hand: Option<HandTarget>,
    /// The number of the body that is the partner.
    pub(super) body: Option<Option<u32>>,
    /// How long ago the robot said where it is `[s]`.
    pub(super) robot_age: Option<f64>,
    /// What was not taken of late, and why; empty if all was.
    pub(super) refused: String,
    /// How long the last tick took `[us]`.
    pub(super) took: Option<f64>,
}

impl Report {
    pub(super) fn outputs(
        &self,
        model: &OnlineModel,
        node: &NodeSettings,
        tick: Option<&Tick<'_>>,
        throttle: &mut Throttle,
    ) -> Outputs {
        let header = Header { stamp: Time::of(self.now), frame_id: node.world_frame.clone() };
        let target = tick.and_then(|tick| tick.target);
        let reason = tick.map_or(Some(HoldReason::NoRobot), |tick| tick.reason);
        let is_due = |last: Option<Stamp>, rate: f64| {
            // Ticks come when they come: half a millisecond early is not late.
            last.is_none_or(|last| {
                let passed = (self.now - last).seconds();
                passed < 0.0 || passed + 5e-4 >= 1.0 / rate
            })
        };
        let shows = node.markers_rate > 0.0 && is_due(throttle.markers, node.markers_rate);
        if shows {
            throttle.markers = Some(self.now);
        }
        let (told, before) = throttle.diagnostics.unzip();
        let tells = is_due(told, node.diagnostics_rate) || before != Some(reason);
        if tells {
            throttle.diagnostics = Some((self.now, reason));
        }
        let (level, text) = self.words(reason);
        let news = News { is_warning: level != Diagnostic::OK, text };
        let news = Some(news).filter(|news| throttle.news.as_ref() != Some(news));
        if news.is_some() {
            throttle.news.clone_from(&news);
        }
        Outputs {
            joint_targets: target.map(|target| trajectory(model, target, header.clone())),
            hand_target: self.hand.map(|hand| hand_target(&hand, header.clone())),
            markers: shows.then(|| markers::markers(model, tick, self.hand.as_ref(), &header)),
            state: Text { data: self.state.name().to_owned() },
            diagnostics: tells.then(|| self.diagnostics(model, tick, reason)),
            reason,
            news,
        }
    }
}

/// The certified way from now on: a point at each step of the model's grid until the robot stands,
/// the standstill last.
fn trajectory(model: &OnlineModel, target: &Target, header: Header) -> MultiDofTrajectory {
    /// More points than this say no more.
    const MOST: i64 = 64;
    let skeleton = model.library().skeleton(Who::Robot);
    // What rides on a joint goes with it, and is nothing that a robot moves.
    let own = skeleton.own();
    let stands_in = target.stands_in();
    let step = model.library().step().0.max(stands_in.0 / MOST).max(1);
    let point = |ahead: Span, joints: &[Point], velocities: &[Vector]| {
        let place =
            |place: &Point| Transform { translation: (*place).into(), ..Transform::default() };
        let twist = |velocity: &Vector| Twist { linear: (*velocity).into(), ..Twist::default() };
        MultiDofPoint {
            transforms: joints[..own].iter().map(place).collect(),
            velocities: velocities[..own].iter().map(twist).collect(),
            accelerations: Vec::new(),
            time_from_start: Duration::of(ahead),
        }
    };
    let mut points = vec![point(Span(0), target.positions(), target.velocities())];
    if stands_in.0 > 0 {
        let (mut joints, mut velocities) =
            (target.positions().to_vec(), target.velocities().to_vec());
        let between = (1..).map(|k| Span(k * step)).take_while(|ahead| *ahead < stands_in);
        points.extend(between.chain([stands_in]).map(|ahead| {
            target.positions_at(ahead, &mut joints);
            target.velocities_at(ahead, &mut velocities);
            point(ahead, &joints, &velocities)
        }));
    }
    MultiDofTrajectory { header, joint_names: skeleton.names()[..own].to_vec(), points }
}

/// The hand, x along the forearm, z as far up as that leaves.
fn hand_target(hand: &HandTarget, header: Header) -> PoseStamped {
    let ahead = direction_or(hand.forearm.unwrap_or_else(Vector::x), Vector::x());
    // A forearm that points straight up has its own z backwards.
    let up = if ahead.z.abs() > 0.999 { -Vector::x() } else { Vector::z() };
    let left = direction_or(up.cross(&ahead), Vector::y());
    let axes = nalgebra::Matrix3::from_columns(&[ahead, left, ahead.cross(&left)]);
    let turn = nalgebra::Rotation3::from_matrix_unchecked(axes);
    let q = nalgebra::UnitQuaternion::from_rotation_matrix(&turn).coords;
    let orientation = Quaternion { x: q.x, y: q.y, z: q.z, w: q.w };
    PoseStamped { header, pose: Pose { position: hand.place.into(), orientation } }
}
