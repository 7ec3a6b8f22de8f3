//! The gate itself: proposals in, targets out.

use std::sync::Arc;

use super::aim::{Poses, follow, towards};
use super::brake::Shape;
use super::certify::{Certifier, Rules};
use super::chain::Chain;
use super::jet::quintic;
use super::partner::{PartnerBody, is_place};
use super::plan::Plan;
use super::settings::{SafetyError, SafetySettings};
use super::{HoldReason, Target};
use crate::geometry::{Point, Vector};
use crate::skeleton::{JointId, Skeleton};
use crate::time::{Span, Stamp};

/// What the robot might do.
#[derive(Debug, Clone, Copy)]
pub enum Proposal<'a> {
    /// Follow these poses.
    Move {
        /// Where the joints belong now, after one step, after two, …: `[m]` in the world, poses ×
        /// joints, each pose in skeleton order. Bones need not have their lengths: directions and
        /// the base count.
        poses: &'a [Point],
        /// From one pose to the next, above 0.
        step: Span,
    },
    /// Brake, and stand.
    Hold(HoldReason),
}

/// Limits at the start of a gentle resumption, as a share of the full ones.
const GENTLE: f64 = 0.3;

/// Stamps of two ticks farther apart than this say that the clock was set: 60 s.
const LONGEST_STEP: Span = Span(60_000_000_000);

/// Lets only such motion through as breaks no limit.
///
/// ```
/// use handover_mesh::safety::{HoldReason, Proposal, SafetyGate, SafetySettings};
/// use handover_mesh::{Point, Skeleton, Span, Stamp};
/// let skeleton = Skeleton::nite();
/// let settings = SafetySettings::default();
/// let base = skeleton.root();
/// let mut gate = SafetyGate::new(skeleton, base, &[0.3; 14], settings).unwrap();
/// // Nothing is published before the robot has said where it is.
/// let hold = Proposal::Hold(HoldReason::NoPartner);
/// assert!(gate.admit(hold, None, Stamp(0)).is_none());
///
/// let pose: Vec<Point> = (0..15).map(|i| Point::new(0.1 * f64::from(i), 0.0, 1.0)).collect();
/// assert!(gate.start(&pose, Stamp(0)));
/// let target = gate.admit(hold, None, Stamp(33_000_000)).unwrap();
/// assert_eq!(target.reason(), Some(HoldReason::NoPartner));
/// assert!(!target.is_moving());
/// ```
#[derive(Debug, Clone)]
pub struct SafetyGate {
    settings: SafetySettings,
    chain: Arc<Chain>,
    certifier: Certifier,
    /// What the robot follows, and what was said last.
    target: Target,
    started: bool,
    /// Was reset while it moved: it stops, and then waits for a start.
    leaving: bool,
    /// When a tick was last taken.
    ticked: Option<Stamp>,
    /// What passed between the last two ticks whose stamps can be trusted, at most `lead`.
    period: Span,
    /// The clock was set while it moved: it stops, and then goes on.
    clock_set: bool,
    /// The partner that the plan was certified against.
    partner: PartnerBody,
    /// Since when limits rise again; none: they will at the next move.
    resumed: Option<Stamp>,
    trial: Plan,
    /// Value and two derivatives of each coordinate now, and where to.
    state: Vec<[Vector; 3]>,
    aims: Vec<[Vector; 3]>,
    scratch: [Vec<Vector>; 3],
    ways: Vec<f64>,
}

impl SafetyGate {
    /// A gate for a robot of this skeleton; all it ever needs is allocated here.
    ///
    /// - `base`: the joint whose place counts; of all others their bones' directions do.
    /// - `bone_lengths`: `[m]`, in the skeleton's bone order, above 0.
    ///
    /// # Errors
    /// [`SafetyError`] on a setting out of range or bones without length.
    pub fn new(
        skeleton: Arc<Skeleton>,
        base: JointId,
        bone_lengths: &[f64],
        settings: SafetySettings,
    ) -> Result<Self, SafetyError> {
        settings.check()?;
        let shape = Shape::new(&settings)?;
        let chain = Arc::new(Chain::new(&skeleton, base, bone_lengths)?);
        let joints = chain.joints();
        let plan = Plan::new(shape, joints);
        let rest = [Vector::z(), Vector::zeros(), Vector::zeros()];
        let target = Target {
            chain: chain.clone(),
            plan: plan.clone(),
            elapsed: Span(0),
            keeps_separation: true,
            stamp: Stamp(0),
            positions: vec![Point::origin(); joints],
            velocities: vec![Vector::zeros(); joints],
            reason: None,
        };
        Ok(Self {
            certifier: Certifier::new(&chain, settings.clone()),
            settings,
            chain,
            target,
            started: false,
            leaving: false,
            ticked: None,
            period: Span(0),
            clock_set: false,
            partner: PartnerBody::default(),
            resumed: None,
            trial: plan,
            state: vec![rest; joints],
            aims: vec![rest; joints],
            scratch: [(); 3].map(|()| vec![Vector::z(); joints]),
            ways: vec![0.0; joints],
        })
    }

    /// Takes where the robot is and stands: the base and the directions of bones count.
    ///
    /// - `pose`: `[m]` in the world, skeleton order.
    ///
    /// Returns whether it did: not if a place is not finite or missing, a bone has no length, or the
    /// gate has started already ([`Self::reset`] it first, and let it come to a stand).
    pub fn start(&mut self, pose: &[Point], now: Stamp) -> bool {
        if self.started || pose.len() != self.chain.joints() || !pose.iter().all(is_place) {
            return false;
        }
        let has_length = |ends: [usize; 2]| (pose[ends[0]] - pose[ends[1]]).norm() > 1e-9;
        if !self.chain.links().iter().all(|link| has_length([link.from, link.to])) {
            return false;
        }
        let coordinates = &mut self.scratch[0];
        self.chain.coordinates_of(|joint| pose[joint], coordinates);
        for (state, coordinate) in self.state.iter_mut().zip(coordinates) {
            *state = [*coordinate, Vector::zeros(), Vector::zeros()];
        }
        self.target.plan.brake_from(&self.state, 0.0);
        self.target.elapsed = Span(0);
        self.target.keeps_separation = true;
        self.target.reason = None;
        (self.ticked, self.resumed, self.period) = (None, None, Span(0));
        (self.leaving, self.clock_set) = (false, false);
        self.partner = PartnerBody::default();
        self.started = true;
        self.evaluate(now);
        true
    }

    /// Whether the robot has said where it is, or has not come to a stand since it was reset.
    pub fn is_started(&self) -> bool {
        self.started
    }

    /// Forgets where the robot is: it has to [`Self::start`] again, standing.
    ///
    /// A motion is not cut off: while the last target still moves the gate stays started, each tick
    /// brakes, whatever is proposed ([`HoldReason::NoRobot`]), and a start is refused. The first
    /// target that stands is the last one; from then on there is none before the next start.
    pub fn reset(&mut self) {
        self.leaving = self.started && self.target.is_moving();
        self.started = self.leaving;
    }

    /// Where the robot is to be now, and from now on; none before [`Self::start`].
    ///
    /// - `partner`: as last seen; without one, or without some of it, no distance is kept to what is
    ///   not known. A partner at no finite place brakes the robot ([`HoldReason::Lost`]).
    /// - `now`: later than at the last call, by 60 s at most. At the same `now` the last target comes
    ///   again. A clock that went back, or on by more, was set: the robot brakes and stands before it
    ///   follows anything again, and until the stamps go on properly as much time is taken to pass
    ///   from one to the next as did last (at most `lead`). Both are [`HoldReason::Clock`].
    ///
    /// The target says why the robot is not moving as proposed. While the partner is nearer than
    /// `separation`, that is [`HoldReason::Separation`], and only such motion passes as brings no
    /// bone nearer to them than it is.
    ///
    /// Never panics, whatever the data. Allocates nothing.
    pub fn admit(
        &mut self,
        proposal: Proposal<'_>,
        partner: Option<&PartnerBody>,
        now: Stamp,
    ) -> Option<&Target> {
        if !self.started {
            return None;
        }
        if self.ticked == Some(now) {
            self.target.reason = Some(HoldReason::Clock);
            return Some(&self.target);
        }
        let passed = self.passed(now);
        self.clock_set |= passed.is_none();
        self.target.elapsed = self.target.after(passed.unwrap_or(self.period));
        self.evaluate(now);
        self.clock_set &= passed.is_none() || self.target.is_moving();
        // Whoever resets may forget the partner as well: they are taken to be where they were.
        let forgotten = if self.leaving { self.partner } else { PartnerBody::default() };
        let mut partner = partner.copied().unwrap_or(forgotten);
        let mut proposal = proposal;
        if self.leaving {
            proposal = Proposal::Hold(HoldReason::NoRobot);
        } else if self.clock_set {
            proposal = Proposal::Hold(HoldReason::Clock);
        }
        if !partner.is_somewhere() {
            // Where they were when last planned is the best that is known.
            partner = self.partner;
            if !(self.leaving || self.clock_set) {
                proposal = Proposal::Hold(HoldReason::Lost);
            }
        }
        self.certifier.observe(&self.chain, &self.target.positions, &partner);
        let reason = match proposal {
            Proposal::Hold(reason) => {
                if reason == HoldReason::Stopped {
                    self.resumed = None;
                }
                self.hold(&partner);
                Some(reason)
            }
            Proposal::Move { poses, step } => {
                let joints = self.chain.joints();
                let outcome = match Poses::new(poses, step, joints) {
                    Some(poses) => self.approach(&poses, &partner),
                    None => Err(HoldReason::Unsolved),
                };
                match outcome {
                    // The distance now is what the person made of it; the robot keeps or mends it.
                    Ok(()) if self.certifier.distance() < self.settings.separation => {
                        Some(HoldReason::Separation)
                    }
                    Ok(()) => None,
                    Err(reason) => {
                        // Going on is certified; but not against where the partner is now.
                        if reason != HoldReason::Limits || partner != self.partner {
                            self.hold(&partner);
                        }
                        Some(reason)
                    }
                }
            }
        };
        self.target.reason = reason;
        if self.leaving && !self.target.is_moving() {
            (self.started, self.leaving) = (false, false);
        }
        Some(&self.target)
    }

    /// How much time has passed since the last tick; none if the clock was set meanwhile.
    fn passed(&mut self, now: Stamp) -> Option<Span> {
        // It has stood since the start.
        let Some(last) = self.ticked.replace(now) else { return Some(Span(0)) };
        let step = now - last;
        if step > Span(0) && step <= LONGEST_STEP {
            let longest = Span::from_seconds(self.settings.lead).unwrap_or_default();
            self.period = step.min(longest);
            return Some(step);
        }
        // A stamp by the clock as it was means nothing any more.
        self.resumed = None;
        None
    }

    /// Takes place and motion now from the plan that is followed.
    fn evaluate(&mut self, now: Stamp) {
        self.target.stamp = now;
        let moment = self.target.plan.moment(self.target.elapsed.seconds());
        for at in 0..self.state.len() {
            let [place, velocity, acceleration, _] = self.target.plan.coordinate(moment, at);
            self.state[at] = [place, velocity, acceleration];
        }
        self.certifier.look(&self.chain, &self.target.plan, moment);
        for (at, joint) in self.certifier.joints().iter().enumerate() {
            self.target.positions[at] = Point::from(joint[0]);
            self.target.velocities[at] = joint[1];
        }
    }

    /// Limits now, as a share of the full ones.
    fn share(&mut self) -> f64 {
        let now = self.target.stamp;
        let since = (now - *self.resumed.get_or_insert(now)).seconds();
        let part = if self.settings.recover > 0.0 { since / self.settings.recover } else { 1.0 };
        GENTLE + (1.0 - GENTLE) * part.clamp(0.0, 1.0)
    }

    /// Follows the first plan towards the poses that is certified.
    ///
    /// # Errors
    /// Why the last one that was tried is not.
    fn approach(&mut self, poses: &Poses<'_>, partner: &PartnerBody) -> Result<(), HoldReason> {
        let share = self.share();
        let mut why = HoldReason::Limits;
        for stretch in [1.0, 1.5, 2.25, 3.4, 5.0] {
            let time = self.settings.aim * stretch;
            let aims = &mut self.aims;
            if follow(poses, &self.chain, time, &self.state, &mut self.scratch, aims) {
                match self.attempt(time, share) {
                    Ok(()) => return self.commit(partner),
                    Err(reason) => why = reason,
                }
            }
        }
        // A rest-to-rest motion of this way in this time just keeps all limits: with peaks
        // 15/8 w/t, 5.8 w/t² and 60 w/t³ (minimum jerk) of at most nine tenths.
        let SafetySettings { speed, acceleration, jerk, .. } = self.settings;
        let time = (32.0 * speed / jerk).sqrt().max(3.1 * speed / acceleration);
        let time = time.max(self.settings.aim);
        let way = 0.48 * speed * share * time;
        let goal = &mut self.scratch[0];
        goal.iter_mut().zip(&self.state).for_each(|(own, now)| *own = now[0]);
        poses.at(&self.chain, self.settings.aim, goal);
        for part in [1.0, 0.6, 0.3, 0.1, 0.02] {
            let goal = &self.scratch[0];
            let (ways, aims) = (&mut self.ways, &mut self.aims);
            towards(goal, &self.chain, way * part, &self.state, ways, aims);
            match self.attempt(time, share) {
                Ok(()) => return self.commit(partner),
                Err(reason) => why = reason,
            }
        }
        Err(why)
    }

    /// Certifies the plan to the aims in so long `[s]`, of which the first part is gone.
    fn attempt(&mut self, time: f64, share: f64) -> Result<(), HoldReason> {
        for (at, curve) in self.trial.go.iter_mut().enumerate() {
            *curve = quintic(&self.state[at], &self.aims[at], time);
        }
        let lead = self.settings.lead;
        self.certifier.check_go(&self.chain, &self.trial, lead, share)?;
        let quick = self.quickest(self.certifier.pace());
        let mut why = HoldReason::Limits;
        for stretch in [1.05, 1.5] {
            self.trial.brake_after(lead, quick * stretch);
            match self.certifier.check_brake(&self.chain, &self.trial, Rules::All) {
                Ok(()) => return Ok(()),
                Err(reason) => why = reason,
            }
        }
        Err(why)
    }

    /// About the shortest time to stop in `[s]`, from this speed and acceleration.
    fn quickest(&self, [speed, acceleration]: [f64; 2]) -> f64 {
        let limits = [self.settings.acceleration, self.settings.jerk];
        self.trial.shape().estimate(speed, acceleration, limits)
    }

    /// Brakes, as quickly as is certified; else what is followed goes on, into its standstill.
    fn hold(&mut self, partner: &PartnerBody) {
        let elapsed = self.target.elapsed.seconds();
        let left = self.target.plan.duration() - elapsed;
        let moved = *partner != self.partner;
        let going = elapsed < self.target.plan.lead;
        if left <= 0.0 || !(going || moved) {
            return;
        }
        let moment = self.target.plan.moment(elapsed);
        self.certifier.look(&self.chain, &self.target.plan, moment);
        let quick = self.quickest(self.certifier.pace());
        let all = [Rules::All, Rules::ButSeparation];
        for &rules in if moved { &all[..] } else { &all[..1] } {
            for stretch in [0.75, 1.05, 1.4, 1.9] {
                let stop = quick * stretch;
                // Not later than it would stand anyway; once braking, not for a trifle.
                if stop >= if going { left } else { 0.8 * left } {
                    break;
                }
                self.trial.brake_from(&self.state, stop);
                if self.certifier.check_brake(&self.chain, &self.trial, rules).is_err() {
                    continue;
                }
                if rules == Rules::ButSeparation {
                    let own = self.certifier.distance_on(&self.chain, &self.trial, 0.0);
                    let plan = &self.target.plan;
                    if own < self.certifier.distance_on(&self.chain, plan, elapsed) {
                        continue;
                    }
                }
                let _ = self.commit(partner);
                self.target.keeps_separation = rules == Rules::All;
                return;
            }
        }
    }

    /// Follows the trial from now on.
    fn commit(&mut self, partner: &PartnerBody) -> Result<(), HoldReason> {
        std::mem::swap(&mut self.target.plan, &mut self.trial);
        self.target.elapsed = Span(0);
        self.target.keeps_separation = true;
        self.partner = *partner;
        Ok(())
    }
}
