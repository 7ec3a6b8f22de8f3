//! A point as a depth camera and a tracker see it: noise that grows with depth, and steps.
//!
//! Depth comes from disparity, `Z = 1/(c·k)` for integer `k`, so both its noise and the step
//! between two depths grow as `Z²` (Khoshelham & Elberink 2012). An error in depth moves a point
//! along its ray, since the direction is known from the pixel.

use handover_mesh::{Part, Point, Vector};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use super::SensorConfig;

/// Nearer than this the camera sees nothing; its errors are taken as there, `[m]`.
const NEAREST: f64 = 0.4;

/// The camera's place and axes in `world`.
pub(super) struct Camera {
    position: Point,
    ahead: Vector,
    left: Vector,
}

impl Camera {
    pub(super) fn of(config: &SensorConfig) -> Self {
        let (sine, cosine) = config.yaw.sin_cos();
        Self {
            position: config.position,
            ahead: Vector::new(cosine, sine, 0.0),
            left: Vector::new(-sine, cosine, 0.0),
        }
    }

    /// How far ahead of the camera, `[m]`.
    fn depth(&self, point: &Point) -> f64 {
        (point - self.position).dot(&self.ahead)
    }

    /// Where the camera measures `point` (both `[m]` in `world`); itself without noise and steps.
    pub(super) fn measured(
        &self,
        config: &SensorConfig,
        point: &Point,
        random: &mut impl Rng,
    ) -> Point {
        let [ahead, left, up] = normals(random);
        let depth = self.depth(point).max(NEAREST);
        let averaged = 1.0 / config.pixels.sqrt();
        let noisy = depth + averaged * config.depth_noise * depth * depth * ahead;
        let seen = quantised(noisy.max(NEAREST), averaged * config.depth_step);
        let along_ray = (point - self.position) * (seen / depth - 1.0);
        let spread = averaged * config.angle_noise * depth;
        let across = (self.left * left + Vector::z() * up) * spread;
        point + along_ray + across
    }
}

/// The nearest depth of an integer disparity, `[m]`, where two are `step·Z²` apart; 0: as it is.
fn quantised(depth: f64, step: f64) -> f64 {
    if step <= 0.0 {
        return depth;
    }
    1.0 / (step * (1.0 / (step * depth)).round().max(1.0))
}

/// The tracker's own error of one joint, which fades and is renewed (a first-order
/// autoregression): `nₖ = a nₖ₋₁ + √(1−a²) ε`, `a = exp(−Δt/τ)`.
#[derive(Clone, Copy, Default)]
pub(super) struct Drift(Option<Vector>);

impl Drift {
    /// The error `[m]` of a joint that is `part`, a time `elapsed` `[s]` after the last one.
    pub(super) fn next(
        &mut self,
        config: &SensorConfig,
        part: Option<Part>,
        elapsed: f64,
        random: &mut impl Rng,
    ) -> Vector {
        let fresh = Vector::from(normals(random));
        let unit = match self.0 {
            Some(last) if config.joint_noise_time > 0.0 => {
                let kept = (-elapsed / config.joint_noise_time).exp();
                last * kept + fresh * (1.0 - kept * kept).sqrt()
            }
            _ => fresh,
        };
        self.0 = Some(unit);
        unit * (config.joint_noise * looseness(part))
    }
}

/// How badly a part of the body is seen, against an elbow or a knee: errors of a fit grow
/// towards the ends of the limbs.
fn looseness(part: Option<Part>) -> f64 {
    match part {
        Some(Part::Hand(_) | Part::Foot(_)) => 2.0,
        Some(Part::Elbow(_) | Part::Knee(_)) | None => 1.0,
        Some(_) => 0.5,
    }
}

fn normals(random: &mut impl Rng) -> [f64; 3] {
    [(); 3].map(|()| StandardNormal.sample(random))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn depth_comes_in_steps_that_grow_with_its_square() {
        for depth in [1.0, 2.0, 4.0] {
            let near = quantised(depth, 2.85e-3);
            assert!((near - depth).abs() <= 0.5 * 2.85e-3 * depth * depth * 1.02);
            let disparity = (1.0 / (2.85e-3 * near)).round();
            let next = 1.0 / (2.85e-3 * (disparity - 1.0));
            assert!(((next - near) / (2.85e-3 * depth * depth) - 1.0).abs() < 0.03);
        }
        assert_eq!(quantised(1.2345, 0.0), 1.2345);
    }

    #[test]
    fn the_drift_has_its_size_and_its_memory() {
        let config =
            SensorConfig { joint_noise: 0.01, joint_noise_time: 0.2, ..SensorConfig::ideal(30.0) };
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut drift = Drift::default();
        let path: Vec<f64> =
            (0..20_000).map(|_| drift.next(&config, None, 0.1, &mut random).x).collect();
        let variance = path.iter().map(|x| x * x).sum::<f64>() / path.len() as f64;
        let lagged = path.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
        assert!((variance.sqrt() / 0.01 - 1.0).abs() < 0.05);
        assert!((lagged / path.len() as f64 / variance - (-0.5_f64).exp()).abs() < 0.03);
    }
}
