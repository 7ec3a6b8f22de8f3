//! How a quantity goes from one value to another: smooth steps and idle waves.
//!
//! A reach is [`minimum_jerk`]: velocity and acceleration are zero at both ends.

use std::f64::consts::TAU;

use handover_mesh::kinematics::minimum_jerk;

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
    fn steps_and_bells_have_their_ends() {
        assert_eq!([step(1.0, 2.0, 2.0), step(2.0, 2.0, 2.0)], [0.0, 1.0]);
        let bells = [1.0, 2.0, 9.0].map(|seconds| bell(seconds, 1.0, 3.0));
        assert_eq!(bells, [0.0, 1.0, 0.0]);
    }
}
