//! The loop itself.

use std::collections::BTreeMap;

use handover_mesh::filter::Sighting;
use handover_mesh::safety::HoldReason;
use handover_mesh::{Point, Span};

use super::stage::EPOCH;
use super::{Controller, Plant, Stage};
use crate::scenario::Scenario;

/// One tick and what came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// When `[s]`, from the trial's start.
    pub seconds: f64,
    /// Where the joints are to be: `[m]` in the world.
    pub target: Option<Vec<Point>>,
    /// Where the robot is at the tick, before it follows this target.
    pub robot: Vec<Point>,
    /// Why it is not moving as demonstrated.
    pub reason: Option<HoldReason>,
}

/// All ticks of a trial, at an even beat; at least one.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// The ticks.
    pub steps: Vec<Step>,
    /// Between two ticks `[s]`.
    pub period: f64,
}

/// Plays a trial to its end.
///
/// Each tick is given the newest message that has arrived and where the robot is; until the next
/// one the robot follows the target of this one.
pub fn play(scenario: &Scenario, stage: &Stage, controller: &mut impl Controller) -> Trace {
    let period = 1.0 / f64::from(scenario.tick_rate);
    let ticks = (stage.end() / period).floor() as u32;
    let (lag, speed) = (scenario.robot.lag, scenario.robot.speed);
    let mut plant = Plant::new(stage.skeleton().clone(), stage.rest().to_vec(), lag, speed);
    let mut feed = stage.feed();
    let step = |tick: u32| {
        let seconds = f64::from(tick) * period;
        let elapsed = Span::from_seconds(seconds).unwrap_or_default();
        let message = feed.receive(handover_mesh::Stamp(0) + elapsed);
        let sighting = message.map(|message| Sighting {
            stamp: EPOCH + Span(message.stamp.0),
            body: Some(message.body),
            positions: &message.positions,
            confidences: &[],
        });
        let robot = plant.joints().to_vec();
        let reply = controller.tick(EPOCH + elapsed, sighting, &robot);
        let target = reply.target.map(<[Point]>::to_vec);
        let reason = reply.reason;
        plant.follow(target.as_deref(), period);
        Step { seconds, target, robot, reason }
    };
    Trace { steps: (0..=ticks).map(step).collect(), period }
}

impl Trace {
    /// In how many ticks there was each reason to hold.
    pub fn holds(&self) -> BTreeMap<HoldReason, usize> {
        let mut holds = BTreeMap::new();
        for reason in self.steps.iter().filter_map(|step| step.reason) {
            *holds.entry(reason).or_default() += 1;
        }
        holds
    }
}
