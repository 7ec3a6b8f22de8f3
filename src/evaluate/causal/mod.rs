//! Methods that know the past alone: what a robot could really do at each frame.
//!
//! All of them follow the demonstrations by the same tracker, so that they differ in what is their
//! own.

mod promp;

use std::sync::Arc;

use crate::demonstration::Observation;
use crate::geometry::{Point, Vector, yaw_isometry};
use crate::kinematics::minimum_jerk;
use crate::online::{OnlineError, OnlineModel, Perception, Pipeline, Replay, mean_pose};
use crate::predict::{Method, Predictor, lead_hand};
use crate::skeleton::Part;
use crate::track::{Followed, Who};
use promp::Promp;

/// The robot's joints by one method, frame by frame: `[m]`, `frames × joints`.
pub(super) fn predict(
    predictor: &Predictor,
    model: &Arc<OnlineModel>,
    method: Method,
    observation: &Observation,
) -> Result<Vec<Point>, OnlineError> {
    if let Some(predicted) = predictor.predict_causally(method, observation) {
        return Ok(predicted);
    }
    if matches!(method, Method::None | Method::Mesh) {
        return ticks(model, method == Method::Mesh, observation);
    }
    let mut perception = Perception::new(model);
    let mut promp = Promp::new(model);
    let joints = observation.robot_skeleton.len();
    let mut predicted = vec![Point::origin(); observation.len() * joints];
    let frames = observation.partner.frames().iter().zip(&observation.base);
    for ((frame, base), pose) in frames.zip(predicted.chunks_exact_mut(joints)) {
        perception.see(model, frame.stamp, &frame.positions, *base, |_| 0.0);
        let followed = &perception.belief().followed;
        let library = model.library();
        match method {
            Method::Knn => mean_pose(library, followed, Who::Robot, 0.0, *base, pose),
            Method::Replay => {
                let alone = Followed { weight: 1.0, ..followed[0] };
                mean_pose(library, &[alone], Who::Robot, 0.0, *base, pose);
            }
            Method::Attach => {
                let alone = Followed { weight: 1.0, ..followed[0] };
                mean_pose(library, &[alone], Who::Robot, 0.0, *base, pose);
                attach(model, &perception, observation, &frame.positions, pose);
            }
            _ => promp.predict(model, &perception, &frame.positions, *base, pose),
        }
    }
    Ok(predicted)
}

/// The targets of the real tick at each frame.
fn ticks(
    model: &Arc<OnlineModel>,
    edges: bool,
    observation: &Observation,
) -> Result<Vec<Point>, OnlineError> {
    let mut pipeline = Pipeline::new(model.clone(), &observation.bone_lengths, edges)?;
    let mut replay = Replay::new(observation, model.settings().tick_rate);
    let mut predicted = Vec::with_capacity(observation.len() * observation.robot_skeleton.len());
    while let Some((frame, input)) = replay.next_tick() {
        let tick = pipeline.tick(&input);
        if frame.is_some() {
            // A robot that has said where it is always has a target.
            predicted.extend_from_slice(tick.target.map_or(&[], |target| target.positions()));
        }
    }
    Ok(predicted)
}

/// Leads the hand of a replayed pose to the partner's hand plus the mean gap, near contact.
fn attach(
    model: &OnlineModel,
    perception: &Perception,
    observation: &Observation,
    partner: &[Point],
    pose: &mut [Point],
) {
    let belief = perception.belief();
    let nearest = belief.followed[0];
    let contact = model.library().exemplars()[nearest.exemplar].contact - nearest.frame;
    let seconds = contact * model.library().step().seconds();
    let share = minimum_jerk(1.0 - seconds.abs() / model.predict_settings().attach_fade);
    let (skeleton, partner_skeleton) =
        (&observation.robot_skeleton, observation.partner.skeleton());
    let Some(partner_hand) = partner_skeleton.part(Part::Hand(belief.hands.partner)) else {
        return;
    };
    let world_from_heading = yaw_isometry(partner_skeleton.heading(partner), Vector::zeros());
    let goal = partner[partner_hand.index()] + world_from_heading * model.gap(belief.hands);
    lead_hand(skeleton, &observation.bone_lengths, belief.hands.robot, pose, goal, share);
}
