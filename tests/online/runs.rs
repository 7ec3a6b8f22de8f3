//! A person in front of a robot, tick by tick.

use std::sync::{Arc, OnceLock};

use handover_mesh::filter::Sighting;
use handover_mesh::online::{OnlineModel, OnlineSettings, Pipeline, TickInput};
use handover_mesh::retarget::Transform;
use handover_mesh::safety::HoldReason;
use handover_mesh::{Point, Skeleton, Stamp};

use crate::handovers::{DURATION, FRAME, Handover, demonstrations, model, pipeline};

/// The right hand's place in the skeleton's order.
pub(crate) const HAND: usize = 8;

/// A seed that nothing was learned from.
pub(crate) const HELD_OUT: u64 = 100;

/// What most tests follow: six handovers, with no transform.
pub(crate) fn usual() -> Arc<OnlineModel> {
    static MODEL: OnceLock<Arc<OnlineModel>> = OnceLock::new();
    let made = || model(demonstrations(6), Transform::None, OnlineSettings::default());
    MODEL.get_or_init(made).clone()
}

/// What a tick said.
#[derive(Debug, Clone)]
pub(crate) struct Said {
    /// Of the tick `[s]`.
    pub(crate) now: f64,
    /// The target's joints `[m]`.
    pub(crate) places: Vec<Point>,
    pub(crate) reason: Option<HoldReason>,
    /// When the hands meet `[s]`, from now on.
    pub(crate) contact_in: f64,
    pub(crate) tempo: f64,
    /// How far the partner is from the demonstrations `[m]`.
    pub(crate) distance: f64,
    pub(crate) is_familiar: bool,
}

/// Puts a partner to a pipeline: sightings at 30 Hz, ticks at a rate.
///
/// - `partner`: joints at a time `[s]`; none: not seen.
/// - `robot`: where the robot stands at the start `[m]`.
/// - `rate`: ticks a second.
pub(crate) fn run(
    pipeline: &mut Pipeline,
    partner: impl Fn(f64) -> Option<Vec<Point>>,
    robot: &[Point],
    rate: f64,
    duration: f64,
) -> Vec<Said> {
    let step = pipeline.model().library().step().seconds();
    let (mut said, mut last) = (Vec::new(), -1);
    for tick in 0..=(duration * rate) as i64 {
        let now = (tick as f64 / rate * 1e9).round() as i64;
        let frame = now / FRAME;
        let seen = if frame > last { partner((frame * FRAME) as f64 / 1e9) } else { None };
        last = frame;
        let sighting = seen.as_ref().map(|positions| Sighting {
            stamp: Stamp(frame * FRAME),
            body: None,
            positions,
            confidences: &[],
        });
        let tick = pipeline.tick(&TickInput { now: Stamp(now), sighting, robot: Some(robot) });
        said.push(Said {
            now: now as f64 / 1e9,
            places: tick.target.unwrap().positions().to_vec(),
            reason: tick.reason,
            contact_in: tick.belief.contact * step,
            tempo: tick.belief.tempo,
            distance: tick.belief.distance,
            is_familiar: tick.belief.is_familiar,
        });
    }
    said
}

/// Puts a handover's receiver to a robot that stands where its giver did, at 30 Hz.
///
/// - `time`: from the time of the test to the time of the handover `[s]`.
pub(crate) fn follow(handover: &Handover, time: impl Fn(f64) -> f64, duration: f64) -> Vec<Said> {
    let robot = handover.giver(0.0);
    let mut pipeline = pipeline(&usual(), &robot);
    run(&mut pipeline, |now| Some(handover.receiver(time(now))), &robot, 30.0, duration)
}

/// How far the robot's hand is from the giver's at a time of the handover `[m]`.
pub(crate) fn off(said: &Said, handover: &Handover, time: f64) -> f64 {
    (said.places[HAND] - handover.giver(time)[HAND]).norm()
}

/// The whole of a handover.
pub(crate) fn whole(handover: &Handover) -> Vec<Said> {
    follow(handover, |now| now, DURATION)
}

/// The greatest distance of two poses' joints `[m]`.
pub(crate) fn farthest(a: &[Point], b: &[Point]) -> f64 {
    assert_eq!((a.len(), b.len()), (Skeleton::nite().len(), Skeleton::nite().len()));
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}
