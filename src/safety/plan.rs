//! A motion from now into a standstill: going on for a while, then braking.

use super::brake::Shape;
use super::chain::Chain;
use super::jet::{Jet, normalised, polynomial, squared};
use crate::geometry::{Point, Vector};

/// Where in a plan: the derivatives of a plan's pieces differ where they meet.
#[derive(Debug, Clone, Copy)]
pub(super) enum Moment {
    /// So long `[s]` after the start, going.
    Go(f64),
    /// So far along the braking path: σ and its derivatives.
    Brake([f64; 4]),
}

/// The coordinates of a [`Chain`] over time, relative to the plan's start.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    shape: Shape,
    /// Coefficients of each coordinate, not normalised.
    pub(super) go: Vec<[Vector; 6]>,
    /// How long it goes `[s]`; 0: it brakes at once.
    pub(super) lead: f64,
    /// Value and two derivatives of each coordinate where it starts to brake.
    brake: Vec<[Vector; 3]>,
    /// How long it brakes `[s]`; 0: it stands.
    pub(super) stop: f64,
}

impl Plan {
    pub(super) fn new(shape: Shape, coordinates: usize) -> Self {
        let go = vec![[Vector::zeros(); 6]; coordinates];
        Self { shape, go, lead: 0.0, brake: vec![[Vector::zeros(); 3]; coordinates], stop: 0.0 }
    }

    /// Braking at once from this state, in this time `[s]`; 0 s: standing.
    pub(super) fn brake_from(&mut self, state: &[[Vector; 3]], stop: f64) {
        self.lead = 0.0;
        self.brake.copy_from_slice(state);
        self.stop = stop;
    }

    /// Going by `self.go` for `lead` `[s]` and then braking from there, in this time `[s]`.
    pub(super) fn brake_after(&mut self, lead: f64, stop: f64) {
        self.lead = lead;
        self.stop = stop;
        for at in 0..self.go.len() {
            let [place, velocity, acceleration, _] = self.coordinate(Moment::Go(lead), at);
            self.brake[at] = [place, velocity, acceleration];
        }
    }

    pub(super) fn shape(&self) -> &Shape {
        &self.shape
    }

    /// How long until it stands `[s]`.
    pub(super) fn duration(&self) -> f64 {
        self.lead + self.stop
    }

    /// The moment so long `[s]` after the start, ≥ 0.
    pub(super) fn moment(&self, time: f64) -> Moment {
        if time < self.lead {
            Moment::Go(time)
        } else {
            Moment::Brake(self.shape.at(time - self.lead, self.stop))
        }
    }

    /// A coordinate before it is normalised.
    pub(super) fn raw(&self, moment: Moment, at: usize) -> Jet {
        match moment {
            Moment::Go(time) => polynomial(&self.go[at], time),
            Moment::Brake([s0, s1, s2, s3]) => {
                let [place, velocity, bend] = &self.brake[at];
                let slope = velocity + bend * s0;
                [
                    place + (velocity + bend * (0.5 * s0)) * s0,
                    slope * s1,
                    bend * (s1 * s1) + slope * s2,
                    bend * (3.0 * s1 * s2) + slope * s3,
                ]
            }
        }
    }

    /// Bounds of the fourth and fifth derivative of a coordinate before it is normalised, while
    /// going for `lead` `[s]`.
    pub(super) fn steepest_go(&self, lead: f64, at: usize) -> [f64; 2] {
        // Of a quintic: linear, and constant.
        let [.., c4, c5] = &self.go[at];
        let (start, slope) = (c4 * 24.0, c5 * 120.0);
        [start.norm().max((start + slope * lead).norm()), slope.norm()]
    }

    /// The same in a phase of the stop.
    ///
    /// - `bends`: of that phase, as of [`Self::bends`].
    pub(super) fn steepest_brake(&self, bends: [f64; 2], at: usize) -> [f64; 2] {
        let bend = self.brake[at][2].norm();
        bends.map(|most| bend * most)
    }

    /// What `|u″|` is multiplied by at most in `y⁗` and `y⁗′`, in a phase of the stop.
    pub(super) fn bends(&self, phase: usize) -> [f64; 2] {
        // With σ⁗ = 0, y⁗ = u″ (3 σ″² + 4 σ′ σ‴) and y⁗′ = 10 u″ σ″ σ‴. The former is steepest at
        // the ends, since the latter keeps its sign: σ″ is never above zero.
        let ends = [0.0, 1.0].map(|part| {
            let [_, s1, s2, s3] = self.shape.in_phase(phase, part, self.stop);
            [(3.0 * s2 * s2 + 4.0 * s1 * s3).abs(), 10.0 * (s2 * s3).abs()]
        });
        [0, 1].map(|order| ends[0][order].max(ends[1][order]))
    }

    /// A coordinate: the base's place, or a bone's direction.
    pub(super) fn coordinate(&self, moment: Moment, at: usize) -> Jet {
        let raw = self.raw(moment, at);
        if at == 0 { raw } else { normalised(&raw, &squared(&raw)) }
    }

    /// Places of all joints so long `[s]` after the start.
    pub(super) fn points(&self, chain: &Chain, time: f64, joints: &mut [Point]) {
        let moment = self.moment(time);
        let value = |at: usize| {
            let raw = self.raw(moment, at)[0];
            if at == 0 { raw } else { raw.normalize() }
        };
        chain.lay_values(value, joints);
    }

    /// Velocities of all joints so long `[s]` after the start.
    pub(super) fn velocities(&self, chain: &Chain, time: f64, joints: &mut [Vector]) {
        let moment = self.moment(time);
        chain.lay_values(|at| self.coordinate(moment, at)[1], joints);
    }
}
