//! The tick itself: the whole online path on one screen.

use std::sync::Arc;

use super::{OnlineError, OnlineModel, Perception, Reference, Window};
use crate::filter::{Doubt, Filter, Sighting};
use crate::geometry::Point;
use crate::retarget::Residual;
use crate::safety::{HoldReason, PartnerBody, Proposal, SafetyGate, Target, is_place};
use crate::skeleton::{JointId, Part, Riders};
use crate::time::Stamp;
use crate::track::{Belief, Who};

/// What a tick is given.
#[derive(Debug, Clone, Copy)]
pub struct TickInput<'a> {
    /// The instant of the tick; sightings count as received at it.
    pub now: Stamp,
    /// What came in of the partner since the last tick, if anything: the newest.
    pub sighting: Option<Sighting<'a>>,
    /// The robot's joints `[m]` in the world, its skeleton's order, where it has said them: the
    /// first start the gate, later ones say where its base is.
    pub robot: Option<&'a [Point]>,
}

/// What a tick says; borrowed from the pipeline until the next one.
#[derive(Debug, Clone, Copy)]
pub struct Tick<'a> {
    /// Where the robot is to be; none before it has said where it is.
    pub target: Option<&'a Target>,
    /// Why it does not move as the demonstrations would have it; none: it does.
    pub reason: Option<HoldReason>,
    /// The partner, if known: all joints `[m]` at the instant of the tick.
    pub partner: Option<&'a [Point]>,
    /// What of the partner is seen, mended and missing, and why a sighting was not taken.
    pub filter: &'a Filter,
    /// Where in the demonstrations the interaction is.
    pub belief: &'a Belief,
    /// What was solved in this tick, if anything was.
    pub solved: Option<Solved<'a>>,
}

/// A solved window.
#[derive(Debug, Clone, Copy)]
pub struct Solved<'a> {
    /// The reference's robot now: `[m]`, one per joint.
    pub reference: &'a [Point],
    /// The robot's joints now and over the horizon, before the gate: `[m]`, `frames × joints`.
    pub poses: &'a [Point],
    /// What the solve left over.
    pub residual: Residual,
}

/// One robot and one partner, tick by tick. All room is made at the start: a tick allocates
/// nothing, reads no clock, and never fails; what goes wrong is a [`HoldReason`].
#[derive(Debug, Clone)]
pub struct Pipeline {
    model: Arc<OnlineModel>,
    filter: Filter,
    perception: Perception,
    reference: Reference,
    window: Window,
    gate: SafetyGate,
    holds_gap: bool,
    robot_base: Option<Point>,
    /// Where the partner's joints are now by the filter alone: room.
    places: Vec<Point>,
    /// How what rides on the partner's joints sits on them: as in the first demonstration. What a
    /// sighting says of it is not looked at: no filter judges that.
    riders: Riders,
    body: Option<PartnerBody>,
    /// When the partner was known last.
    known: Option<Stamp>,
    is_cancelled: bool,
}

impl Pipeline {
    /// Makes room for a robot.
    ///
    /// - `robot_lengths`: the robot's bones `[m]`, in its skeleton's bone order, > 0.
    /// - `edges`: whether the edges between the people and the gap at contact count, or the
    ///   demonstrations alone.
    ///
    /// # Errors
    /// [`OnlineError`] on bones or settings out of range.
    pub fn new(
        model: Arc<OnlineModel>,
        robot_lengths: &[f64],
        edges: bool,
    ) -> Result<Self, OnlineError> {
        let settings = &model.settings;
        let partner = model.library.skeleton(Who::Partner).clone();
        // Of what rides on the partner's joints it is enough to know how it sits.
        let (joints, own) = (partner.len(), Arc::new(partner.without_attached()));
        let filter = Filter::new(own, model.library.base(Who::Partner), settings.filter.clone());
        let robot = model.library.skeleton(Who::Robot).clone();
        let base = model.library.base(Who::Robot);
        let riders = model.library.riders(Who::Partner);
        let gate = SafetyGate::new(robot, base, robot_lengths, settings.safety.clone())?;
        Ok(Self {
            filter,
            perception: Perception::new(&model),
            reference: Reference::new(&model),
            window: Window::new(&model, robot_lengths, edges)?,
            gate,
            holds_gap: edges,
            robot_base: None,
            places: vec![Point::origin(); joints],
            riders,
            body: None,
            known: None,
            is_cancelled: false,
            model,
        })
    }

    /// What is learned.
    pub fn model(&self) -> &Arc<OnlineModel> {
        &self.model
    }

    /// Calls it off: the robot brakes and stands until [`Self::reset`].
    pub fn cancel(&mut self) {
        self.is_cancelled = true;
    }

    /// Forgets partner, robot and cancellation: what comes next is a new interaction, and the robot
    /// has to say again where it is. One that still moves brakes first, and says so afterwards.
    pub fn reset(&mut self) {
        self.filter.reset();
        self.perception.reset();
        self.window.reset();
        self.gate.reset();
        self.robot_base = None;
        self.body = None;
        self.known = None;
        self.is_cancelled = false;
    }

    /// Where the robot is to be, from all that is known at `input.now`.
    ///
    /// Total: whatever the data, it ends, in bounded time, and allocates nothing.
    ///
    /// # Panics
    /// If a sighting or the robot has not one place for each joint: the caller's bug.
    pub fn tick(&mut self, input: &TickInput<'_>) -> Tick<'_> {
        if let Some(robot) = input.robot {
            self.take_robot(robot, input.now);
        }
        let seen = self.look(input);
        let proposed = if self.is_cancelled {
            Err(HoldReason::Cancelled)
        } else {
            seen.and_then(|()| self.propose())
        };
        let proposal = match proposed {
            Ok(_) => Proposal::Move { poses: self.window.poses(), step: self.model.library.step() },
            Err(reason) => Proposal::Hold(reason),
        };
        let target = self.gate.admit(proposal, self.body.as_ref(), input.now);
        let (joints, past) =
            (self.model.library.skeleton(Who::Robot).len(), self.model.settings.past);
        let (reference, poses) = (&self.reference.robot, self.window.poses());
        Tick {
            target,
            reason: target.map_or(Some(HoldReason::NoRobot), Target::reason),
            filter: &self.filter,
            partner: seen.is_ok().then(|| self.perception.scene().now(&self.model)),
            belief: self.perception.belief(),
            solved: proposed.ok().map(|residual| Solved {
                reference: &reference[past * joints..][..joints],
                poses,
                residual,
            }),
        }
    }

    fn take_robot(&mut self, robot: &[Point], now: Stamp) {
        let base = robot[self.model.library.base(Who::Robot).index()];
        if is_place(&base) {
            self.robot_base = Some(base);
        }
        if !self.gate.is_started() {
            self.gate.start(robot, now);
        }
    }

    /// Takes in the partner and lays out where they are over the window, or says why nobody knows.
    fn look(&mut self, input: &TickInput<'_>) -> Result<(), HoldReason> {
        let Self { model, filter, perception, riders, places, .. } = self;
        let own = model.library.skeleton(Who::Partner).own();
        let sighting = input.sighting.map(|sighting| {
            assert_eq!(sighting.positions.len(), places.len(), "one place for each joint");
            own_joints(sighting, own)
        });
        let partner = filter.update(sighting.as_ref(), input.now);
        let known = self.known.get_or_insert(input.now);
        let partner = match partner {
            Ok(partner) => partner,
            Err(doubt)
                if doubt != Doubt::Nobody
                    && (input.now - *known).seconds() > model.settings.stop_after =>
            {
                return Err(HoldReason::Stopped);
            }
            Err(doubt) => return Err(reason(doubt)),
        };
        *known = input.now;
        let base = self.robot_base.ok_or(HoldReason::NoRobot)?;
        if partner.is_new() {
            perception.reset();
            self.window.reset();
        }
        if partner.is_fresh() {
            let guess = model.settings.guess;
            let guessed = |joint| partner.unseen(joint).map_or(1.0, |time| (time / guess).min(1.0));
            places[..own].copy_from_slice(partner.positions());
            riders.place(places);
            perception.see(model, partner.stamp(), places, base, guessed);
        }
        perception.look(model, input.now, base, |stamp, places| {
            partner.at(stamp, &mut places[..own]);
        });
        // What is kept away from is what was seen, whatever the demonstrations make of it.
        partner.at(input.now, &mut places[..own]);
        self.body = Some(body(model, places));
        Ok(())
    }

    /// Fills the window's poses, or says why there are none.
    fn propose(&mut self) -> Result<Residual, HoldReason> {
        let Self { model, perception, reference, window, .. } = self;
        if perception.belief().followed.is_empty() {
            return Err(HoldReason::NoPartner);
        }
        if !perception.belief().is_familiar {
            return Err(HoldReason::OffDemonstration);
        }
        let (belief, scene) = (perception.belief(), perception.scene());
        reference.fill(model, belief, scene, self.holds_gap);
        window.solve(model, belief, scene, reference).map_err(|_| HoldReason::Unsolved)
    }
}

/// Of a sighting what the filter asks for: the person's own joints.
fn own_joints(sighting: Sighting<'_>, own: usize) -> Sighting<'_> {
    let Sighting { positions, confidences, .. } = sighting;
    let confidences = &confidences[..confidences.len().min(own)];
    Sighting { positions: &positions[..own], confidences, ..sighting }
}

/// What the robot keeps away from, where the partner is now.
fn body(model: &OnlineModel, places: &[Point]) -> PartnerBody {
    let skeleton = model.library.skeleton(Who::Partner);
    let place = |joint: Option<JointId>| joint.map(|joint| places[joint.index()]);
    PartnerBody {
        head: place(skeleton.part(Part::Head)),
        neck: place(skeleton.part(Part::Neck)),
        torso: place(Some(model.library.base(Who::Partner))),
    }
}

/// Why there is nobody to hand over to.
fn reason(doubt: Doubt) -> HoldReason {
    match doubt {
        Doubt::Nobody => HoldReason::NoPartner,
        Doubt::Stale(_) => HoldReason::Stale,
        Doubt::Lost => HoldReason::Lost,
        Doubt::Jump => HoldReason::Jump,
        Doubt::Exchanged => HoldReason::Exchanged,
        Doubt::OutOfOrder | Doubt::FarFromNow(_) => HoldReason::Clock,
    }
}
