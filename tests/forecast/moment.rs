//! Where somebody is, how fast, and which way they face.

use handover_mesh::forecast::Moment;
use handover_mesh::{Sequence, Skeleton, Vector};
use proptest::prelude::*;

use crate::{STEP, elsewhere, moment, root, uniform, wandering};

/// The velocities seen in a past, by a window `[s]`.
fn velocities(past: &Sequence, window: f64) -> Vec<Vector> {
    let mut moment = Moment::new(past.skeleton(), root());
    moment.observe(past.skeleton(), past.frames(), window);
    moment.velocities().to_vec()
}

fn features(moment: &Moment) -> Vec<f64> {
    let mut features = vec![f64::NAN; Moment::feature_count(15)];
    moment.features(0.5, &mut features);
    features
}

proptest! {
    #[test]
    fn a_straight_line_has_its_velocity_whatever_the_stamps(
        gaps in prop::collection::vec(1_000_000..80_000_000_i64, 2..30), window in 0.001..3.0_f64,
    ) {
        let velocity = Vector::new(1.2, -0.7, 0.3);
        let mut stamp = 0;
        let stamps = gaps.iter().map(|gap| {
            stamp += gap;
            stamp
        });
        for seen in velocities(&uniform(velocity, stamps), window) {
            prop_assert!((seen - velocity).norm() < 1e-9, "{seen}");
        }
    }

    #[test]
    fn features_do_not_tell_where_the_scene_is_nor_how_it_is_turned(seed: u64, frame in 0..60_usize) {
        let motion = wandering(seed, 60);
        let moved = motion.transformed(&elsewhere(seed));
        let [a, b] = [&motion, &moved].map(|motion| features(&moment(motion, frame)));
        let off = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        prop_assert!(off < 1e-11, "{off}");
    }
}

#[test]
fn one_frame_stands_still_and_two_move() {
    let velocity = Vector::new(0.5, 0.0, -0.2);
    let motion = uniform(velocity, [0, STEP].into_iter());
    assert_eq!(moment(&motion, 0).velocities(), [Vector::zeros(); 15]);
    let moving = moment(&motion, 1);
    assert!(moving.velocities().iter().all(|seen| (seen - velocity).norm() < 1e-12));
    assert_eq!(moving.positions(), &*motion.frames()[1].positions);
    // What was seen before is forgotten.
    let mut again = moving.clone();
    again.observe(motion.skeleton(), &motion.frames()[..1], 0.1);
    assert_eq!(again, moment(&motion, 0));
}

#[test]
fn a_window_says_how_much_of_the_past_counts() {
    // Stands, then goes: seen through a short window it goes as fast as it does.
    let motion = wandering(3, 40);
    let (short, long, all) =
        (velocities(&motion, 0.02), velocities(&motion, 0.4), velocities(&motion, 100.0));
    let last = motion.frames()[39].positions[8] - motion.frames()[38].positions[8];
    assert!((short[8] - last / 0.02).norm() < 1e-9);
    assert!((long[8] - all[8]).norm() > 1e-3 && (short[8] - long[8]).norm() > 1e-3);
    // Shorter than a frame's period, it still takes the last two.
    assert_eq!(velocities(&motion, 0.001), short);
    // A stamp that jitters is not left out.
    assert_eq!(velocities(&motion, 0.0195), short);
    assert_eq!(velocities(&motion, 0.7), velocities(&motion, 0.78 - 0.08));
    // Longer than the past is all of it.
    assert_eq!(velocities(&motion, 0.78), all);
}

#[test]
fn a_moment_is_of_the_past_alone() {
    let (motion, other) = (wandering(1, 60), wandering(2, 60));
    for now in [0, 1, 7, 30] {
        let frames = (0..60).map(|k| if k <= now { &motion } else { &other }.frames()[k].clone());
        let mixed = Sequence::new(Skeleton::nite(), frames.collect()).unwrap();
        assert_eq!(moment(&mixed, now), moment(&motion, now));
    }
}

#[test]
fn features_are_those_written_down() {
    assert_eq!(Moment::feature_count(15), 3 * (14 + 15));
    assert_eq!(Moment::feature_count(8), 45);
    // Faces x already.
    let motion = uniform(Vector::new(0.4, 0.2, 0.0), (0..9).map(|k| k * STEP));
    let moment = moment(&motion, 8);
    let features = features(&moment);
    let (head, torso) = (moment.positions()[0], moment.positions()[2]);
    for axis in 0..3 {
        assert!((features[axis] - (head - torso)[axis]).abs() < 1e-12);
    }
    // Relative to the root nothing moves.
    assert!(features[42..84].iter().all(|velocity| velocity.abs() < 1e-12));
    let root_velocity = [0.2, 0.1, 0.0];
    assert!(features[84..].iter().zip(root_velocity).all(|(a, b)| (a - b).abs() < 1e-12));
}

#[test]
#[should_panic(expected = "left == right")]
fn features_of_another_length_are_the_callers_bug() {
    moment(&wandering(0, 9), 8).features(0.5, &mut [0.0; 3]);
}
