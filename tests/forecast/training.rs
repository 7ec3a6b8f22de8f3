//! Training sets of every kind: each teaches, or is refused with what is wrong with it.

use std::sync::Arc;

use handover_mesh::forecast::{ForecastError, ForecastMethod, ForecastSettings, Forecaster};
use handover_mesh::{Frame, Point, Sequence, Skeleton, Stamp, Vector};

use crate::{
    STEP, exact, fit, forecast, moment, root, standing, swinging, uniform, wandering, worst,
};

#[track_caller]
fn check_teaches(motions: &[Sequence], settings: ForecastSettings) -> Forecaster {
    let forecaster = fit(motions, settings).unwrap();
    let now = moment(&wandering(77, 40), 30);
    for method in ForecastMethod::ALL {
        let said = forecast(&forecaster, method, &now);
        let far = said.iter().zip(now.positions().iter().cycle()).map(|(a, b)| (a - b).norm());
        assert!(far.clone().all(|d| d < 3.0), "{}: {:?}", method.name(), far.collect::<Vec<_>>());
    }
    forecaster
}

#[track_caller]
fn check_refused(motions: &[Sequence], settings: ForecastSettings, words: &[&str]) {
    let error = fit(motions, settings).unwrap_err().to_string();
    for word in words {
        assert!(error.contains(word), "no '{word}' in: {error}");
    }
}

fn still(frames: i64) -> Sequence {
    uniform(Vector::zeros(), (0..frames).map(|k| k * STEP))
}

#[test]
fn nothing_to_learn_from_is_said() {
    check_refused(&[], exact(), &["no motion long enough", "0.2 s"]);
    let short: Vec<_> = [1, 2, 6].map(|frames| wandering(1, frames)).into();
    check_refused(&short, exact(), &["no motion long enough", "none lasts 0.2 s"]);
    let longer = ForecastSettings { velocity_window: 9.0, ..exact() };
    check_refused(&[wandering(1, 80)], longer, &["none lasts 9.1 s"]);
    let nothing_ahead = ForecastSettings { horizons: vec![], ..exact() };
    assert!(fit(&[wandering(1, 80)], nothing_ahead).is_err());
}

#[test]
fn one_recording_has_nobody_to_be_held_out_from() {
    let motion = wandering(5, 80);
    let forecaster = check_teaches(std::slice::from_ref(&motion), exact());
    let now = moment(&motion, 30);
    let [mixed, nearest] = [ForecastMethod::Mixed, ForecastMethod::Knn]
        .map(|method| forecast(&forecaster, method, &now));
    assert!(worst(&mixed, &nearest) < 1e-12, "the nearest are taken at their word");
    // Two motions of one recording are no more than one.
    let both = [(&motion, 7), (&motion, 7)];
    Forecaster::fit(&both, root(), exact()).unwrap();
}

#[test]
fn short_motions_teach_as_far_as_they_reach() {
    // The longest horizon is 0.5 s; these last 0.38 s.
    let short: Vec<_> = (0..6).map(|seed| wandering(seed, 20)).collect();
    let forecaster = check_teaches(&short, exact());
    let now = moment(&short[0], 15);
    for method in [ForecastMethod::Knn, ForecastMethod::Delaunay, ForecastMethod::Mixed] {
        let said = forecast(&forecaster, method, &now);
        assert!(worst(&said[30..45], &said[45..]) < 0.3, "{}: over 0.5 s as before", method.name());
    }
    // Among longer ones, some that reach nothing or have no past.
    let mut motions: Vec<_> = (0..4).map(|seed| wandering(seed, 70)).collect();
    motions.extend([1, 2, 6, 8, 12].map(|frames| wandering(9, frames)));
    check_teaches(&motions, ForecastSettings::default());
}

#[test]
fn one_long_motion_among_short_ones_teaches() {
    // Whatever it is held out from teaches nothing: none of them reaches a horizon.
    let mut motions = vec![wandering(0, 80)];
    motions.extend((1..5).map(|seed| wandering(seed, 8)));
    for at in 0..motions.len() {
        check_teaches(&motions, ForecastSettings::default());
        if at + 1 < motions.len() {
            motions.swap(at, at + 1);
        }
    }
}

#[test]
fn people_who_never_move_are_refused() {
    for settings in [exact(), ForecastSettings::default()] {
        check_refused(
            &[still(60)],
            settings.clone(),
            &["spans 0", "more, and more different motions"],
        );
        check_refused(&[still(60), still(50)], settings, &["more, and more different motions"]);
    }
    // Among others they are as good as any.
    check_teaches(&[still(60), wandering(0, 60), still(50), wandering(1, 60)], exact());
}

#[test]
fn motions_that_span_too_little_are_refused_or_taken_for_what_they_are() {
    // Everybody at one velocity: one moment, again and again.
    let line = |speed: f64| uniform(Vector::new(speed, 0.0, 0.0), (0..60).map(|k| k * STEP));
    check_refused(&[line(0.5)], exact(), &["more, and more different motions"]);
    // Two or three velocities along a line: one dimension, simplices take two.
    let lines = [line(0.5), line(0.6), line(0.9)];
    check_refused(&lines, exact(), &["spans 1", "more, and more different motions"]);
    // In a plane: triangles where tetrahedra were asked for.
    let plane = |x: f64, y: f64| uniform(Vector::new(x, y, 0.0), (0..40).map(|k| k * STEP));
    let planes: Vec<_> =
        [[0.5, 0.0], [0.1, 0.7], [-0.4, 0.2], [0.3, -0.3]].map(|[x, y]| plane(x, y)).into();
    for simplex_dimensions in [2, 3, 4] {
        check_teaches(&planes, ForecastSettings { simplex_dimensions, ..exact() });
    }
}

#[test]
fn few_moments_are_refused_or_taken_for_what_they_are() {
    // From one moment on, one more with each frame.
    for frames in 6..30 {
        for simplex_dimensions in [2, 3, 4] {
            let motions = [wandering(1, frames)];
            let settings = ForecastSettings {
                simplex_dimensions,
                neighbours: 1000,
                averaged: 1000,
                dimensions: 1000,
                ..ForecastSettings::default()
            };
            match fit(&motions, settings.clone()) {
                Ok(_) => {
                    assert!(frames > 12, "{frames}");
                    check_teaches(&motions, settings);
                }
                Err(error) => {
                    assert!(frames < 14, "{frames}: {error}");
                    let error = error.to_string();
                    let known = ["long enough", "more, and more different motions"];
                    assert!(known.iter().any(|word| error.contains(word)), "{frames}: {error}");
                }
            }
        }
    }
}

#[test]
fn other_joints_are_named() {
    let skeleton = Arc::new(
        Skeleton::from_names(["neck", "torso", "left_hand"].map(str::to_owned).to_vec()).unwrap(),
    );
    let frames = (0..40).map(|k| Frame {
        stamp: Stamp(k * STEP),
        positions: vec![Point::new(0.0, 0.0, k as f64 * 0.01); 3].into(),
    });
    let other = Sequence::new(skeleton, frames.collect()).unwrap();
    let motions = [swinging(0, 40), swinging(1, 40), other];
    let error = fit(&motions, exact()).unwrap_err();
    assert_eq!(error, ForecastError::Skeleton { motion: 2 });
    assert_eq!(error.to_string(), "motion 2 has other joints than the first one");
}

#[test]
#[should_panic(expected = "left == right")]
fn a_moment_of_another_root_is_the_callers_bug() {
    let forecaster = fit(&[wandering(0, 60)], exact()).unwrap();
    let skeleton = Skeleton::nite();
    let mut moment =
        handover_mesh::forecast::Moment::new(&skeleton, skeleton.joint("neck").unwrap());
    moment.observe(&skeleton, wandering(0, 60).frames(), 0.1);
    forecast(&forecaster, ForecastMethod::Ridge, &moment);
}

#[test]
fn repeated_moments_are_no_obstacle() {
    // Half of each motion stands still: the same moment, many times over.
    let stopping = |seed: u64| {
        let motion = wandering(seed, 60);
        let frames = (0..120).map(|k: i64| Frame {
            stamp: Stamp(k * STEP),
            positions: motion.frames()[k.min(59) as usize].positions.clone(),
        });
        Sequence::new(Skeleton::nite(), frames.collect()).unwrap()
    };
    let motions: Vec<_> = (0..4).map(stopping).collect();
    let forecaster = check_teaches(&motions, ForecastSettings::default());
    // Who has stood still for long goes on to.
    let now = moment(&motions[0], 110);
    for method in [ForecastMethod::Knn, ForecastMethod::Delaunay] {
        let said = forecast(&forecaster, method, &now);
        let off = worst(&said[..15], now.positions());
        assert!(off < 0.02, "{}: {off}", method.name());
    }
    assert_eq!(standing::STANDING.len(), 15);
}

#[test]
fn settings_out_of_bounds_are_named() {
    let motions = [wandering(1, 60), wandering(2, 60)];
    let named: Vec<_> = motions.iter().zip(0..).collect();
    let check = |settings: ForecastSettings, part: &str| {
        let error = Forecaster::fit(&named, root(), settings).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    };
    let usual = ForecastSettings::default;
    check(
        ForecastSettings { averaged: 0, ..usual() },
        "averaged is 0, must be a whole number from 1",
    );
    check(ForecastSettings { velocity_weight: 0.0, ..usual() }, "velocity_weight is 0.0");
    check(ForecastSettings { root_damping: f64::NAN, ..usual() }, "root_damping is NaN");
    check(
        ForecastSettings { simplex_dimensions: 5, ..usual() },
        "simplex_dimensions is 5, must be 2",
    );
    for horizons in [vec![], vec![0.2, 0.1], vec![0.0, 0.1], vec![0.1, f64::INFINITY]] {
        check(ForecastSettings { horizons, ..usual() }, "must be some seconds ahead, rising");
    }
}
