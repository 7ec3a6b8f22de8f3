//! The parameters of one handover, and their ranges.

use std::f64::consts::{PI, TAU};

use handover_mesh::{Role, Side, Vector};

use crate::check::{Check, Violations};

/// One person of a scene: build, stance and habits.
#[derive(Debug, Clone, PartialEq)]
pub struct PersonConfig {
    /// How tall, `[m]`, 1.2 to 2.2. All bones are in proportion.
    pub stature: f64,
    /// The hand that gives or takes.
    pub hand: Side,
    /// How far the body is turned away from the partner, `[rad]`, counter-clockwise seen from
    /// above, −0.8 to 0.8.
    pub facing: f64,
    /// How far the trunk leans ahead at full reach, `[rad]`, 0 to 0.6.
    pub lean: f64,
    /// How far the reaching shoulder turns ahead at full reach, `[rad]`, 0 to 0.6.
    pub twist: f64,
    /// How far the elbow is swung outwards from below the arm, `[rad]`, −0.5 to 1.2.
    pub swivel: f64,
    /// How far the forearm is raised while carrying the object, `[-]`, 0 (hanging) to 1 (level).
    pub carry: f64,
    /// How far the reaching hand rises over the straight path, `[m]`, −0.1 to 0.1.
    pub arc: f64,
    /// Amplitude of idle sway at the hips, `[m]`, 0 to 0.03.
    pub sway: f64,
    /// Amplitude of the hanging arms' idle swing, `[rad]`, 0 to 0.3.
    pub swing: f64,
    /// Phase of the idle motion, `[rad]`, 0 to 2π.
    pub phase: f64,
}

/// When things happen: durations `[s]`, all divided by `tempo`.
#[derive(Debug, Clone, PartialEq)]
pub struct Timing {
    /// Idle time before the reach (or before the walk), 0 to 10.
    pub lead_in: f64,
    /// The giver's reach, 0.2 to 5.
    pub giver_reach: f64,
    /// From the giver's start to the receiver's, 0 to 3: a reaction, so the receiver lags.
    pub reaction: f64,
    /// The receiver's reach, 0.2 to 5.
    pub receiver_reach: f64,
    /// Both hands hold the object, 0.05 to 3; it changes owner halfway.
    pub hold: f64,
    /// From the receiver's retreat to the giver's, −1 to 1; after the transfer in any case.
    pub release: f64,
    /// Either hand's retreat, 0.2 to 5.
    pub retreat: f64,
    /// Idle time at the end, 0 to 10.
    pub lead_out: f64,
    /// `[-]`, 0.25 to 4: at 2 everything takes half as long.
    pub tempo: f64,
}

/// One of the two walks up before the reach.
#[derive(Debug, Clone, PartialEq)]
pub struct Approach {
    /// Who: [`Role::First`] is the giver.
    pub role: Role,
    /// How far off they start, `[m]`, 0.1 to 1.5.
    pub distance: f64,
    /// How long they walk, `[s]` before tempo, 0.5 to 5.
    pub duration: f64,
}

/// The receiver steps towards the giver and back again: hips, trunk and feet move by minimum-jerk
/// steps, while the active hand goes where it is to go.
#[derive(Debug, Clone, PartialEq)]
pub struct StepIn {
    /// How far, `[m]`, 0.05 to 0.8.
    pub distance: f64,
    /// At which part of the receiver's reach it begins, `[-]`, −2 to 4.
    pub reach: f64,
    /// How long it takes, there and back each, `[s]` whatever the tempo, 0.2 to 5.
    pub duration: f64,
    /// How long they stay between the two, `[s]` whatever the tempo, 0 to 100.
    pub stay: f64,
}

/// The parameters of one handover. [`Scene::new`](super::Scene::new) checks them.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneConfig {
    /// Who gives.
    pub giver: PersonConfig,
    /// Who takes.
    pub receiver: PersonConfig,
    /// Between the middles of their hips when they hand over, `[m]`, 0.5 to 2.
    pub distance: f64,
    /// Between their hands at contact, `[m]`, 0.02 to 0.4: the object's length.
    pub gap: f64,
    /// `[-]`, 0 to 1: 0 puts the meeting point where it suits the giver, 1 the receiver.
    pub suit_receiver: f64,
    /// Moves the meeting point, `[m]` in `pair`, each −0.5 to 0.5.
    pub meeting_shift: Vector,
    /// When things happen.
    pub timing: Timing,
    /// Who walks up first, if anyone.
    pub approach: Option<Approach>,
    /// The receiver's step towards the giver, if there is one.
    pub step_in: Option<StepIn>,
    /// The middle between the people, `[m]` on the floor of `world`, each −10 to 10.
    pub centre: [f64; 2],
    /// From world x to the line from giver to receiver, `[rad]` about z, −π to π.
    pub heading: f64,
}

impl PersonConfig {
    /// An adult of 1.75 m with quiet habits, who gives or takes with this hand.
    pub fn ordinary(hand: Side) -> Self {
        Self {
            stature: 1.75,
            hand,
            facing: 0.0,
            lean: 0.12,
            twist: 0.15,
            swivel: 0.35,
            carry: 0.7,
            arc: 0.0,
            sway: 0.004,
            swing: 0.03,
            phase: 0.0,
        }
    }

    /// The same person without sway and swing: at rest they do not move at all.
    pub fn still(self) -> Self {
        Self { sway: 0.0, swing: 0.0, ..self }
    }

    fn check(&self, who: &str, check: &mut Check) {
        let mut range = |key: &str, value, low, high, unit| {
            check.range(format!("{who}.{key}"), value, low..=high, unit);
        };
        range("stature", self.stature, 1.2, 2.2, "m");
        range("facing", self.facing, -0.8, 0.8, "rad");
        range("lean", self.lean, 0.0, 0.6, "rad");
        range("twist", self.twist, 0.0, 0.6, "rad");
        range("swivel", self.swivel, -0.5, 1.2, "rad");
        range("carry", self.carry, 0.0, 1.0, "");
        range("arc", self.arc, -0.1, 0.1, "m");
        range("sway", self.sway, 0.0, 0.03, "m");
        range("swing", self.swing, 0.0, 0.3, "rad");
        range("phase", self.phase, 0.0, TAU, "rad");
    }
}

impl Default for Timing {
    /// Unhurried adults: about five seconds in all.
    fn default() -> Self {
        Self {
            lead_in: 0.8,
            giver_reach: 1.1,
            reaction: 0.35,
            receiver_reach: 1.0,
            hold: 0.35,
            release: 0.1,
            retreat: 1.0,
            lead_out: 0.6,
            tempo: 1.0,
        }
    }
}

impl Timing {
    fn check(&self, check: &mut Check) {
        let mut range = |key: &str, value, low, high, unit| {
            check.range(format!("timing.{key}"), value, low..=high, unit);
        };
        range("lead_in", self.lead_in, 0.0, 10.0, "s");
        range("giver_reach", self.giver_reach, 0.2, 5.0, "s");
        range("reaction", self.reaction, 0.0, 3.0, "s");
        range("receiver_reach", self.receiver_reach, 0.2, 5.0, "s");
        range("hold", self.hold, 0.05, 3.0, "s");
        range("release", self.release, -1.0, 1.0, "s");
        range("retreat", self.retreat, 0.2, 5.0, "s");
        range("lead_out", self.lead_out, 0.0, 10.0, "s");
        range("tempo", self.tempo, 0.25, 4.0, "");
    }
}

impl Default for SceneConfig {
    /// Two ordinary adults, right hand to right hand, 1.1 m apart, nobody walking.
    fn default() -> Self {
        Self {
            giver: PersonConfig::ordinary(Side::Right),
            receiver: PersonConfig { phase: 2.0, ..PersonConfig::ordinary(Side::Right) },
            distance: 1.1,
            gap: 0.12,
            suit_receiver: 0.5,
            meeting_shift: Vector::zeros(),
            timing: Timing::default(),
            approach: None,
            step_in: None,
            centre: [0.0, 0.0],
            heading: 0.0,
        }
    }
}

impl SceneConfig {
    /// Whether every value is in its range.
    ///
    /// # Errors
    /// [`Violations`] names every one that is not.
    pub fn check(&self) -> Result<(), Violations> {
        let mut check = Check::default();
        self.giver.check("giver", &mut check);
        self.receiver.check("receiver", &mut check);
        check.range("distance", self.distance, 0.5..=2.0, "m");
        check.range("gap", self.gap, 0.02..=0.4, "m");
        check.range("suit_receiver", self.suit_receiver, 0.0..=1.0, "");
        for (axis, value) in ["x", "y", "z"].iter().zip(self.meeting_shift.iter()) {
            check.range(format!("meeting_shift.{axis}"), *value, -0.5..=0.5, "m");
        }
        self.timing.check(&mut check);
        if let Some(approach) = &self.approach {
            check.range("approach.distance", approach.distance, 0.1..=1.5, "m");
            check.range("approach.duration", approach.duration, 0.5..=5.0, "s");
        }
        if let Some(step_in) = &self.step_in {
            check.range("step_in.distance", step_in.distance, 0.05..=0.8, "m");
            check.range("step_in.reach", step_in.reach, -2.0..=4.0, "");
            check.range("step_in.duration", step_in.duration, 0.2..=5.0, "s");
            check.range("step_in.stay", step_in.stay, 0.0..=100.0, "s");
        }
        for (axis, value) in ["x", "y"].iter().zip(self.centre) {
            check.range(format!("centre.{axis}"), value, -10.0..=10.0, "m");
        }
        check.range("heading", self.heading, -PI..=PI, "rad");
        check.finish()
    }

    /// The person in this role: [`Role::First`] gives.
    pub fn person(&self, role: Role) -> &PersonConfig {
        match role {
            Role::First => &self.giver,
            Role::Second => &self.receiver,
        }
    }
}
