//! How a quantity goes from one value to another: smooth steps and idle waves.
//!
//! A reach follows `s(τ) = 10τ³ − 15τ⁴ + 6τ⁵`, the path of least squared jerk between two points
//! at rest (Flash & Hogan, J. Neuroscience 1985): velocity and acceleration are zero at both ends.

use std::f64::consts::TAU;

/// The minimum-jerk step: 0 up to `τ = 0`, 1 from `τ = 1` on, at rest at both.
///
/// ```
/// use handover_sim::profile::minimum_jerk;
/// assert_eq!([-1.0, 0.0, 0.5, 1.0, 2.0].map(minimum_jerk), [0.0, 0.0, 0.5, 1.0, 1.0]);
/// ```
pub fn minimum_jerk(part: f64) -> f64 {
    let t = part.clamp(0.0, 1.0);
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

/// A minimum-jerk step between two instants `[s]`, a jump at `start` where `end` is not later.
pub fn step(seconds: f64, start: f64, end: f64) -> f64 {
    if end > start {
        minimum_jerk((seconds - start) / (end - start))
    } else {
        f64::from(seconds >= start)
    }
}

/// A bell between two instants: 1 in the middle, 0 outside, velocity and acceleration zero at
/// both ends.
pub fn bell(seconds: f64, start: f64, end: f64) -> f64 {
    let t = if end > start { ((seconds - start) / (end - start)).clamp(0.0, 1.0) } else { 0.0 };
    (4.0 * t * (1.0 - t)).powi(3)
}

/// A slow wave in `[−1, 1]` that does not repeat within a clip: two sines without a common period.
///
/// - `rate`: of the slower sine, `[Hz]`.
/// - `phase`: `[rad]`; two people (or two joints) differ by it.
pub fn idle_wave(seconds: f64, rate: f64, phase: f64) -> f64 {
    const SECOND_RATE: f64 = 1.618_033_988_749_895; // The golden ratio: farthest from a fraction.
    let slow = (TAU * rate * seconds + phase).sin();
    let fast = (TAU * rate * SECOND_RATE * seconds + 2.3 * phase).sin();
    0.65 * slow + 0.35 * fast
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_starts_and_ends_at_rest() {
        let h = 1e-4;
        for edge in [0.0, 1.0] {
            let slope = (minimum_jerk(edge + h) - minimum_jerk(edge - h)) / (2.0 * h);
            assert!(slope.abs() < 1e-6, "{slope}");
        }
        // Peak speed of the profile: 15/8.
        let slope = (minimum_jerk(0.5 + h) - minimum_jerk(0.5 - h)) / (2.0 * h);
        assert!((slope - 1.875).abs() < 1e-6);
        assert_eq!([step(1.0, 2.0, 2.0), step(2.0, 2.0, 2.0)], [0.0, 1.0]);
        assert_eq!(
            [bell(1.0, 1.0, 3.0), bell(2.0, 1.0, 3.0), bell(9.0, 1.0, 3.0)],
            [0.0, 1.0, 0.0]
        );
    }
}
