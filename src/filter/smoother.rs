//! One joint's noisy places → its place and velocity, with little delay.
//!
//! The One-Euro filter's idea (Casiez, Roussel, Vogel 2012): the cut-off rises with the speed,
//! `f = f_min + β‖ẋ‖`, so that rest is quiet and motion prompt. But a low pass of places lags by
//! `v/2πf` behind a moving hand, the very one to be met. So the places go through the
//! fading-memory filter of first degree instead (Morrison 1969, critically damped), which lags
//! behind accelerations only: with `θ = e^(−2πf Δt)` and the prediction `x̂⁻`,
//! `x̂ = x̂⁻ + (1−θ²)(x − x̂⁻)`, `v̂ = v̂⁻ + (1−θ)²/Δt (x − x̂⁻)`. Steps may differ in length.

use std::f64::consts::TAU;

use super::FilterSettings;
use crate::geometry::{Point, Vector};

/// A place and how fast it moves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Smoother {
    /// `[m]` in the world.
    pub(super) place: Point,
    /// `[m/s]`
    pub(super) velocity: Vector,
    /// The low-passed velocity that the cut-off rises with `[m/s]`.
    pace: Vector,
}

impl Smoother {
    /// At rest at a place.
    pub(super) fn at(place: Point) -> Self {
        Self { place, velocity: Vector::zeros(), pace: Vector::zeros() }
    }

    /// Takes a place seen `elapsed` `[s]` after the last one.
    pub(super) fn take(&mut self, seen: Point, elapsed: f64, settings: &FilterSettings) {
        // A nanosecond at least: two stamps are never the same.
        let elapsed = elapsed.max(1e-9);
        let keep = |cutoff: f64| (-TAU * cutoff * elapsed).exp();
        let pace = (seen - self.place) / elapsed;
        self.pace = limited(pace.lerp(&self.pace, keep(settings.speed_cutoff)), settings);
        let theta = keep(settings.min_cutoff + settings.cutoff_per_speed * self.pace.norm());
        let predicted = self.place + self.velocity * elapsed;
        let off = seen - predicted;
        self.place = predicted + off * (1.0 - theta * theta);
        let velocity = self.velocity + off * ((1.0 - theta).powi(2) / elapsed);
        self.velocity = limited(velocity, settings);
    }
}

/// A velocity no faster than a joint can be.
fn limited(velocity: Vector, settings: &FilterSettings) -> Vector {
    let speed = velocity.norm();
    if speed > settings.joint_speed { velocity * (settings.joint_speed / speed) } else { velocity }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `[lag m, speed m/s]` behind a constant velocity of 1 m/s after 2 s.
    fn follow(rates: &[f64]) -> [f64; 2] {
        let settings = FilterSettings::default();
        let mut smoother = Smoother::at(Point::origin());
        let mut time = 0.0;
        for rate in rates.iter().cycle() {
            time += 1.0 / rate;
            smoother.take(Point::new(time, 0.0, 0.0), 1.0 / rate, &settings);
            if time > 2.0 {
                break;
            }
        }
        [time - smoother.place.x, smoother.velocity.x]
    }

    #[test]
    fn a_steady_motion_is_followed_at_any_rate() {
        for rates in [&[15.0][..], &[30.0], &[31.0], &[120.0], &[20.0, 45.0, 31.0]] {
            let [lag, speed] = follow(rates);
            assert!(lag.abs() < 0.012, "{rates:?}: lag {lag} m");
            assert!((speed - 1.0).abs() < 0.15, "{rates:?}: {speed} m/s");
        }
    }

    #[test]
    fn any_step_stays_finite() {
        let settings = FilterSettings::default();
        let mut smoother = Smoother::at(Point::origin());
        for (place, elapsed) in [(1e6, 0.0), (-1e6, 1e-9), (1e6, 1e9), (0.0, 1e-3)] {
            smoother.take(Point::new(place, 0.0, place), elapsed, &settings);
            assert!(smoother.place.coords.amax() < 1.1e6, "{smoother:?}");
            assert!(smoother.velocity.norm() <= 8.0 + 1e-9, "{smoother:?}");
        }
    }
}
