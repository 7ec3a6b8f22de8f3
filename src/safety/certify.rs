//! Whether a plan may be followed: every joint, all the way to the standstill.
//!
//! Limits are on jets of the joints, exact at samples. Between samples: in each piece a coordinate
//! is a polynomial (its jerk of degree two or three) turned into a direction, and a piece is cut into
//! so many intervals that neither turns far in one; a jerk above the limit between two samples below
//! [`RESERVE`] of it would need far more. Speed and acceleration stay near the chord between samples
//! because acceleration and jerk are limited (`h²/8` of the second derivative). Places need no
//! reserve: with acceleration at most `a`, a joint is within `a h²/8` of the chord, and a distance
//! between two samples is at least their mean less half the way that fits between them.
//!
//! What is violated already may not get worse: the bound is then what holds now.

use super::HoldReason;
use super::brake::Shape;
use super::chain::Chain;
use super::distance::Nearness;
use super::jet::{Jet, normalised};
use super::partner::{PARTS, PartnerBody};
use super::plan::{Moment, Plan};
use super::settings::SafetySettings;
use crate::geometry::{Point, Vector};

/// The share of a limit that a sample may take.
const RESERVE: f64 = 0.96;
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

    /// Least distance to the partner at some moments of a plan from a time `[s]` on `[m]`.
    pub(super) fn distance_on(&mut self, chain: &Chain, plan: &Plan, from: f64) -> f64 {
        const MOMENTS: u32 = 12;
        let mut least = f64::INFINITY;
        for k in 0..=MOMENTS {
            let part = f64::from(k) / f64::from(MOMENTS);
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
        let moment = |k: u32| Moment::Go(lead * f64::from(k) / f64::from(count));
        self.check_piece(chain, plan, count, lead, 0.0, share, Rules::All, moment)
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
        for phase in 0..Shape::PHASES {
            let duration = plan.shape().phase_duration(phase, plan.stop);
            if duration > 0.0 {
                let count = intervals(duration, 0.03).max(3);
                let moment = |k: u32| {
                    let part = f64::from(k) / f64::from(count);
                    Moment::Brake(plan.shape().in_phase(phase, part, plan.stop))
                };
                self.check_piece(chain, plan, count, duration, start, 1.0, rules, moment)?;
            }
            start += duration;
        }
        Ok(())
    }

    /// Checks a piece that takes `duration` `[s]`, from `start` `[s]` after now, in `count` parts.
    #[expect(clippy::too_many_arguments, reason = "one piece of one plan, used twice")]
    fn check_piece(
        &mut self,
        chain: &Chain,
        plan: &Plan,
        count: u32,
        duration: f64,
        start: f64,
        share: f64,
        rules: Rules,
        moment: impl Fn(u32) -> Moment,
    ) -> Result<(), HoldReason> {
        let step = duration / f64::from(count);
        for k in 0..=count {
            self.sample(chain, plan, moment(k), step)?;
            self.check_limits(share)?;
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
        Ok(())
    }

    fn sample(
        &mut self,
        chain: &Chain,
        plan: &Plan,
        moment: Moment,
        step: f64,
    ) -> Result<(), HoldReason> {
        let mut steady = true;
        let coordinate = |at: usize| {
            let raw = plan.raw(moment, at);
            if at == 0 {
                return raw;
            }
            // Not near zero, neither here nor between samples, where directions turn fast.
            let near = raw[0].norm_squared() >= 0.25;
            steady &= near && raw[1].norm_squared() * (step * step) <= 0.25;
            normalised(&raw)
        };
        chain.lay(coordinate, &mut self.after);
        if steady { Ok(()) } else { Err(HoldReason::Limits) }
    }

    fn check_limits(&self, share: f64) -> Result<(), HoldReason> {
        let settings = &self.settings;
        let most = [settings.speed, settings.acceleration, settings.jerk];
        let most = most.map(|limit| (limit * RESERVE * share).powi(2));
        let within = |joint: &Jet| (0..3).all(|i| joint[i + 1].norm_squared() <= most[i]);
        // What is not a number is not within.
        if self.after.iter().all(within) { Ok(()) } else { Err(HoldReason::Limits) }
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
    // Durations are at most some seconds: no overflow.
    (duration / longest).ceil().clamp(1.0, 1000.0) as u32
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
    use super::stays_above;

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
