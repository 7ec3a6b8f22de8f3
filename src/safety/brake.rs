//! How a motion is brought to rest: its progress along its own path, from full speed to none.
//!
//! `y(t) = u + u′ σ(t) + ½ u″ σ(t)²` goes the way the motion was bent to go, with `σ′` falling
//! from 1 to 0 and `σ″` from 0 to 0: all coordinates by one `σ`. Its shape is the quickest stop from
//! full speed within acceleration and jerk (`rsruckig`, a port of Berscheid & Kröger 2021), found
//! once, since that allocates; slower and quicker stops are the same shape in other durations.

use rsruckig::prelude::{ControlInterface, InputParameter, Ruckig, ThrowErrorHandler, Trajectory};

use super::settings::{SafetyError, SafetySettings};

/// Part of a stop with constant jerk, in units of the whole stop's duration.
#[derive(Debug, Clone, Copy, Default)]
struct Phase {
    start: f64,
    duration: f64,
    /// σ and its derivatives where the phase starts.
    from: [f64; 4],
}

/// The shape of a stop that takes one unit of time from speed 1.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    phases: [Phase; Self::PHASES],
    /// How far the stop goes.
    way: f64,
    /// Largest |σ″|, |σ‴| and |3 σ′ σ″ + σ σ‴|: what velocity and acceleration are multiplied by in
    /// `y″` and `y‴`.
    peaks: [f64; 3],
    /// What a stop from full speed takes `[s]`.
    full: f64,
}

impl Shape {
    /// Jerk one way, none, and the other way.
    pub(super) const PHASES: usize = 3;

    /// # Errors
    /// [`SafetyError::Brake`] if no stop is found: not for settings that were checked.
    pub(super) fn new(settings: &SafetySettings) -> Result<Self, SafetyError> {
        let mut input = InputParameter::<1>::new(None);
        input.control_interface = ControlInterface::Velocity;
        input.current_velocity[0] = settings.speed;
        input.max_velocity[0] = settings.speed;
        input.max_acceleration[0] = settings.acceleration;
        input.max_jerk[0] = settings.jerk;
        let mut trajectory = Trajectory::<1>::new(None);
        // The period is of no use to a stop computed as a whole.
        let mut planner = Ruckig::<1, ThrowErrorHandler>::new(None, 0.01);
        planner.calculate(&input, &mut trajectory).map_err(|_| SafetyError::Brake)?;
        let profile = trajectory.profiles.first().ok_or(SafetyError::Brake)?[0];
        let full: f64 = profile.t.iter().sum();
        Self::from_phases(&profile.t, &profile.j, settings.speed, full).ok_or(SafetyError::Brake)
    }

    fn from_phases(times: &[f64], jerks: &[f64], speed: f64, full: f64) -> Option<Self> {
        let mut shape = Self { phases: Default::default(), way: 0.0, peaks: [0.0; 3], full };
        let (mut state, mut start, mut filled) = ([0.0, 1.0, 0.0, 0.0], 0.0, 0);
        for (time, jerk) in times.iter().zip(jerks).filter(|(time, _)| **time > 1e-9 * full) {
            let duration = time / full;
            state[3] = jerk * full * full / speed;
            let phase = Phase { start, duration, from: state };
            *shape.phases.get_mut(filled)? = phase;
            filled += 1;
            state = phase.at(duration);
            start += duration;
            shape.peaks[0] = shape.peaks[0].max(state[2].abs());
            shape.peaks[1] = shape.peaks[1].max(state[3].abs());
            const SAMPLES: u32 = 32;
            for k in 0..=SAMPLES {
                let [s0, s1, s2, s3] = phase.at(duration * f64::from(k) / f64::from(SAMPLES));
                shape.peaks[2] = shape.peaks[2].max((3.0 * s1 * s2 + s0 * s3).abs());
            }
        }
        shape.way = state[0];
        // What is left is cut off: at the end a stop stands, to the bit.
        let stands = state[1].abs() < 1e-9 && state[2].abs() < 1e-6;
        let whole = (start - 1.0).abs() < 1e-6;
        (stands && whole && full.is_finite() && shape.way.is_finite()).then_some(shape)
    }

    /// σ and its derivatives in a phase, in a stop that takes `duration` `[s]`.
    ///
    /// - `part`: `[-]` of the phase, 0 to 1.
    pub(super) fn in_phase(&self, phase: usize, part: f64, duration: f64) -> [f64; 4] {
        let phase = &self.phases[phase];
        scaled(phase.at(phase.duration * part), duration)
    }

    /// What a phase takes in a stop that takes `duration` `[s]`.
    pub(super) fn phase_duration(&self, phase: usize, duration: f64) -> f64 {
        self.phases[phase].duration * duration
    }

    /// σ and its derivatives at a time `[s]` after the start; at rest from the end on.
    pub(super) fn at(&self, time: f64, duration: f64) -> [f64; 4] {
        if time >= duration {
            return [self.way * duration, 0.0, 0.0, 0.0];
        }
        let part = time / duration;
        let phase = self.phases.iter().rev().find(|p| p.duration > 0.0 && p.start <= part);
        let phase = phase.unwrap_or(&self.phases[0]);
        scaled(phase.at(part - phase.start), duration)
    }

    /// About what a stop takes `[s]` from these: joints' largest speed `[m/s]` and acceleration
    /// `[m/s²]`, within these limits of acceleration and jerk.
    ///
    /// As if both were along one line: jerk is then at most `(peak₁ v / S + peak₂ a) / S`. The
    /// certificate has the last word.
    pub(super) fn estimate(&self, speed: f64, acceleration: f64, limits: [f64; 2]) -> f64 {
        let [most_acceleration, most_jerk] = limits;
        let [second, third, mixed] = self.peaks;
        let linear = mixed * acceleration;
        let root = (linear * linear + 4.0 * third * speed * most_jerk).sqrt();
        let by_jerk = (linear + root) / (2.0 * most_jerk);
        by_jerk.max(second * speed / most_acceleration).clamp(0.02 * self.full, 4.0 * self.full)
    }
}

impl Phase {
    fn at(&self, t: f64) -> [f64; 4] {
        let [s0, s1, s2, s3] = self.from;
        [
            s0 + (s1 + (s2 / 2.0 + s3 / 6.0 * t) * t) * t,
            s1 + (s2 + s3 / 2.0 * t) * t,
            s2 + s3 * t,
            s3,
        ]
    }
}

fn scaled(unit: [f64; 4], duration: f64) -> [f64; 4] {
    let [s0, s1, s2, s3] = unit;
    [s0 * duration, s1, s2 / duration, s3 / (duration * duration)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brakes_reach_rest_within_what_they_were_made_for() {
        for (speed, acceleration, jerk) in [(1.5, 8.0, 120.0), (0.3, 2.0, 5.0), (10.0, 1.0, 1e4)] {
            let settings =
                SafetySettings { speed, acceleration, jerk, ..SafetySettings::default() };
            let shape = Shape::new(&settings).unwrap();
            let full = shape.full;
            assert_eq!(shape.at(0.0, full)[..3], [0.0, 1.0, 0.0]);
            assert_eq!(shape.at(full, full)[1..], [0.0; 3]);
            let mut before = shape.at(0.0, full);
            for k in 1..=1000 {
                let now = shape.at(f64::from(k) * full / 1000.0, full);
                assert!(now[0] >= before[0] && now[1] <= before[1]);
                assert!(now[2].abs() * speed <= acceleration * (1.0 + 1e-9));
                assert!(now[3].abs() * speed <= jerk * (1.0 + 1e-9));
                before = now;
            }
            let close = shape.at(full * (1.0 - 1e-9), full);
            assert!(close[1].abs() < 1e-9 && (close[0] - before[0]).abs() < 1e-9);
            // From full speed without acceleration the estimate is what it takes.
            let estimate = shape.estimate(speed, 0.0, [acceleration, jerk]);
            assert!((estimate / full - 1.0).abs() < 1e-6, "{estimate} {full}");
        }
    }
}
