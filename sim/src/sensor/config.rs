//! What a depth camera with a skeleton tracker gets wrong, and how often.

use std::f64::consts::{FRAC_PI_2, PI};

use handover_mesh::Point;

use crate::check::{Check, Violations};

/// Every figure of a [`Sensor`](super::Sensor), with its unit and range.
///
/// Two presets: [`Self::ideal`] sees the truth, [`Self::kinect`] what a Kinect of the first kind
/// with NiTE makes of it.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorConfig {
    /// Frames a second, `[Hz]`, 5 to 120.
    pub rate: f64,
    /// Standard deviation of the instants of capture about an even beat, `[s]`, 0 to 0.05; cut at
    /// 0.4 of the beat, so that stamps rise.
    pub stamp_jitter: f64,
    /// Where the camera is, `[m]` in `world`, each −20 to 20.
    pub position: Point,
    /// Where it looks, level: from world x about z, `[rad]`, −π to π.
    pub yaw: f64,
    /// `σ_Z / Z²` of the depth `Z`, `[1/m]`, 0 to 0.1. Half a step of disparity:
    /// `1.425e-3` (Khoshelham & Elberink, Sensors 12, 2012, equation 9).
    pub depth_noise: f64,
    /// `ΔZ / Z²` between two depths that can be told apart, `[1/m]`, 0 (continuous) to 0.1.
    /// One step of disparity: `2.85e-3` (same source).
    pub depth_step: f64,
    /// Standard deviation of the direction to a pixel, either way, `[rad]`, 0 to 0.1.
    pub angle_noise: f64,
    /// How many pixels a joint's place is averaged over, `[-]`, 1 to 1000: the camera's noise and
    /// step shrink with the root of it. (The object's place is averaged over as many.)
    pub pixels: f64,
    /// Standard deviation of where the tracker sees an elbow or a knee in the body, each axis,
    /// `[m]`, 0 to 0.2: not the camera's error but the fit's. Hands and feet have twice as much,
    /// joints of the trunk half.
    pub joint_noise: f64,
    /// How long that error of the fit lasts, `[s]`, 0 (anew in each frame) to 10: its correlation
    /// over `τ` is `exp(−τ/this)`.
    pub joint_noise_time: f64,
    /// Part of the frames that never arrive, `[-]`, 0 to 0.9.
    pub frame_loss: f64,
    /// How often a joint is lost and keeps its last place, `[1/s]` for each joint, 0 to 50.
    pub hold_rate: f64,
    /// How long on average, `[s]`, 0 to 10.
    pub hold_duration: f64,
    /// How often left and right are mistaken, `[1/s]` for each person, 0 to 50.
    pub swap_rate: f64,
    /// How long on average, `[s]`, 0 to 10.
    pub swap_duration: f64,
    /// Part of these mistakes that take the legs too, not only the arms, `[-]`, 0 to 1.
    pub whole_body_swaps: f64,
}

impl SensorConfig {
    /// Sees every joint where it is, at an even beat of `rate` `[Hz]`.
    pub fn ideal(rate: f64) -> Self {
        Self {
            rate,
            stamp_jitter: 0.0,
            // At the origin, as high as a table, looking along y: see `scene::draw`.
            position: Point::new(0.0, 0.0, 1.0),
            yaw: FRAC_PI_2,
            depth_noise: 0.0,
            depth_step: 0.0,
            angle_noise: 0.0,
            pixels: 1.0,
            joint_noise: 0.0,
            joint_noise_time: 0.0,
            frame_loss: 0.0,
            hold_rate: 0.0,
            hold_duration: 0.0,
            swap_rate: 0.0,
            swap_duration: 0.0,
            whole_body_swaps: 0.0,
        }
    }

    /// A Kinect of the first kind with NiTE, at `rate` `[Hz]` (30, or 15 on a busy machine).
    ///
    /// The camera's figures are measured ones. The tracker's are set so that bones scatter within
    /// a clip as they do in recordings made with it (upper arm and forearm by about 1 cm, thigh by
    /// less), and so that most clips have some fault but few have many.
    pub fn kinect(rate: f64) -> Self {
        Self {
            stamp_jitter: 0.002,
            depth_noise: 1.425e-3,
            depth_step: 2.85e-3,
            // Half a pixel at a focal length of 580 pixels.
            angle_noise: 0.5 / 580.0,
            pixels: 16.0,
            joint_noise: 0.005,
            joint_noise_time: 0.15,
            frame_loss: 0.02,
            hold_rate: 0.02,
            hold_duration: 0.12,
            swap_rate: 0.02,
            swap_duration: 0.12,
            whole_body_swaps: 0.3,
            ..Self::ideal(rate)
        }
    }

    /// Every figure with its range and meaning: the one place that knows them.
    pub fn figures(&mut self) -> Vec<Figure<'_>> {
        let figure =
            |key, value, low, high, unit, about| Figure { key, value, low, high, unit, about };
        let [x, y, z] = &mut self.position.coords.data.0[0];
        vec![
            figure("rate", &mut self.rate, 5.0, 120.0, "Hz", "Frames a second"),
            figure(
                "stamp_jitter",
                &mut self.stamp_jitter,
                0.0,
                0.05,
                "s",
                "Standard deviation of the instants of capture about an even beat",
            ),
            figure("position.x", x, -20.0, 20.0, "m", "Where the camera is in the world"),
            figure("position.y", y, -20.0, 20.0, "m", "Where the camera is in the world"),
            figure("position.z", z, -20.0, 20.0, "m", "Where the camera is in the world"),
            figure(
                "yaw",
                &mut self.yaw,
                -PI,
                PI,
                "rad",
                "Where it looks, level, from world x about z",
            ),
            figure(
                "depth_noise",
                &mut self.depth_noise,
                0.0,
                0.1,
                "1/m",
                "Standard deviation of the depth over its square",
            ),
            figure(
                "depth_step",
                &mut self.depth_step,
                0.0,
                0.1,
                "1/m",
                "Between two depths that can be told apart, over their square",
            ),
            figure(
                "angle_noise",
                &mut self.angle_noise,
                0.0,
                0.1,
                "rad",
                "Standard deviation of the direction to a pixel",
            ),
            figure(
                "pixels",
                &mut self.pixels,
                1.0,
                1000.0,
                "",
                "Pixels that a place is averaged over",
            ),
            figure(
                "joint_noise",
                &mut self.joint_noise,
                0.0,
                0.2,
                "m",
                "Standard deviation of an elbow or a knee in the body; hands twice, the trunk half",
            ),
            figure(
                "joint_noise_time",
                &mut self.joint_noise_time,
                0.0,
                10.0,
                "s",
                "How long that error lasts",
            ),
            figure(
                "frame_loss",
                &mut self.frame_loss,
                0.0,
                0.9,
                "",
                "Part of the frames that never arrive",
            ),
            figure(
                "hold_rate",
                &mut self.hold_rate,
                0.0,
                50.0,
                "1/s",
                "How often a joint is lost and keeps its last place",
            ),
            figure("hold_duration", &mut self.hold_duration, 0.0, 10.0, "s", "How long on average"),
            figure(
                "swap_rate",
                &mut self.swap_rate,
                0.0,
                50.0,
                "1/s",
                "How often left and right are mistaken",
            ),
            figure("swap_duration", &mut self.swap_duration, 0.0, 10.0, "s", "How long on average"),
            figure(
                "whole_body_swaps",
                &mut self.whole_body_swaps,
                0.0,
                1.0,
                "",
                "Part of these mistakes that take the legs too",
            ),
        ]
    }

    /// Whether every value is in its range.
    ///
    /// # Errors
    /// [`Violations`] names every one that is not.
    pub fn check(&self) -> Result<(), Violations> {
        let mut check = Check::default();
        for Figure { key, value, low, high, unit, .. } in self.clone().figures() {
            check.range(format!("sensor.{key}"), *value, low..=high, unit);
        }
        check.finish()
    }
}

/// One figure of a [`SensorConfig`], both ends of its range included.
#[derive(Debug)]
pub struct Figure<'a> {
    /// Its field's name, with dots for nested ones.
    pub key: &'static str,
    /// What it is.
    pub value: &'a mut f64,
    /// The least it may be.
    pub low: f64,
    /// The most it may be.
    pub high: f64,
    /// What it is counted in; empty for a plain number.
    pub unit: &'static str,
    /// What it means.
    pub about: &'static str,
}
