//! Where the people meet, and how each of them gets there: all in `pair`.
//!
//! Hips and trunk follow the progress of the reach and sway a little; hands and feet follow
//! minimum-jerk paths; elbows and knees follow those.

use std::f64::consts::{PI, TAU};

use handover_mesh::geometry::{direction_or, yaw_isometry};
use handover_mesh::kinematics::minimum_jerk;
use handover_mesh::{Isometry, Point, Role, Side, Vector};

use super::config::PersonConfig;
use super::people::{Limb, Stance, Trunk, ankle};
use super::play::{ROLES, Scene};
use crate::body::sign;
use crate::profile::{bell, idle_wave, step};

/// A hand meets comfortably at this part of the stretched arm, measured along the floor.
const COMFORTABLE_REACH: f64 = 0.75;
/// Objects change hands at this part of stature: between elbow (0.63) and shoulder (0.818).
const COMFORTABLE_HEIGHT: f64 = 0.66;

/// One person in `pair`; arms and legs left, right.
pub(super) struct PairPose {
    pub(super) trunk: Trunk,
    pub(super) arms: [Limb; 2],
    pub(super) legs: [Limb; 2],
    pub(super) active: Limb,
    pub(super) shortfall: f64,
}

impl Scene {
    /// Places the meeting point and what each hand goes for: see [`Scene::new`].
    pub(super) fn place_meeting(&mut self) {
        let config = &self.config;
        let shoulders = ROLES.map(|role| {
            let person = config.person(role);
            let trunk = Trunk::of(&self.bodies[role as usize], &self.stance(role, 1.0, None));
            trunk.shoulders[person.hand as usize]
        });
        let between = shoulders[1] - shoulders[0];
        let across = Vector::new(between.x, between.y, 0.0);
        let ahead = direction_or(across, Vector::x());
        let comfort = self.bodies.map(|body| COMFORTABLE_REACH * body.arm() + config.gap / 2.0);
        let mix = |giver: f64, receiver: f64| giver + (receiver - giver) * config.suit_receiver;
        let along = mix(comfort[0], across.norm() - comfort[1]);
        // Never behind either shoulder, however near they stand.
        let along = along.clamp(0.25 * across.norm(), 0.75 * across.norm());
        let [giver, receiver] = self.bodies.map(|body| COMFORTABLE_HEIGHT * body.stature());
        let meeting = shoulders[0] + ahead * along;
        let meeting = Point::new(meeting.x, meeting.y, mix(giver, receiver));
        self.meeting = meeting + config.meeting_shift;
        self.goals = [-0.5, 0.5].map(|half| self.meeting + ahead * (half * config.gap));
    }

    /// Hips and trunk at a given progress of the reach; without `seconds` no idle motion and no
    /// walk.
    fn stance(&self, role: Role, progress: f64, seconds: Option<f64>) -> Stance {
        let person = self.config.person(role);
        let body = &self.bodies[role as usize];
        let wave = |rate: f64, phase: f64| {
            seconds.map_or(0.0, |seconds| idle_wave(seconds, rate, person.phase + phase))
        };
        let sway = Vector::new(wave(0.31, 0.0), wave(0.23, 1.1), 0.0) * person.sway;
        // A trunk of half a metre that sways as its hips do turns by about twice as many radians.
        let tilt = 2.0 * person.sway;
        let (behind, speed) = seconds.map_or((0.0, 0.0), |seconds| {
            let (distance, part) = self.walk(role, seconds);
            (distance * (minimum_jerk(part) - 1.0), bell(part, 0.0, 1.0))
        });
        // Longer steps need lower hips: 5 % of a leg frees its foot by 0.3 of it.
        let height = body.hip_height() * (1.0 - 0.05 * speed);
        let ahead = seconds.map_or(0.0, |seconds| self.step_in(role, seconds));
        let hips = Vector::new(behind + ahead, 0.0, height) + sway;
        Stance {
            pair_from_hips: self.stand(role) * yaw_isometry(tilt * wave(0.19, 2.2), hips),
            lean: person.lean * progress + tilt * wave(0.27, 3.3),
            twist: -sign(person.hand) * person.twist * progress,
            nod: 0.06 + 0.12 * progress,
        }
    }

    /// How far this person walks in all (0 for who stands), and the part of it done.
    fn walk(&self, role: Role, seconds: f64) -> (f64, f64) {
        match &self.config.approach {
            Some(approach) if approach.role == role => {
                let [start, end] = self.moments.walk;
                (approach.distance, ((seconds - start) / (end - start)).clamp(0.0, 1.0))
            }
            _ => (0.0, 1.0),
        }
    }

    /// How far ahead of their stand this person has stepped `[m]`.
    fn step_in(&self, role: Role, seconds: f64) -> f64 {
        match &self.config.step_in {
            Some(step_in) if role == Role::Second => {
                let [start, end] = self.moments.reach[role as usize];
                let start = start + step_in.reach * (end - start);
                let part = |start: f64| step(seconds, start, start + step_in.duration);
                step_in.distance * (part(start) - part(start + step_in.duration + step_in.stay))
            }
            _ => 0.0,
        }
    }

    /// `pair` from the upright frame of this person's stand at the handover.
    fn stand(&self, role: Role) -> Isometry {
        let (side, yaw) = match role {
            Role::First => (-0.5, 0.0),
            Role::Second => (0.5, PI),
        };
        let place = Vector::new(side * self.config.distance, 0.0, 0.0);
        yaw_isometry(yaw + self.config.person(role).facing, place)
    }

    /// One person at an instant, `[s]`.
    pub(super) fn pose_in_pair(&self, role: Role, seconds: f64) -> PairPose {
        let person = self.config.person(role);
        let body = &self.bodies[role as usize];
        let progress = self.moments.progress(role, seconds);
        let stance = self.stance(role, progress, Some(seconds));
        let trunk = Trunk::of(body, &stance);
        let (distance, part) = self.walk(role, seconds);
        let striding = distance * bell(part, 0.0, 1.0);

        let hand_goal = |side: Side| {
            // Arms swing against each other, more while walking.
            let beat = idle_wave(seconds, 0.37, person.phase + sign(side)) * person.swing;
            let stride = 0.25 * striding * sign(side) * (TAU * part).sin();
            if side != person.hand {
                return trunk.resting_hand(body, side, 0.0, beat + stride);
            }
            self.active_hand_goal(role, person, &trunk, seconds, beat)
        };
        let goals = Side::BOTH.map(hand_goal);
        // The elbow's height over the hand wanders a little too.
        let swivel = person.swivel + 2.0 * person.swing * idle_wave(seconds, 0.17, person.phase);
        let arms = Side::BOTH.map(|side| trunk.arm(body, side, goals[side as usize], swivel));
        let legs = Side::BOTH.map(|side| {
            let ahead = Vector::x() * self.step_in(role, seconds);
            let target = self.stand(role) * (ankle(body, side, distance, part) + ahead);
            trunk.leg(body, &stance, side, target)
        });
        let active = arms[person.hand as usize];
        let missed = (active.end - goals[person.hand as usize]).norm();
        let shortfall = if active.clamped { missed } else { 0.0 };
        PairPose { trunk, arms, legs, active, shortfall }
    }

    /// Where the hand that gives or takes should be, `[m]` in `pair`.
    fn active_hand_goal(
        &self,
        role: Role,
        person: &PersonConfig,
        trunk: &Trunk,
        seconds: f64,
        beat: f64,
    ) -> Point {
        let moments = &self.moments;
        let body = &self.bodies[role as usize];
        // Who holds the object rests with a raised forearm. At the transfer both hands are at
        // the meeting point, so the change of rest is not seen.
        let holding = (role == Role::First) == (seconds < moments.transfer);
        let carry = if holding { person.carry } else { 0.0 };
        let rest = trunk.resting_hand(body, person.hand, carry, beat);
        let progress = moments.progress(role, seconds);
        let [start, end] = moments.reach[role as usize];
        let out = step(seconds, start, end);
        // 16 s²(1−s)² is 1 halfway and flat at both ends, so the path keeps its rest there.
        let rise = person.arc * 16.0 * (out * (1.0 - out)).powi(2);
        rest + (self.goals[role as usize] - rest) * progress + Vector::z() * rise
    }
}
