//! The nearest points against sorting all of them.

use handover_mesh::motion::{Near, Nearest, Rows, nearest_of_all};
use proptest::prelude::*;

use crate::{numbers, random, scaled};

/// Sorted by distance, then by index.
fn slowly(points: &Rows, place: &[f64], k: usize) -> Vec<u32> {
    let square = |point: &[f64]| point.iter().zip(place).map(|(x, at)| (x - at) * (x - at)).sum();
    let mut all: Vec<(f64, u32)> = points.iter().map(square).zip(0..).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    all.into_iter().take(k).map(|(_, point)| point).collect()
}

#[track_caller]
fn check(points: &Rows, place: &[f64], k: usize) {
    let mut found = vec![Near { squared_distance: -1.0, point: 77 }];
    Nearest::new(points).nearest(place, k, &mut found);
    let indices: Vec<u32> = found.iter().map(|near| near.point).collect();
    assert_eq!(indices, slowly(points, place, k));
    for near in found {
        let square = points.row(near.point as usize).iter().zip(place);
        let square: f64 = square.map(|(x, at)| (x - at) * (x - at)).sum();
        assert_eq!(near.squared_distance, square);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn they_are_the_first_of_all_sorted(
        seed: u64, count in 0..300_usize, width in 1..9_usize, k in 0..40_usize,
    ) {
        check(&random(seed, count, width), &numbers(seed + 1, width), k);
    }

    #[test]
    fn ties_go_by_index(
        points in prop::collection::vec(-2..=2_i8, 0..400), place in prop::array::uniform2(-2..=2_i8),
        k in 0..30_usize,
    ) {
        let values = points[..points.len() / 2 * 2].iter().map(|&x| f64::from(x));
        check(&Rows::new(2, values.collect()).unwrap(), &place.map(f64::from), k);
    }
}

#[test]
fn more_than_there_are_is_all_of_them() {
    for count in [1, 63, 64, 65, 129] {
        let points = random(9, count, 2);
        check(&points, &[0.1, 0.2], count + 5);
        check(&points, points.row(count - 1), 1);
        check(&scaled(&points, -500), &[0.0, 0.0], 3);
        check(&points, &[1e300, 0.0], 3);
    }
    let same = Rows::new(3, vec![0.5; 300]).unwrap();
    check(&same, &[0.5; 3], 16);
}

#[test]
fn a_place_that_is_not_finite_has_none() {
    let nearest = Nearest::new(&random(1, 30, 2));
    for bad in [f64::NAN, f64::INFINITY] {
        let mut found = vec![Near { squared_distance: 0.0, point: 0 }];
        nearest.nearest(&[0.0, bad], 5, &mut found);
        assert_eq!(found, []);
    }
}

/// The neighbours of all points are as near as those of each alone; which of equally near ones is
/// taken is not said.
#[track_caller]
fn check_all(points: &Rows, k: usize) {
    let found = nearest_of_all(points, k);
    let k = k.min(points.len());
    assert_eq!(found.len(), k * points.len());
    let square = |a: u32, b: u32| -> f64 {
        let [a, b] = [a, b].map(|row| points.row(row as usize));
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
    };
    for (point, row) in (0..).zip(found.chunks_exact(k.max(1))) {
        let distinct: std::collections::BTreeSet<&u32> = row.iter().collect();
        assert_eq!(distinct.len(), k, "each once");
        let squares: Vec<f64> = row.iter().map(|other| square(point, *other)).collect();
        let slow = slowly(points, points.row(point as usize), k);
        for (fast, slow) in squares.iter().zip(slow) {
            let slow = square(point, slow);
            assert!((fast - slow).abs() <= 1e-12 * slow, "{point}: {fast}, {slow}");
        }
    }
}

#[test]
fn the_neighbours_of_all_are_those_of_each() {
    for dimensions in 1..=10 {
        let row = |at: usize| (0..dimensions).map(move |axis| ((at * (3 + axis)) as f64).sin());
        let points = Rows::new(dimensions, (0..150).flat_map(row).collect()).unwrap();
        for k in [0, 1, 16, 150, 151] {
            check_all(&points, k);
        }
        // More points at one place, or on one line, than a leaf of a tree takes.
        let same = Rows::new(dimensions, vec![0.25; 90 * dimensions]).unwrap();
        let line = (0..90).flat_map(|at| {
            (0..dimensions).map(move |axis| f64::from(at) * f64::from(u8::from(axis == 0)))
        });
        let line = Rows::new(dimensions, line.collect()).unwrap();
        check_all(&same, 20);
        check_all(&line, 20);
    }
}
