//! Poses, their latent space, its neighbours, graph and field: against definitions computed slowly
//! and apart from the library's own code.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

mod complex;
mod cross_validation;
mod errors;
mod exact;
mod field;
mod graph;
mod locate;
mod nearest;
mod neighbourhood;
mod paths;
mod pca;

use handover_mesh::motion::{Dimensions, MotionModel, MotionSettings, Neighbourhood, Rows};
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Numbers from −1 to 1, the same for the same seed.
fn numbers(seed: u64, count: usize) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..count).map(|_| rng.random_range(-1.0..1.0)).collect()
}

fn random(seed: u64, count: usize, width: usize) -> Rows {
    Rows::new(width, numbers(seed, count * width)).unwrap()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// All numbers times a power of two, so that nothing rounds.
fn scaled(rows: &Rows, exponent: i32) -> Rows {
    let values = rows.values().iter().map(|value| value * 2_f64.powi(exponent));
    Rows::new(rows.width(), values.collect()).unwrap()
}

/// Random walks of these lengths: poses of four channels.
fn walks(seed: u64, lengths: &[usize]) -> Vec<Rows> {
    let walk = |(at, &length): (usize, &usize)| {
        let mut place = numbers(1000 * seed + at as u64, 4);
        let steps = random(1000 * seed + 500 + at as u64, length, 4);
        let poses = steps.iter().flat_map(|step| {
            place.iter_mut().zip(step).for_each(|(x, step)| *x += 0.4 * step);
            place.clone()
        });
        Rows::new(4, poses.collect()).unwrap()
    };
    lengths.iter().enumerate().map(walk).collect()
}

/// A model of two latent dimensions.
fn model(sequences: &[Rows], neighbourhood: Neighbourhood, k: usize) -> MotionModel {
    let settings = MotionSettings { dimensions: Dimensions::Count(2), neighbourhood, k };
    MotionModel::fit(sequences, settings).unwrap()
}

/// Every pose's sequence.
fn owners(model: &MotionModel) -> Vec<usize> {
    let of = |(at, range): (usize, &std::ops::Range<usize>)| vec![at; range.len()];
    model.sequences().iter().enumerate().flat_map(of).collect()
}
