//! Forecasts: moments, methods, training sets of every kind, and hostile pasts.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

mod hostile;
mod methods;
mod mixture;
mod moment;
#[path = "../common/standing.rs"]
mod standing;
mod training;

use std::f64::consts::TAU;

use handover_mesh::forecast::{
    ForecastError, ForecastMethod, ForecastSettings, Forecaster, Moment,
};
use handover_mesh::geometry::yaw_isometry;
use handover_mesh::{Frame, Isometry, JointId, Point, Sequence, Skeleton, Stamp, Vector};
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Frames of 20 ms: every horizon by default is a whole number of them.
const STEP: i64 = 20_000_000;

fn root() -> JointId {
    Skeleton::nite().root()
}

/// Somebody who drifts along while head and hands swing about their places, all at one speed: where
/// they are later is a linear function of where they are and how fast.
///
/// - `seed`: how fast they drift, and how far each joint swings.
fn swinging(seed: u64, frames: i64) -> Sequence {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut vector = |size: f64| Vector::from_fn(|_, _| random.random_range(-1.0..1.0)) * size;
    let drift = vector(0.4);
    let swings: Vec<[Vector; 2]> = (0..15)
        .map(|joint| match joint {
            0 | 5 | 7 | 8 => [vector(0.15), vector(0.15)],
            _ => [Vector::zeros(); 2],
        })
        .collect();
    let frame = |k: i64| {
        let time = k as f64 * 0.02;
        let (sin, cos) = (TAU * 0.8 * time).sin_cos();
        let place = |(place, [a, b]): (&[f64; 3], &[Vector; 2])| {
            Point::from(*place) + drift * time + a * sin + b * cos
        };
        let positions = standing::STANDING.iter().zip(&swings).map(place).collect();
        Frame { stamp: Stamp(k * STEP), positions }
    };
    Sequence::new(Skeleton::nite(), (0..frames).map(frame).collect()).unwrap()
}

/// A motion whose joints all move differently, never twice the same; the hips turn.
fn wandering(seed: u64, frames: i64) -> Sequence {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut number = |least: f64, most: f64| random.random_range(least..most);
    let swings: Vec<[f64; 7]> = (0..15)
        .map(|_| {
            let [x, y, z] = [(); 3].map(|()| number(0.0, TAU));
            let [slow, fast] = [number(0.2, 0.5), number(0.9, 1.4)];
            [x, y, z, slow, fast, number(0.05, 0.15), number(0.01, 0.03)]
        })
        .collect();
    let frame = |k: i64| {
        let time = k as f64 * 0.02;
        let place = |(place, [x, y, z, slow, fast, wide, narrow]): (&[f64; 3], &[f64; 7])| {
            let off = |phase: f64| {
                wide * (TAU * slow * time + phase).sin()
                    + narrow * (TAU * fast * time + phase).cos()
            };
            Point::from(*place) + Vector::new(off(*x), off(*y), off(*z))
        };
        let positions = standing::STANDING.iter().zip(&swings).map(place).collect();
        Frame { stamp: Stamp(k * STEP), positions }
    };
    Sequence::new(Skeleton::nite(), (0..frames).map(frame).collect()).unwrap()
}

/// Every joint of [`standing::STANDING`] at one velocity `[m/s]`.
fn uniform(velocity: Vector, stamps: impl Iterator<Item = i64>) -> Sequence {
    let frame = |stamp: i64| {
        let moved = velocity * (stamp as f64 / 1e9);
        let positions = standing::STANDING.iter().map(|p| Point::from(*p) + moved).collect();
        Frame { stamp: Stamp(stamp), positions }
    };
    Sequence::new(Skeleton::nite(), stamps.map(frame).collect()).unwrap()
}

/// Motions as they are recorded, nothing averaged.
fn exact() -> ForecastSettings {
    ForecastSettings {
        smoothing: 0.0,
        ridge_penalty: 1e-9,
        averaged: 1,
        ..ForecastSettings::default()
    }
}

/// Learned from motions, each a group of its own.
fn fit(motions: &[Sequence], settings: ForecastSettings) -> Result<Forecaster, ForecastError> {
    let motions: Vec<(&Sequence, u32)> = motions.iter().zip(0..).collect();
    Forecaster::fit(&motions, root(), settings)
}

/// The moment at a frame, by the past alone.
fn moment(motion: &Sequence, frame: usize) -> Moment {
    let mut moment = Moment::new(motion.skeleton(), root());
    moment.observe(motion.skeleton(), &motion.frames()[..=frame], 0.1);
    moment
}

fn forecast(forecaster: &Forecaster, method: ForecastMethod, moment: &Moment) -> Vec<Point> {
    forecaster.forecast(method, moment, &mut forecaster.workspace()).to_vec()
}

/// The joints at each horizon after a frame.
fn truth(forecaster: &Forecaster, motion: &Sequence, frame: usize) -> Vec<Point> {
    let then = |horizon: &f64| {
        let frames = (horizon * 1e9).round() as usize / STEP as usize;
        motion.frames()[frame + frames].positions.to_vec()
    };
    forecaster.horizons().iter().flat_map(then).collect()
}

/// The greatest distance between two lists of points `[m]`.
fn worst(a: &[Point], b: &[Point]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).norm())
        .fold(0.0, |most, d| if d > most { d } else { most })
}

/// Elsewhere, and turned about the vertical.
fn elsewhere(seed: u64) -> Isometry {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut number = |size: f64| random.random_range(-size..size);
    yaw_isometry(number(3.0), Vector::new(number(5.0), number(5.0), number(1.0)))
}
