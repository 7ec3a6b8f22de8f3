//! The latent space against the eigenvectors of the covariance, and what moving poses must keep.

use handover_mesh::motion::{Dimensions, LARGEST, MotionError, Pca, Rows};
use nalgebra::DMatrix;
use proptest::prelude::*;

use crate::{distance, numbers, random, scaled};

/// Poses that vary ever less from channel to channel, mixed.
fn poses(seed: u64, count: usize, channels: usize) -> Rows {
    let free = random(seed, count, channels);
    let mix = numbers(seed + 1, channels * channels);
    let mixed = |pose: &[f64], to: usize| -> f64 {
        let parts = pose.iter().enumerate();
        parts.map(|(from, x)| x * 0.6_f64.powi(from as i32) * mix[channels * from + to]).sum()
    };
    let values = free.iter().flat_map(|pose| (0..channels).map(move |to| mixed(pose, to)));
    Rows::new(channels, values.map(|value| value + 3.0).collect()).unwrap()
}

fn fit(poses: &Rows, dimensions: usize) -> Pca {
    Pca::fit(poses, Dimensions::Count(dimensions)).unwrap()
}

/// Each latent unit vector's pose, from the origin's.
fn directions(pca: &Pca) -> Vec<Vec<f64>> {
    let back = |point: Vec<f64>| pca.reproject(&Rows::new(pca.dimensions(), point).unwrap());
    let origin = back(vec![0.0; pca.dimensions()]);
    let unit = |k| (0..pca.dimensions()).map(|i| if i == k { 1.0 } else { 0.0 }).collect();
    let along = |k| -> Vec<f64> {
        back(unit(k)).row(0).iter().zip(origin.row(0)).map(|(x, mean)| x - mean).collect()
    };
    (0..pca.dimensions()).map(along).collect()
}

fn largest_difference(a: &Rows, b: &Rows) -> f64 {
    a.values().iter().zip(b.values()).fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn at_full_rank_poses_come_back(seed: u64, count in 8..40_usize, channels in 1..7_usize) {
        let poses = poses(seed, count, channels);
        let pca = fit(&poses, channels);
        let back = pca.reproject(&pca.project(&poses));
        prop_assert!(largest_difference(&back, &poses) < 1e-12 * 6.0);
    }

    #[test]
    fn directions_are_orthonormal_and_shares_fall_to_a_sum_of_one(
        seed: u64, count in 8..40_usize, channels in 2..7_usize,
    ) {
        let pca = fit(&poses(seed, count, channels), channels - 1);
        let directions = directions(&pca);
        for (i, a) in directions.iter().enumerate() {
            for (j, b) in directions.iter().enumerate() {
                let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                prop_assert!((dot - if i == j { 1.0 } else { 0.0 }).abs() < 1e-12, "{} {} {}", i, j, dot);
            }
            let largest = a.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()));
            prop_assert!(largest.unwrap() > 0.0, "the sign is that of the largest component");
        }
        let shares = pca.explained();
        prop_assert_eq!(shares.len(), channels);
        prop_assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        prop_assert!(shares.windows(2).all(|pair| pair[0] >= pair[1]));
    }

    #[test]
    fn directions_are_eigenvectors_of_the_covariance(seed: u64, count in 12..40_usize) {
        let poses = poses(seed, count, 4);
        let pca = fit(&poses, 4);
        let mut centred = DMatrix::from_row_slice(count, 4, poses.values());
        for mut column in centred.column_iter_mut() {
            let mean = column.mean();
            column.add_scalar_mut(-mean);
        }
        let eigen = (centred.transpose() * &centred / count as f64).symmetric_eigen();
        let mut order: Vec<usize> = (0..4).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let total = eigen.eigenvalues.sum();
        for ((&at, share), direction) in order.iter().zip(pca.explained()).zip(directions(&pca)) {
            prop_assert!((eigen.eigenvalues[at] / total - share).abs() < 1e-12);
            // A direction is as sharp as its variance is apart from the others.
            let gap = order.iter().filter(|other| **other != at);
            let gap = gap.map(|other| (eigen.eigenvalues[*other] - eigen.eigenvalues[at]).abs());
            let gap = gap.fold(f64::INFINITY, f64::min);
            let cosine: f64 = eigen.eigenvectors.column(at).iter().zip(&direction).map(|(a, b)| a * b).sum();
            prop_assert!((cosine.abs() - 1.0).abs() < 1e-12 * total / gap, "{} {}", cosine, gap);
        }
    }

    #[test]
    fn moved_and_turned_poses_are_as_far_apart(seed: u64, turn in 0.0..6.0, shift in -50.0..50.0) {
        let poses = poses(seed, 20, 3);
        let (sin, cos) = f64::sin_cos(turn);
        let moved = poses.iter().flat_map(|p| {
            [cos * p[0] - sin * p[2] + shift, p[1] - shift, sin * p[0] + cos * p[2]]
        });
        let moved = Rows::new(3, moved.collect()).unwrap();
        let [here, there] = [&poses, &moved].map(|poses| fit(poses, 2).project(poses));
        for i in 0..20 {
            for j in 0..i {
                let [a, b] = [&here, &there].map(|points| distance(points.row(i), points.row(j)));
                prop_assert!((a - b).abs() < 1e-9, "{} {}", a, b);
            }
        }
    }

    #[test]
    fn a_share_takes_the_fewest_dimensions(seed: u64, share in 0.01..1.0) {
        let poses = poses(seed, 30, 6);
        let pca = Pca::fit(&poses, Dimensions::Share(share)).unwrap();
        let explains = |first: usize| pca.explained()[..first].iter().sum::<f64>();
        prop_assert!(explains(pca.dimensions()) >= share - 1e-9);
        prop_assert!(pca.dimensions() == 1 || explains(pca.dimensions() - 1) < share + 1e-9);
    }

    #[test]
    fn one_pose_is_projected_as_all_are(seed: u64) {
        let poses = poses(seed, 9, 5);
        let pca = fit(&poses, 3);
        prop_assert_eq!(&fit(&poses, 3), &pca, "the same again");
        let points = pca.project(&poses);
        let back = pca.reproject(&points);
        let (mut point, mut pose) = ([f64::NAN; 3], [f64::NAN; 5]);
        for row in 0..poses.len() {
            pca.project_pose(poses.row(row), &mut point);
            prop_assert_eq!(&point[..], points.row(row));
            pca.reproject_point(&point, &mut pose);
            prop_assert_eq!(&pose[..], back.row(row));
        }
    }
}

#[test]
fn all_of_the_variance_takes_as_many_dimensions_as_there_are() {
    let pca = Pca::fit(&poses(5, 30, 6), Dimensions::Share(1.0)).unwrap();
    assert_eq!(pca.dimensions(), 6);
    for share in [0.0, -1.0, 1.5, f64::NAN] {
        let error = Pca::fit(&poses(5, 9, 2), Dimensions::Share(share)).unwrap_err();
        assert!(matches!(error, MotionError::Share { .. }), "{error}");
    }
}

#[track_caller]
fn check_rank(poses: &Rows, dimensions: usize, rank: usize) {
    let error = Pca::fit(poses, Dimensions::Count(dimensions)).unwrap_err();
    assert_eq!(error, MotionError::Rank { dimensions, poses: poses.len(), rank });
    if rank == 0 {
        let error = Pca::fit(poses, Dimensions::Share(0.9)).unwrap_err();
        assert_eq!(error, MotionError::Rank { dimensions: 1, poses: poses.len(), rank });
    }
}

#[test]
fn poses_that_span_too_few_dimensions_are_refused() {
    // Equal poses whose mean is not exactly theirs.
    for value in [0.0, 0.1, -3.7e5, 1e-9, 1e47] {
        for count in [1, 3, 7, 1000] {
            check_rank(&Rows::new(3, vec![value; 3 * count]).unwrap(), 1, 0);
        }
    }
    // A line far from the origin.
    for offset in [0.0, 1e3, -1e6] {
        let on_line = |k: i32| [0.1, 0.2, -0.3].map(|slope| offset + slope * f64::from(k));
        let line = Rows::new(3, (0..50).flat_map(on_line).collect()).unwrap();
        check_rank(&line, 2, 1);
        assert_eq!(fit(&line, 1).explained(), [1.0]);
    }
    // Fewer poses than channels.
    check_rank(&poses(2, 4, 6), 4, 3);
    let none = Rows::new(3, vec![]).unwrap();
    assert_eq!(Pca::fit(&none, Dimensions::Count(1)).unwrap_err(), MotionError::NoPoses);
}

#[test]
fn size_changes_nothing_but_size() {
    let poses = poses(8, 25, 4);
    let usual = fit(&poses, 2);
    for exponent in [-1000, -600, -300, 150] {
        let pca = fit(&scaled(&poses, exponent), 2);
        for (a, b) in pca.explained().iter().zip(usual.explained()) {
            assert!((a - b).abs() < 1e-12, "2^{exponent}: {a} {b}");
        }
        let points = pca.project(&scaled(&poses, exponent));
        let difference = largest_difference(&scaled(&points, -exponent), &usual.project(&poses));
        assert!(difference < 1e-12, "2^{exponent}: {difference}");
    }
    let opposite = Rows::new(2, vec![LARGEST, -LARGEST, -LARGEST, LARGEST]).unwrap();
    let points = fit(&opposite, 1).project(&opposite);
    assert!(points.values().iter().all(|value| value.is_finite() && value.abs() > LARGEST));
}
