//! What each method says of motions whose future is known.

use handover_mesh::forecast::{ForecastMethod, ForecastSettings, Forecaster};
use handover_mesh::{Sequence, Vector};
use proptest::prelude::*;

use crate::{
    STEP, elsewhere, exact, fit, forecast, moment, swinging, truth, uniform, wandering, worst,
};

fn wanderers() -> Vec<Sequence> {
    (0..5).map(|seed| wandering(seed, 80)).collect()
}

/// How far a method is off at some frames `[m]`.
fn error(forecaster: &Forecaster, method: ForecastMethod, motion: &Sequence) -> f64 {
    let frames = [10, 20, 33, 41];
    let of = |frame: usize| {
        let said = forecast(forecaster, method, &moment(motion, frame));
        worst(&said, &truth(forecaster, motion, frame))
    };
    frames.map(of).into_iter().fold(0.0, f64::max)
}

#[test]
fn velocities_are_carried_on() {
    let forecaster = fit(&wanderers(), ForecastSettings::default()).unwrap();
    let velocity = Vector::new(0.9, -0.4, 0.1);
    let motion = uniform(velocity, (0..70).map(|k| k * STEP));
    let now = moment(&motion, 20);
    let zero = forecast(&forecaster, ForecastMethod::ZeroVelocity, &now);
    let poses = forecaster.horizons().iter().flat_map(|_| now.positions().to_vec());
    assert!(worst(&zero, &poses.collect::<Vec<_>>()) < 1e-15);
    assert!(error(&forecaster, ForecastMethod::ConstantVelocity, &motion) < 1e-9);
    // All joints move as the root does, so its damping is all there is.
    let damped = forecast(&forecaster, ForecastMethod::DampedVelocity, &now);
    for (row, horizon) in damped.chunks_exact(15).zip(forecaster.horizons()) {
        let moved = velocity * 0.3 * (1.0 - (-horizon / 0.3_f64).exp());
        let expected: Vec<_> = now.positions().iter().map(|place| place + moved).collect();
        assert!(worst(row, &expected) < 1e-9);
    }
}

#[test]
fn damped_velocity_lies_between_standing_and_going_on() {
    let damping = |time: f64| {
        let damping = ForecastSettings { joint_damping: time, root_damping: time, ..exact() };
        fit(&wanderers(), damping).unwrap()
    };
    let now = moment(&wandering(9, 40), 30);
    let said = |time, method| forecast(&damping(time), method, &now);
    let slow = said(1e6, ForecastMethod::DampedVelocity);
    assert!(worst(&slow, &said(1.0, ForecastMethod::ConstantVelocity)) < 1e-6);
    let quick = said(1e-6, ForecastMethod::DampedVelocity);
    assert!(worst(&quick, &said(1.0, ForecastMethod::ZeroVelocity)) < 1e-5);
    // The root's time is not the joints'.
    let settings = ForecastSettings { joint_damping: 1e6, root_damping: 1e-6, ..exact() };
    let forecaster = fit(&wanderers(), settings).unwrap();
    let said = forecast(&forecaster, ForecastMethod::DampedVelocity, &now);
    assert!((said[2] - now.positions()[2]).norm() < 1e-5, "the root stays");
    let relative = (now.velocities()[8] - now.velocities()[2]) * 0.1;
    assert!((said[8] - now.positions()[8] - relative).norm() < 1e-5);
}

#[test]
fn ridge_is_exact_where_the_future_is_linear_in_the_moment() {
    let motions: Vec<_> = (0..25).map(|seed| swinging(seed, 70)).collect();
    let forecaster = fit(&motions, exact()).unwrap();
    for seed in 100..105 {
        let motion = swinging(seed, 70).transformed(&elsewhere(seed));
        let off = error(&forecaster, ForecastMethod::Ridge, &motion);
        assert!(off < 1e-4, "{off}");
        let still = error(&forecaster, ForecastMethod::ZeroVelocity, &motion);
        assert!(still > 0.05, "{still}");
    }
}

#[test]
fn what_was_demonstrated_is_repeated() {
    // Everything twice, so that whatever is held out has been demonstrated elsewhere.
    let motions = [wanderers(), wanderers()].concat();
    let own = [ForecastMethod::Knn, ForecastMethod::Delaunay];
    let all = [own.as_slice(), &[ForecastMethod::KDelaunay, ForecastMethod::Mixed]].concat();
    let forecaster = fit(&motions, exact()).unwrap();
    for motion in &wanderers() {
        for &method in &all {
            let off = error(&forecaster, method, motion);
            let most = if own.contains(&method) { 1e-9 } else { 0.003 };
            assert!(off < most, "{}: {off}", method.name());
        }
    }
}

#[test]
fn smoothed_and_averaged_demonstrations_are_still_near() {
    let forecaster = fit(&wanderers(), ForecastSettings::default()).unwrap();
    for motion in &wanderers() {
        let still = error(&forecaster, ForecastMethod::ZeroVelocity, motion);
        for (method, part) in [(ForecastMethod::Knn, 0.3), (ForecastMethod::Delaunay, 0.9)] {
            let off = error(&forecaster, method, motion);
            assert!(off < part * still, "{}: {off} of {still}", method.name());
        }
    }
}

#[test]
fn every_forecast_moves_with_the_scene() {
    let forecaster = fit(&wanderers(), ForecastSettings::default()).unwrap();
    let elsewhere_learned = wanderers()
        .into_iter()
        .zip(70..)
        .map(|(motion, seed)| motion.transformed(&elsewhere(seed)));
    let elsewhere_learned =
        fit(&elsewhere_learned.collect::<Vec<_>>(), ForecastSettings::default()).unwrap();
    for seed in 20..26 {
        let (motion, change) = (wandering(seed, 50), elsewhere(seed));
        let moved = motion.transformed(&change);
        for frame in [0, 1, 6, 30, 49] {
            for method in ForecastMethod::ALL {
                let here = forecast(&forecaster, method, &moment(&motion, frame));
                let moved_said: Vec<_> = here.iter().map(|place| change * place).collect();
                let there = forecast(&forecaster, method, &moment(&moved, frame));
                let off = worst(&there, &moved_said);
                assert!(off < 1e-9, "{}, frame {frame}: {off}", method.name());
                // Nor does it matter where it was learned.
                let learned = forecast(&elsewhere_learned, method, &moment(&motion, frame));
                let off = worst(&learned, &here);
                assert!(off < 1e-6, "{}, frame {frame}: {off}", method.name());
            }
        }
    }
}

#[test]
fn a_used_workspace_says_what_a_new_one_does() {
    let forecaster = fit(&wanderers(), ForecastSettings::default()).unwrap();
    let mut used = forecaster.workspace();
    for seed in 30..36 {
        for frame in [4, 39, 17] {
            let now = moment(&wandering(seed, 40), frame);
            for method in ForecastMethod::ALL {
                let said = forecaster.forecast(method, &now, &mut used).to_vec();
                assert_eq!(said, forecast(&forecaster, method, &now), "{}", method.name());
            }
        }
    }
}

#[test]
fn the_same_motions_teach_the_same_and_their_numbers_are_only_names() {
    let motions = wanderers();
    let learn = |numbers: [u32; 5]| {
        let motions: Vec<_> = motions.iter().zip(numbers).collect();
        Forecaster::fit(&motions, crate::root(), ForecastSettings::default()).unwrap()
    };
    let once = learn([0, 1, 2, 3, 4]);
    assert_eq!(once, learn([0, 1, 2, 3, 4]));
    assert_eq!(once, learn([3, 10, 11, 500, u32::MAX]), "ascending as before");
    assert_ne!(once, learn([0, 0, 0, 1, 1]), "who is held out with whom does matter");
}

#[test]
fn the_order_of_the_motions_hardly_matters() {
    let motions: Vec<(Sequence, u32)> = wanderers().into_iter().zip(0..).collect();
    let learn = |order: &[usize]| {
        let motions: Vec<_> = order.iter().map(|at| (&motions[*at].0, motions[*at].1)).collect();
        Forecaster::fit(&motions, crate::root(), ForecastSettings::default()).unwrap()
    };
    let (one, other) = (learn(&[0, 1, 2, 3, 4]), learn(&[4, 2, 0, 3, 1]));
    for seed in 40..44 {
        let now = moment(&wandering(seed, 40), 30);
        for method in ForecastMethod::ALL {
            let off = worst(&forecast(&one, method, &now), &forecast(&other, method, &now));
            assert!(off < 1e-6, "{}: {off}", method.name());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn horizons_are_forecast_one_by_one(first in 0.02..0.3_f64, step in 0.02..0.3_f64) {
        // What is said over a horizon by what learns each by itself does not depend on the others.
        let settings = |horizons: Vec<f64>| ForecastSettings { horizons, ..exact() };
        let motions: Vec<_> = (0..3).map(|seed| wandering(seed, 60)).collect();
        let both = fit(&motions, settings(vec![first, first + step])).unwrap();
        let one = fit(&motions, settings(vec![first])).unwrap();
        let now = moment(&wandering(7, 30), 20);
        for method in [ForecastMethod::ConstantVelocity, ForecastMethod::Ridge, ForecastMethod::Knn] {
            let said = forecast(&both, method, &now);
            prop_assert!(worst(&said[..15], &forecast(&one, method, &now)) < 1e-9);
        }
    }
}
