//! Whether a plan may be followed: every joint, all the way to the standstill.
//!
//! Limits are on jets of the joints, exact at samples, where [`RESERVE`] of a limit may be taken.
//! Between samples `h` apart speed, acceleration and jerk are at most `h²/8` of their own second
//! derivatives above the samples, and these are bounded ([`super::bounds`]) over each piece of a
//! plan; where that is above the limit, the piece is sampled again, as finely as makes it fit in what
//! the reserve left. Places need no reserve: with acceleration at most `a`, a joint is within
//! `a h²/8` of the chord, and a distance between two samples is at least their mean less half the way
//! that fits between them.
//!
//! The work is bounded whatever the settings: a piece is cut into [`MOST`] intervals at most, each
//! time. Where a slow stop makes them long, they need more room between joint and bound, and what
//! would need finer ones is refused. So a tick takes fewer than 8,000 samples of all joints: 81 a
//! piece, 7 pieces in each of 10 plans towards a proposal, 3 in each of 8 stops.
//!
//! What is violated already may not get worse: the bound is then what holds now.

use super::bounds::Peaks;
use super::brake::Shape;
use super::chain::Chain;
use super::distance::Nearness;
use super::jet::{Jet, normalised, squared};
use super::partner::{PARTS, PartnerBody};
use super::plan::{Moment, Plan};
use super::settings::SafetySettings;
use super::{HoldReason, Target};
use crate::geometry::{Point, Vector};

/// The share of a limit that a sample may take.
const RESERVE: f64 = 0.96;
/// The most intervals that a piece of a plan is cut into.
const MOST: u32 = 40;
/// Rounding of places `[m]`, far below anything that can be told apart.
const ROUNDING: f64 = 1e-12;

/// What a plan is held against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rules {
    All,
    /// All but the distance to the partner.
    ButSeparation,
}

/// Why a plan is refused, and buffers to find out.
#[derive(Debug, Clone)]
pub(super) struct Certifier {
    settings: SafetySettings,
    /// Where the joints are now.
    here: Vec<Point>,
    parts: [Option<[Point; 2]>; PARTS],
    /// Of each bone and each part, now.
    near: Vec<[Option<Nearness>; PARTS]>,
    before: Vec<Jet>,
    after: Vec<Jet>,
    /// Of each coordinate at the samples of the piece in hand.
    peaks: Vec<Peaks>,
    /// Bounds of each joint's third, fourth and fifth derivative in that piece.
    steepest: Vec<[f64; 3]>,
}

/// A piece of a plan: as long as its coordinates are polynomials.
#[derive(Debug, Clone, Copy)]
enum Piece {
    /// The first so many `[s]`, going.
    Go(f64),
    /// A phase of the stop.
    Brake(usize),
}

impl Piece {
    /// `[s]`
    fn duration(self, plan: &Plan) -> f64 {
        match self {
            Self::Go(lead) => lead,
            Self::Brake(phase) => plan.shape().phase_duration(phase, plan.stop),
        }
    }

    /// - `part`: `[-]` of the piece, 0 to 1.
    fn moment(self, plan: &Plan, part: f64) -> Moment {
        match self {
            Self::Go(lead) => Moment::Go(lead * part),
            Self::Brake(phase) => Moment::Brake(plan.shape().in_phase(phase, part, plan.stop)),
        }
    }
}

impl Certifier {
    pub(super) fn new(chain: &Chain, settings: SafetySettings) -> Self {
        let (joints, none) = (chain.joints(), [Vector::zeros(); 4]);
        Self {
            settings,
            here: vec![Point::origin(); joints],
            parts: [None; PARTS],
            near: vec![[None; PARTS]; chain.links().len()],
            before: vec![none; joints],
            after: vec![none; joints],
            peaks: vec![Peaks::NONE; joints],
            steepest: vec![[0.0; 3]; joints],
        }
    }

    /// Takes where robot and partner are now.
    pub(super) fn observe(&mut self, chain: &Chain, here: &[Point], partner: &PartnerBody) {
        self.here.copy_from_slice(here);
        self.parts = partner.parts();
        for (link, near) in chain.links().iter().zip(&mut self.near) {
            let bone = [here[link.from], here[link.to]];
            *near = self.parts.map(|part| part.map(|part| Nearness::of(bone, part)));
        }
    }

    /// Least distance to the partner now `[m]`; infinite without one.
    pub(super) fn distance(&self) -> f64 {
        let near = self.near.iter().flatten().flatten();
        near.map(|near| near.distance).fold(f64::INFINITY, f64::min)
    }

    /// Least distance to the partner at [`Target::MOMENTS`] moments of a plan `[m]`, from a time `[s]`
    /// to its standstill.
    pub(super) fn distance_on(&mut self, chain: &Chain, plan: &Plan, from: f64) -> f64 {
        let mut least = f64::INFINITY;
        for k in 0..Target::MOMENTS {
            let part = f64::from(k) / f64::from(Target::MOMENTS - 1);
            let time = from + (plan.duration() - from).max(0.0) * part;
            let moment = plan.moment(time);
            chain.lay(|at| plan.coordinate(moment, at), &mut self.after);
            for link in chain.links() {
                let bone = [link.from, link.to].map(|joint| Point::from(self.after[joint][0]));
                for part in self.parts.iter().flatten() {
                    least = least.min(Nearness::of(bone, *part).distance);
                }
            }
        }
        least
    }

    /// Largest speed `[m/s]` and acceleration `[m/s²]` of any joint at the last sample.
    pub(super) fn pace(&self) -> [f64; 2] {
        [1, 2].map(|order| {
            let squares = self.after.iter().map(|joint| joint[order].norm_squared());
            squares.fold(0.0, f64::max).sqrt()
        })
    }

    /// Lays the joints at a moment, as the last sample.
    pub(super) fn look(&mut self, chain: &Chain, plan: &Plan, moment: Moment) {
        chain.lay(|at| plan.coordinate(moment, at), &mut self.after);
    }

    /// The joints at the last sample.
    pub(super) fn joints(&self) -> &[Jet] {
        &self.after
    }

    /// Checks the first `lead` `[s]` of `plan.go`, with limits times `share`.
    ///
    /// # Errors
    /// What is broken.
    pub(super) fn check_go(
        &mut self,
        chain: &Chain,
        plan: &Plan,
        lead: f64,
        share: f64,
    ) -> Result<(), HoldReason> {
        let count = intervals(lead, 0.0125);
        self.check_piece(chain, plan, Piece::Go(lead), count, 0.0, share, Rules::All)
    }

    /// Checks a plan from where it starts to brake.
    ///
    /// # Errors
    /// What is broken.
    pub(super) fn check_brake(
        &mut self,
        chain: &Chain,
        plan: &Plan,
        rules: Rules,
    ) -> Result<(), HoldReason> {
        let mut start = plan.lead;
        for piece in (0..Shape::PHASES).map(Piece::Brake) {
            let duration = piece.duration(plan);
            if duration > 0.0 {
                let count = intervals(duration, 0.03).max(3);
                self.check_piece(chain, plan, piece, count, start, 1.0, rules)?;
            }
            start += duration;
        }
        Ok(())
    }

    /// Checks a piece from `start` `[s]` after now, in `count` intervals or more.
    #[expect(clippy::too_many_arguments, reason = "one piece of one plan, used twice")]
    fn check_piece(
        &mut self,
        chain: &Chain,
        plan: &Plan,
        piece: Piece,
        count: u32,
        start: f64,
        share: f64,
        rules: Rules,
    ) -> Result<(), HoldReason> {
        let duration = piece.duration(plan);
        let step = duration / f64::from(count);
        self.peaks.fill(Peaks::NONE);
        let mut most = [0.0; 3];
        for k in 0..=count {
            let part = f64::from(k) / f64::from(count);
            self.sample(chain, plan, piece.moment(plan, part))?;
            self.check_limits(share, &mut most)?;
            if k > 0 {
                self.check_workspace(step)?;
                if rules == Rules::All {
                    self.check_separation(chain, step, start + step * f64::from(k))?;
                }
            }
            std::mem::swap(&mut self.before, &mut self.after);
        }
        // The last sample is `after` for whoever asks.
        std::mem::swap(&mut self.before, &mut self.after);
        let Some(finer) = self.intervals_needed(chain, plan, piece, step, share, most) else {
            return Err(HoldReason::Limits);
        };
        for k in 0..finer {
            let part = (f64::from(k) + 1.0) / f64::from(finer);
            self.sample(chain, plan, piece.moment(plan, part))?;
            self.check_limits(share, &mut most)?;
        }
        Ok(())
    }

    /// How many intervals the piece just sampled needs so that nothing between samples is above the
    /// limits: 0 if those it had will do, none if too many.
    ///
    /// - `most`: squares of speed, acceleration and jerk at the samples.
    fn intervals_needed(
        &mut self,
        chain: &Chain,
        plan: &Plan,
        piece: Piece,
        step: f64,
        share: f64,
        most: [f64; 3],
    ) -> Option<u32> {
        let bends = match piece {
            Piece::Go(_) => [0.0; 2],
            Piece::Brake(phase) => plan.bends(phase),
        };
        let steepest = |at: usize| match piece {
            Piece::Go(lead) => plan.steepest_go(lead, at),
            Piece::Brake(_) => plan.steepest_brake(bends, at),
        };
        self.steepest[chain.base()] = self.peaks[0].of_place(steepest(0), step);
        let mut largest = self.steepest[chain.base()];
        for (at, link) in (1..).zip(chain.links()) {
            let turn = self.peaks[at].of_direction(steepest(at), step)?;
            let from = self.steepest[link.from];
            let to = &mut self.steepest[link.to];
            for order in 0..3 {
                to[order] = from[order] + link.length * turn[order];
                largest[order] = largest[order].max(to[order]);
            }
        }
        let (limits, chord) = (self.limits(), step * step / 8.0);
        let mut needed = 0.0f64;
        for order in 0..3 {
            let excess = chord * largest[order];
            if most[order].sqrt() + excess > limits[order] {
                let left = limits[order] * (1.0 - RESERVE * share);
                needed = needed.max((excess / left).sqrt());
            }
        }
        let count = (needed * piece.duration(plan) / step).ceil();
        // What is not a number is too many.
        (count <= f64::from(MOST)).then_some(count as u32)
    }

    fn sample(&mut self, chain: &Chain, plan: &Plan, moment: Moment) -> Result<(), HoldReason> {
        let (mut steady, peaks) = (true, &mut self.peaks);
        let coordinate = |at: usize| {
            let raw = plan.raw(moment, at);
            let square = squared(&raw);
            peaks[at].take(&raw, &square);
            if at == 0 {
                return raw;
            }
            // Not near zero, where directions turn fast.
            steady &= square[0] >= 0.25;
            normalised(&raw, &square)
        };
        chain.lay(coordinate, &mut self.after);
        if steady { Ok(()) } else { Err(HoldReason::Limits) }
    }

    fn limits(&self) -> [f64; 3] {
        [self.settings.speed, self.settings.acceleration, self.settings.jerk]
    }

    /// - `peaks`: largest squares of speed, acceleration and jerk so far, updated.
    fn check_limits(&self, share: f64, peaks: &mut [f64; 3]) -> Result<(), HoldReason> {
        let most = self.limits().map(|limit| (limit * RESERVE * share).powi(2));
        for joint in &self.after {
            for order in 0..3 {
                let square = joint[order + 1].norm_squared();
                if square.is_nan() || square > most[order] {
                    return Err(HoldReason::Limits);
                }
                peaks[order] = peaks[order].max(square);
            }
        }
        Ok(())
    }

    fn check_workspace(&self, step: f64) -> Result<(), HoldReason> {
        let Some([low, high]) = self.settings.workspace else { return Ok(()) };
        let slack = self.settings.acceleration * step * step / 8.0;
        for ((here, before), after) in self.here.iter().zip(&self.before).zip(&self.after) {
            for axis in 0..3 {
                for (bound, sign) in [(low[axis], 1.0), (high[axis], -1.0)] {
                    let least = (sign * bound).min(sign * here[axis]);
                    let along = |jet: &Jet| jet.map(|order| sign * order[axis]);
                    if !stays_above(along(before), along(after), step, slack, least) {
                        return Err(HoldReason::Workspace);
                    }
                }
            }
        }
        Ok(())
    }

    /// - `time`: `[s]` from now to the end of the interval.
    fn check_separation(&self, chain: &Chain, step: f64, time: f64) -> Result<(), HoldReason> {
        let settings = &self.settings;
        let bound = settings.separation + settings.partner_speed * time;
        let slack = settings.acceleration * step * step / 8.0;
        for (link, near) in chain.links().iter().zip(&self.near) {
            let ends = [link.from, link.to];
            // A place between the ends moves no faster and no farther than one of them.
            let way = ends.map(|joint| self.way(joint, step)).into_iter().fold(0.0, f64::max);
            let gone = ends.map(|joint| self.gone(joint)).into_iter().fold(0.0, f64::max);
            for (near, part) in near.iter().zip(&self.parts) {
                let (Some(near), Some(part)) = (near, part) else { continue };
                let least = bound.min(near.distance);
                if near.distance - (gone + way / 2.0) >= least {
                    continue;
                }
                let distance = |joints: &[Jet]| {
                    let bone = ends.map(|joint| Point::from(joints[joint][0]));
                    Nearness::of(bone, *part).distance
                };
                let mean = (distance(&self.before) + distance(&self.after)) / 2.0;
                if mean - way / 2.0 >= least {
                    continue;
                }
                // Past the wall that stands between bone and part now, all of the bone is that far.
                let past = near.away.is_some_and(|away| {
                    ends.iter().all(|&joint| {
                        let along = |jet: &Jet| jet.map(|order| away.dot(&order));
                        let (before, after) =
                            (along(&self.before[joint]), along(&self.after[joint]));
                        stays_above(before, after, step, slack, near.wall + least)
                    })
                });
                if !past {
                    return Err(HoldReason::Separation);
                }
            }
        }
        Ok(())
    }

    /// The longest way a joint can have gone between the samples `[m]`.
    fn way(&self, joint: usize, step: f64) -> f64 {
        let speed = |joints: &[Jet]| joints[joint][1].norm();
        let speed = speed(&self.before).max(speed(&self.after));
        (speed + self.settings.jerk * step * step / 8.0) * step
    }

    /// How far a joint is from where it is now, in the mean of both samples `[m]`.
    fn gone(&self, joint: usize) -> f64 {
        let gone = |joints: &[Jet]| (joints[joint][0] - self.here[joint].coords).norm();
        (gone(&self.before) + gone(&self.after)) / 2.0
    }
}

fn intervals(duration: f64, longest: f64) -> u32 {
    (duration / longest).ceil().clamp(1.0, f64::from(MOST)) as u32
}

/// Whether a value stays at or above `least` between two samples `step` `[s]` apart.
///
/// - `before`, `after`: the value and its derivatives at the samples.
/// - `slack`: how far the value can be from the chord at most.
///
/// Either the chord is high enough, or the value is monotone, so that both ends bound it: its slope
/// keeps its sign because it is itself far enough from zero, or monotone between ends of one sign,
/// its own slope (the third derivative changes little in an interval) keeping its sign.
fn stays_above(before: [f64; 4], after: [f64; 4], step: f64, slack: f64, least: f64) -> bool {
    let end = before[0].min(after[0]);
    if end - slack >= least {
        return true;
    }
    let one_sign = |order: usize| before[order] * after[order] >= 0.0;
    let bend = before[3].abs().max(after[3].abs()) * step * step / 8.0;
    let clear = before[1].abs().min(after[1].abs()) >= 2.0 * bend;
    end >= least - ROUNDING && one_sign(1) && (clear || (one_sign(2) && one_sign(3)))
}

#[cfg(test)]
mod tests {
    use super::{MOST, intervals, stays_above};

    #[test]
    fn no_duration_needs_more_intervals_than_there_are() {
        assert_eq!(intervals(0.05, 0.0125), 4);
        for long in [1.3, 100.0, 1e300, f64::INFINITY] {
            assert_eq!(intervals(long, 0.03), MOST);
        }
    }

    #[test]
    fn a_value_stays_above_between_samples() {
        // From rest upwards, on the bound at first: too near for the chord, but it only rises.
        let away = |t: f64| [t * t * t, 3.0 * t * t, 6.0 * t, 6.0];
        assert!(stays_above(away(0.0), away(0.1), 0.1, 0.01, 0.0));
        let towards = |t: f64| away(t).map(|value| -value);
        assert!(!stays_above(towards(0.0), towards(0.1), 0.1, 0.01, 0.0));
        // A dip between two ends on the bound.
        let dip = |t: f64| [t * t - t, 2.0 * t - 1.0, 2.0, 0.0];
        assert!(!stays_above(dip(0.0), dip(1.0), 1.0, 0.25, 0.0));
        assert!(stays_above(dip(0.0), dip(1.0), 1.0, 0.25, -0.25));
    }
}
