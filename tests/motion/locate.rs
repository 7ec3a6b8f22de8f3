//! Walks to the simplex that holds a place, from anywhere, against trying them all.

use handover_mesh::motion::{Complex, Place};
use proptest::prelude::*;

use crate::complex::{cells, corners, rows, spans};
use crate::exact::{Cell, holds, volume};

/// Whether every walk ends where the place is, or rightly outside the hull.
#[track_caller]
fn check(cells: &[Cell], places: &[Cell]) {
    let complex = Complex::new(&rows(cells, 0)).unwrap();
    for place in places {
        let as_floats: Vec<f64> = place.iter().map(|&c| c as f64).collect();
        let holding = |simplex: &u32| holds(&corners(&complex, *simplex, cells), place);
        let held = (0..complex.len() as u32).any(|simplex| holding(&simplex));
        for start in 0..complex.len() as u32 {
            let found = complex.locate(&as_floats, start);
            assert_eq!(found.is_inside(), held, "{place:?} from {start}: {found:?}");
            assert!((found.simplex() as usize) < complex.len());
            if let Place::Inside(simplex) = found {
                assert!(holding(&simplex), "{place:?} from {start}: not in {simplex}");
            }
        }
    }
}

/// Places between lattice points, as many inside as outside.
fn places(dimensions: usize) -> impl Strategy<Value = Vec<Cell>> {
    prop::collection::vec(prop::collection::vec(-60_i64..=60, dimensions), 12)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn every_walk_ends_where_trying_all_does(
        (cells, places) in cells(20, 12).prop_flat_map(|cells| {
            let dimensions = cells[0].len();
            (Just(cells), places(dimensions))
        })
    ) {
        prop_assume!(spans(&cells));
        let four: Vec<Cell> =
            cells.iter().map(|cell| cell.iter().map(|c| 4 * c).collect()).collect();
        check(&four, &[places, four.clone()].concat());
    }
}

/// Points about as near to a line as integers can be, and two that are not.
fn nearly_on_a_line() -> impl Strategy<Value = Vec<Cell>> {
    let near = (0..1_i64 << 50).prop_map(|x| vec![x, 3 * x / 7]);
    let size = 1_i64 << 50;
    let far = (0..size, size..2 * size).prop_map(|(x, y)| vec![x, y]);
    (prop::collection::vec(near, 3..12), prop::collection::vec(far, 1..3))
        .prop_map(|(near, far)| [near, far].concat())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// What rounds to a flat simplex must not catch what passes by.
    #[test]
    fn slivers_catch_no_place(cells in nearly_on_a_line()) {
        let complex = Complex::new(&rows(&cells, 0)).unwrap();
        let middle = |simplex: u32| -> Cell {
            let corners = corners(&complex, simplex, &cells);
            (0..2).map(|axis| corners.iter().map(|c| c[axis]).sum::<i64>() / 3).collect()
        };
        let thick = |simplex: &u32| volume(&corners(&complex, *simplex, &cells)).abs() > 1 << 96;
        let places: Vec<Cell> = (0..complex.len() as u32).filter(thick).map(middle).collect();
        check(&cells, &places);
    }
}

#[test]
fn far_places_are_outside_and_near_ones_need_no_walk() {
    let cells: Vec<Cell> = vec![vec![0, 0], vec![4, 0], vec![0, 4], vec![4, 5]];
    let complex = Complex::new(&rows(&cells, 0)).unwrap();
    for place in [[1e300, 0.0], [-1e12, 1e12], [2.0, -1e-6]] {
        assert!((0..2).all(|start| !complex.locate(&place, start).is_inside()), "{place:?}");
    }
    let found = complex.locate(&[0.5, 0.5], 0);
    assert_eq!(complex.locate(&[0.4, 0.6], found.simplex()), found);
}
