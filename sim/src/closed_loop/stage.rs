//! A scenario laid out: where everybody is at any instant, and what the sensor says of it.

use std::sync::Arc;

use handover_mesh::{JointId, Part, Point, Role, Skeleton, Span, Stamp, Vector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::{Feed, Message, TimeWarp};
use crate::check::Violations;
use crate::scenario::{Change, Interval, Scenario};
use crate::scene::{Pose, RecordError, Scene, SceneConfig};
use crate::sensor::Sensor;

/// The robot takes the giver's place, and the receiver is its partner.
pub(super) const ROBOT: Role = Role::First;
pub(super) const PARTNER: Role = Role::Second;

/// Stamps count from here, as clocks on robots do, not from 0: 2025-06-15.
pub(super) const EPOCH: Stamp = Stamp(1_750_000_000_000_000_000);

/// The sensor's number of the partner.
const PARTNERS_NUMBER: u32 = 1;
/// Its number of somebody else, where it tells them apart.
const ANOTHERS_NUMBER: u32 = 2;

/// Why a scenario cannot be laid out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StageError {
    /// A parameter is out of range.
    #[error(transparent)]
    Violations(#[from] Violations),
    /// The scene cannot be recorded.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// A scenario laid out. Seconds are counted from the trial's start, whatever happens in it.
#[derive(Debug, Clone)]
pub struct Stage {
    scene: Scene,
    warp: TimeWarp,
    skeleton: Arc<Skeleton>,
    rest: Vec<Point>,
    messages: Vec<Message>,
    end: f64,
    contact: Option<f64>,
    disturbed: Option<[f64; 2]>,
    is_silenced: bool,
}

impl Stage {
    /// Lays out a scenario: the same one, the same stage.
    ///
    /// # Errors
    /// [`StageError`]; a scenario that was read and checked gives none.
    pub fn new(scenario: &Scenario) -> Result<Self, StageError> {
        let scene = Scene::new(scenario.scene.clone())?;
        let moments = scene.moments();
        let [start, end] = moments.reach[PARTNER as usize];
        let planned = |reach: f64| start + reach * (end - start);
        let (warp, ends) = match scenario.events.partner {
            Change::None => (TimeWarp::none(), moments.end),
            Change::Hesitation { reach, pause } => {
                let warp = TimeWarp::hesitation(planned(reach), pause);
                let ends = warp.when(moments.end).unwrap_or(moments.end);
                (warp, ends)
            }
            Change::Withdrawal { reach } => {
                let there = planned(reach);
                // As long back as there, and as long at rest as others are after a handover.
                let ends = 2.0 * there - start + TimeWarp::BLEND + scenario.scene.timing.lead_out;
                (TimeWarp::withdrawal(there), ends)
            }
        };
        let comes = !matches!(scenario.events.partner, Change::Withdrawal { .. });
        let contact = warp.when(moments.contact).filter(|_| comes);
        let end = ends + scenario.after;
        let mut stage = Self {
            rest: robot_at_rest(&scenario.scene, scenario.robot.stature)?,
            skeleton: Skeleton::nite(),
            messages: Vec::new(),
            disturbed: None,
            is_silenced: false,
            end,
            contact,
            warp,
            scene,
        };
        let sensor = Sensor::new(scenario.sensor.clone())?;
        stage.messages = stage.observed(&sensor, scenario)?;
        stage.disturb(scenario, planned);
        Ok(stage)
    }

    /// What the sensor makes of the trial, nothing gone wrong but by its own noise.
    fn observed(&self, sensor: &Sensor, scenario: &Scenario) -> Result<Vec<Message>, StageError> {
        let mut random = ChaCha8Rng::seed_from_u64(scenario.seed);
        // The scene was drawn from stream 0.
        random.set_stream(1);
        let stamps = sensor.capture_stamps(self.end, &mut random);
        let take = self.scene.record_at(&scenario.name, &stamps, |t| self.warp.scene_time(t))?;
        let measured = sensor.observe(&take.truth, &mut random)?.measured;
        let latency = Span::from_seconds(scenario.latency).unwrap_or_default();
        let [others, partners] = [ROBOT, PARTNER].map(|role| &measured.person(role).motion);
        let frames = partners.frames().iter().zip(others.frames());
        let message = |(partner, other): (&handover_mesh::Frame, &handover_mesh::Frame)| Message {
            stamp: partner.stamp,
            received: partner.stamp + latency,
            body: PARTNERS_NUMBER,
            positions: partner.positions.to_vec(),
            bystander: other.positions.to_vec(),
        };
        Ok(frames.map(message).collect())
    }

    /// Lets go wrong at the sensor what the scenario says.
    fn disturb(&mut self, scenario: &Scenario, planned: impl Fn(f64) -> f64) {
        let events = &scenario.events;
        let played = |interval: &Interval| -> Option<[f64; 2]> {
            let start = self.warp.when(planned(interval.reach))?;
            Some([start, start + interval.seconds])
        };
        let [occlusion, silence] =
            [&events.occlusion, &events.silence].map(|event| event.as_ref().and_then(&played));
        let exchange = events.exchange.as_ref().and_then(|exchange| played(&exchange.during));
        let aside = events.exchange.map_or(0.0, |exchange| exchange.aside);
        let is_told_apart = events.exchange.is_some_and(|exchange| exchange.has_own_number);
        // Across the line between the people.
        let (sine, cosine) = scenario.scene.heading.sin_cos();
        let beside = Vector::new(-sine, cosine, 0.0) * aside;
        let hand = self.hand(PARTNER);
        let within = |interval: Option<[f64; 2]>, message: &Message| {
            let seconds = message.stamp.seconds();
            interval.is_some_and(|[start, end]| (start..end).contains(&seconds))
        };
        self.messages.retain(|message| !within(silence, message));
        for message in &mut self.messages {
            if within(exchange, message) {
                message.positions = message.bystander.iter().map(|p| p + beside).collect();
                if is_told_apart {
                    message.body = ANOTHERS_NUMBER;
                }
            }
            if within(occlusion, message) {
                message.positions[hand.index()] = Point::from(Vector::repeat(f64::NAN));
            }
        }
        let disturbed = [occlusion, exchange, silence].into_iter().flatten();
        self.disturbed = disturbed.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
        self.is_silenced = silence.is_some_and(|[_, end]| end > self.end);
    }

    /// The handover as planned.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The skeleton of everybody.
    pub fn skeleton(&self) -> &Arc<Skeleton> {
        &self.skeleton
    }

    /// The robot at rest: `[m]` in the world, in the skeleton's order.
    pub fn rest(&self) -> &[Point] {
        &self.rest
    }

    /// A new reader of the sensor's messages.
    pub fn feed(&self) -> Feed<'_> {
        Feed::new(&self.messages)
    }

    /// When the trial ends `[s]`.
    pub fn end(&self) -> f64 {
        self.end
    }

    /// When both people's hands have arrived, if they do `[s]`.
    pub fn contact(&self) -> Option<f64> {
        self.contact
    }

    /// When the human giver's hand sets out, if it does `[s]`.
    pub fn giver_sets_out(&self) -> Option<f64> {
        self.warp.when(self.scene.moments().reach[ROBOT as usize][0])
    }

    /// Between which instants something goes wrong at the sensor, if anything does `[s]`.
    pub fn disturbed(&self) -> Option<[f64; 2]> {
        self.disturbed
    }

    /// When the last message is received `[s]`, where they stop for good before the end.
    pub fn last_message(&self) -> Option<f64> {
        let last = self.messages.last().map_or(0.0, |message| message.received.seconds());
        self.is_silenced.then_some(last)
    }

    /// Where the partner truly is.
    pub fn partner(&self, seconds: f64) -> Pose {
        self.scene.pose(PARTNER, self.warp.scene_time(seconds))
    }

    /// What the human giver does, who keeps to the partner's time: what a robot is compared with.
    pub fn giver(&self, seconds: f64) -> Pose {
        self.scene.pose(ROBOT, self.warp.scene_time(seconds))
    }

    /// The active hand of a role.
    pub fn hand(&self, role: Role) -> JointId {
        let side = self.scene.config().person(role).hand;
        // The skeleton of fifteen joints has both hands.
        self.skeleton.part(Part::Hand(side)).unwrap_or_else(|| self.skeleton.root())
    }
}

/// A body of this stature at rest where the scene's giver stands at the start, its torso above
/// the same place of the floor.
fn robot_at_rest(config: &SceneConfig, stature: f64) -> Result<Vec<Point>, Violations> {
    let mut own = config.clone();
    own.giver.stature = stature;
    let [body, giver] =
        [Scene::new(own)?, Scene::new(config.clone())?].map(|scene| scene.pose(ROBOT, 0.0));
    let base = Skeleton::nite().root().index();
    let mut shift = giver.positions[base] - body.positions[base];
    shift.z = 0.0;
    Ok(body.positions.iter().map(|p| p + shift).collect())
}
