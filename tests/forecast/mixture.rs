//! The mixed method beside those it mixes.

use handover_mesh::forecast::{ForecastMethod, ForecastSettings, Forecaster};
use handover_mesh::{Frame, Point, Sequence, Vector};
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::{exact, fit, forecast, moment, swinging, truth, wandering};

const MIXED: [ForecastMethod; 4] = [
    ForecastMethod::ConstantVelocity,
    ForecastMethod::Ridge,
    ForecastMethod::Knn,
    ForecastMethod::Delaunay,
];

/// The root mean square distance over all joints `[m]`, per horizon.
fn errors(forecaster: &Forecaster, method: ForecastMethod, motions: &[Sequence]) -> Vec<f64> {
    let mut sums = vec![0.0; forecaster.horizons().len()];
    let mut count = 0.0;
    for motion in motions {
        for frame in (8..motion.len() - 25).step_by(3) {
            let said = forecast(forecaster, method, &moment(motion, frame));
            let truth = truth(forecaster, motion, frame);
            let rows = said.chunks_exact(15).zip(truth.chunks_exact(15));
            for (sum, (said, truth)) in sums.iter_mut().zip(rows) {
                *sum += said.iter().zip(truth).map(|(a, b)| (a - b).norm_squared()).sum::<f64>();
            }
            count += 15.0;
        }
    }
    sums.iter().map(|sum| (sum / count).sqrt()).collect()
}

/// The motion as a camera sees it.
fn noisy(motion: &Sequence, seed: u64, size: f64) -> Sequence {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let frames = motion.frames().iter().map(|frame| {
        let mut off =
            |place: &Point| place + Vector::from_fn(|_, _| random.random_range(-size..size));
        Frame { stamp: frame.stamp, positions: frame.positions.iter().map(&mut off).collect() }
    });
    Sequence::new(motion.skeleton().clone(), frames.collect()).unwrap()
}

#[track_caller]
fn check_as_good_as_the_best(
    learned: &[Sequence],
    held_out: &[Sequence],
    settings: ForecastSettings,
) {
    let forecaster = fit(learned, settings).unwrap();
    let mixed = errors(&forecaster, ForecastMethod::Mixed, held_out);
    let single = MIXED.map(|method| errors(&forecaster, method, held_out));
    for (horizon, mixed) in mixed.into_iter().enumerate() {
        let best = single.iter().map(|errors| errors[horizon]).fold(f64::INFINITY, f64::min);
        assert!(mixed < 1.05 * best + 1e-4, "horizon {horizon}: {mixed}, the best alone {best}");
    }
}

#[test]
fn mixed_is_as_good_as_the_best_it_mixes() {
    let set = |seeds: std::ops::Range<u64>, make: fn(u64, i64) -> Sequence, noise: f64| {
        seeds.map(|seed| noisy(&make(seed, 80), seed, noise)).collect::<Vec<_>>()
    };
    for noise in [0.002, 0.02] {
        let settings = ForecastSettings::default();
        let (learned, held_out) = (set(0..9, swinging, noise), set(50..54, swinging, noise));
        check_as_good_as_the_best(&learned, &held_out, settings.clone());
        let (learned, held_out) = (set(0..9, wandering, noise), set(50..54, wandering, noise));
        check_as_good_as_the_best(&learned, &held_out, settings);
    }
}

#[test]
fn who_is_right_is_believed() {
    // Ridge is exact here, as the future is linear in the moment.
    let set =
        |seeds: std::ops::Range<u64>| seeds.map(|seed| swinging(seed, 70)).collect::<Vec<_>>();
    let forecaster = fit(&set(0..25), exact()).unwrap();
    let held_out = set(200..203);
    let mixed = errors(&forecaster, ForecastMethod::Mixed, &held_out);
    let still = errors(&forecaster, ForecastMethod::ZeroVelocity, &held_out);
    for (mixed, still) in mixed.iter().zip(still) {
        assert!(*mixed < 0.02 * still, "{mixed} of {still}");
    }
}

#[test]
fn one_lost_frame_does_not_spoil_the_trust() {
    // A joint jumps away for a frame: velocities carried on from there are far off, and what the
    // others say must still count.
    let mut motions: Vec<_> = (0..25).map(|seed| swinging(seed, 70)).collect();
    let clean = fit(&motions, exact()).unwrap();
    let mut frames = motions[0].frames().to_vec();
    frames[40].positions[8].x += 2.0;
    motions[0] = Sequence::new(motions[0].skeleton().clone(), frames).unwrap();
    let spoilt = fit(&motions, exact()).unwrap();
    let held_out: Vec<_> = (200..203).map(|seed| swinging(seed, 70)).collect();
    let [clean, spoilt] =
        [&clean, &spoilt].map(|forecaster| errors(forecaster, ForecastMethod::Mixed, &held_out));
    let still = errors(&fit(&motions, exact()).unwrap(), ForecastMethod::ZeroVelocity, &held_out);
    for ((clean, spoilt), still) in clean.iter().zip(&spoilt).zip(still) {
        assert!(spoilt < &(0.5 * still), "{spoilt}, without the lost frame {clean}, of {still}");
    }
}
