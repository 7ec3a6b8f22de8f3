//! Which poses count at a place, and how much.

use std::collections::BTreeSet;

use handover_mesh::motion::{MotionModel, Neighbourhood, Rows};
use proptest::prelude::*;

use crate::{distance, model, numbers, walks};

const K: usize = 5;

fn poses(model: &MotionModel, place: &[f64]) -> BTreeSet<u32> {
    let mut around = model.around();
    model.find(place, &mut around);
    let poses: BTreeSet<u32> = around.neighbours().iter().map(|n| n.pose).collect();
    assert_eq!(poses.len(), around.neighbours().len(), "each once");
    poses
}

/// Weights `1/D²` that sum to 1; returns whether the place is outside the hull.
#[track_caller]
fn check_weights(model: &MotionModel, place: &[f64]) -> bool {
    let mut around = model.around();
    model.find(place, &mut around);
    let neighbours = around.neighbours();
    let square = |pose: u32| distance(model.points().row(pose as usize), place).powi(2).max(1e-300);
    let total: f64 = neighbours.iter().map(|n| 1.0 / square(n.pose)).sum();
    for neighbour in neighbours {
        let expected = 1.0 / square(neighbour.pose) / total;
        assert!((neighbour.weight - expected).abs() < 1e-9, "{neighbour:?} {expected}");
    }
    assert!((neighbours.iter().map(|n| n.weight).sum::<f64>() - 1.0).abs() < 1e-12);
    around.is_outside()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn weights_are_inverse_squares_and_the_union_is_of_both(seed in 0..10_000_u64) {
        let sequences = walks(seed, &[20, 1, 15]);
        let [knn, delaunay, both] = Neighbourhood::ALL.map(|n| model(&sequences, n, K));
        let reach = 1.3 * knn.points().values().iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        for place in numbers(seed, 60).chunks_exact(2) {
            let place: Vec<f64> = place.iter().map(|value| value * reach).collect();
            prop_assert!(!check_weights(&knn, &place), "there is no hull");
            let outside = check_weights(&delaunay, &place);
            prop_assert_eq!(check_weights(&both, &place), outside);
            let [near, corners, union] = [&knn, &delaunay, &both].map(|m| poses(m, &place));
            prop_assert_eq!(near.len(), K);
            if outside {
                prop_assert_eq!(&corners, &near, "the nearest stand in");
            } else {
                prop_assert_eq!(corners.len(), 3);
            }
            prop_assert_eq!(union, &near | &corners);
        }
    }

    #[test]
    fn a_place_where_a_pose_is_gets_that_pose(seed in 0..10_000_u64) {
        let sequences = walks(seed, &[20, 15]);
        for neighbourhood in Neighbourhood::ALL {
            let model = model(&sequences, neighbourhood, K);
            let mut around = model.around();
            for (pose, place) in model.points().iter().enumerate() {
                model.find(place, &mut around);
                prop_assert!(!around.is_outside(), "{}: {} is a corner", neighbourhood.name(), pose);
                let of = |n: &handover_mesh::motion::Neighbour| n.pose as usize == pose;
                prop_assert_eq!(around.neighbours().iter().find(|n| of(n)).unwrap().weight, 1.0);
                let mut velocity = [f64::NAN; 2];
                model.velocity(place, &mut around, &mut velocity);
                prop_assert_eq!(&velocity, model.velocities().row(pose));
            }
        }
    }

    #[test]
    fn equal_poses_share(seed in 0..10_000_u64, copy in 0..20_usize) {
        let first = walks(seed, &[20]).remove(0);
        let again = Rows::new(4, first.values()[4 * copy..].repeat(2)).unwrap();
        let length = first.len() - copy;
        for neighbourhood in Neighbourhood::ALL {
            let model = model(&[first.clone(), again.clone()], neighbourhood, K);
            let mut around = model.around();
            model.find(model.points().row(copy), &mut around);
            let full: Vec<(usize, f64)> = around.neighbours().iter()
                .filter(|n| n.weight > 1e-6).map(|n| (n.pose as usize, n.weight)).collect();
            let mut poses: Vec<usize> = full.iter().map(|(pose, _)| *pose).collect();
            poses.sort_unstable();
            prop_assert_eq!(poses, vec![copy, 20, 20 + length], "{}", neighbourhood.name());
            prop_assert!(full.iter().all(|(_, weight)| (weight - 1.0 / 3.0).abs() < 1e-12));
        }
    }
}

#[test]
fn a_place_that_is_nowhere_has_no_neighbours_and_harms_no_later_search() {
    let sequences = walks(3, &[30]);
    for neighbourhood in Neighbourhood::ALL {
        let model = model(&sequences, neighbourhood, K);
        let mut around = model.around();
        for place in [[f64::NAN, 0.0], [0.0, f64::NEG_INFINITY]] {
            let mut velocity = [f64::NAN; 2];
            model.velocity(&place, &mut around, &mut velocity);
            assert!(around.neighbours().is_empty() && velocity == [0.0; 2]);
        }
        model.find(&[1e200, -1e250], &mut around);
        let far: f64 = around.neighbours().iter().map(|n| n.weight).sum();
        assert!((far - 1.0).abs() < 1e-12, "{far}");
        model.find(&[0.0, 0.0], &mut around);
        let mut fresh = model.around();
        model.find(&[0.0, 0.0], &mut fresh);
        assert_eq!(around.neighbours(), fresh.neighbours());
    }
}

/// What one model kept is of no use to another, and no harm.
#[test]
fn searches_may_be_kept_from_model_to_model() {
    let [large, small] = [50, 6].map(|length| walks(4, &[length]));
    let [large, small] = [large, small].map(|s| model(&s, Neighbourhood::Delaunay, K));
    let mut around = large.around();
    for place in large.points().iter() {
        large.find(place, &mut around);
        small.find(small.points().row(2), &mut around);
        let full = around.neighbours().iter().find(|n| n.weight == 1.0).unwrap();
        assert_eq!(full.pose, 2);
    }
}

#[test]
fn more_neighbours_than_poses_are_all_poses() {
    let model = model(&walks(5, &[9]), Neighbourhood::Knn, usize::MAX);
    assert_eq!(poses(&model, &[0.0, 0.0]).len(), 9);
    assert!(model.graph().edge_count() >= 8);
}
