//! The simplices of latent points against the definition, in every dimension that has them.

use std::collections::{BTreeMap, BTreeSet};

use handover_mesh::delaunay::{DelaunayError, Span};
use handover_mesh::motion::{Complex, MotionError, Rows};
use proptest::prelude::*;

use crate::exact::{Cell, in_sphere, volume};
use crate::random;

pub(crate) fn rows(cells: &[Cell], exponent: i32) -> Rows {
    let unit = 2_f64.powi(exponent);
    let values = cells.iter().flatten().map(|&c| c as f64 * unit).collect();
    Rows::new(cells[0].len(), values).unwrap()
}

pub(crate) fn corners<'a>(complex: &Complex, simplex: u32, cells: &'a [Cell]) -> Vec<&'a Cell> {
    complex.corners(simplex).iter().map(|&corner| &cells[corner as usize]).collect()
}

/// All that the definition asks for, exactly.
#[track_caller]
pub(crate) fn check(cells: &[Cell], exponent: i32) -> Complex {
    let complex = Complex::new(&rows(cells, exponent)).unwrap();
    let dimensions = cells[0].len();
    assert_eq!(complex.dimensions(), dimensions);

    let (mut first, mut dropped) = (BTreeMap::new(), Vec::new());
    for (at, cell) in cells.iter().enumerate() {
        let kept = *first.entry(cell).or_insert(at);
        if kept != at {
            dropped.push([at, kept]);
        }
    }
    assert_eq!(complex.duplicates(), dropped);

    let mut used = BTreeSet::new();
    let mut facets: BTreeMap<Vec<u32>, Vec<u32>> = BTreeMap::new();
    let mut filled = 0;
    for simplex in 0..complex.len() as u32 {
        let places = corners(&complex, simplex, cells);
        assert_eq!(places.len(), dimensions + 1);
        assert_ne!(volume(&places), 0, "{places:?} is flat");
        filled += volume(&places).abs();
        for cell in first.keys() {
            assert!(in_sphere(&places, cell) <= 0, "{cell:?} in the sphere of {places:?}");
        }
        used.extend(complex.corners(simplex).iter().map(|&corner| corner as usize));
        for &apex in complex.corners(simplex) {
            let mut facet = complex.corners(simplex).to_vec();
            facet.retain(|&corner| corner != apex);
            facet.sort_unstable();
            facets.entry(facet).or_default().push(apex);
        }
    }
    assert_eq!(used, first.values().copied().collect(), "corners are points, points are corners");

    // A facet has two simplices, on either side, or is one of the hull's.
    let mut hull = 0;
    for (facet, apexes) in &facets {
        let over = |cell: &Cell| {
            let mut places: Vec<&Cell> = facet.iter().map(|&c| &cells[c as usize]).collect();
            places.push(cell);
            volume(&places)
        };
        let side = over(&cells[apexes[0] as usize]).signum();
        match apexes[..] {
            [_] => {
                assert!(cells.iter().all(|cell| over(cell).signum() * side >= 0), "not the hull");
                hull += over(&cells[0]).abs();
            }
            [_, other] => assert_eq!(over(&cells[other as usize]).signum(), -side),
            _ => panic!("{facet:?} belongs to {apexes:?}"),
        }
    }
    assert_eq!(filled, hull, "the simplices fill the hull, once");

    let pairs = (0..complex.len() as u32).flat_map(|simplex| {
        let corners = complex.corners(simplex);
        corners.iter().flat_map(move |&i| corners.iter().map(move |&j| [i, j]))
    });
    let pairs: BTreeSet<[u32; 2]> = pairs.filter(|[i, j]| i < j).collect();
    assert_eq!(complex.edges(), pairs.into_iter().collect::<Vec<_>>());
    complex
}

/// Points of a small lattice, so that many coincide, and many lie on one line, plane or sphere.
pub(crate) fn cells(count: usize, size: i64) -> impl Strategy<Value = Vec<Cell>> {
    Complex::DIMENSIONS.prop_flat_map(move |dimensions| {
        let cell = prop::collection::vec(-size..=size, dimensions);
        prop::collection::vec(cell, dimensions + 2..count)
    })
}

pub(crate) fn spans(cells: &[Cell]) -> bool {
    Complex::new(&rows(cells, 0)).is_ok()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn simplices_are_those_of_the_definition(cells in cells(32, 500), exponent in -130..130) {
        prop_assume!(spans(&cells));
        check(&cells, exponent);
    }

    #[test]
    fn ties_and_duplicates_keep_every_point(cells in cells(32, 2)) {
        // A corner and its neighbours make sure of the volume.
        let dimensions = cells[0].len();
        let unit = |axis: usize| (0..dimensions).map(|i| i64::from(i + 1 == axis)).collect();
        check(&[cells, (0..=dimensions).map(unit).collect()].concat(), 0);
    }
}

fn grid(side: i64, dimensions: usize) -> Vec<Cell> {
    (0..dimensions).fold(vec![vec![]], |cells: Vec<Cell>, _| {
        let longer = |cell: Cell| (0..side).map(move |x| [cell.clone(), vec![x]].concat());
        cells.into_iter().flat_map(longer).collect()
    })
}

#[test]
fn grids_keep_every_point() {
    for dimensions in Complex::DIMENSIONS {
        for exponent in [-159, 0, 157] {
            check(&grid(if dimensions == 4 { 2 } else { 4 }, dimensions), exponent);
        }
    }
}

#[test]
fn points_on_one_circle_keep_every_point() {
    // All of 5² = 3² + 4², and then their middle too.
    let quarter = [[5, 0], [4, 3], [3, 4]];
    let turn = |[x, y]: [i64; 2]| [[x, y], [-y, x], [-x, -y], [y, -x]].map(Vec::from);
    let mut circle: Vec<Cell> = quarter.into_iter().flat_map(turn).collect();
    assert_eq!(check(&circle, 0).len(), 10);
    circle.push(vec![0, 0]);
    assert_eq!(check(&circle, -20).len(), 12);
}

#[test]
fn points_that_fill_no_volume_are_refused_by_what_they_span() {
    let refused = |rows: &Rows| match Complex::new(rows).unwrap_err() {
        MotionError::Delaunay(error) => error,
        other => panic!("{other}"),
    };
    for dimensions in Complex::DIMENSIONS {
        let on = |spanned: usize| {
            let row = |at: usize| (0..dimensions).map(move |axis| [at, at * at][axis % spanned]);
            let values = (0..9).flat_map(row).map(|value| value as f64);
            Rows::new(dimensions, values.collect()).unwrap()
        };
        let same = Rows::new(dimensions, vec![0.3; 7 * dimensions]).unwrap();
        assert_eq!(refused(&same), DelaunayError::Flat { points: 7, span: Span::Point });
        assert_eq!(refused(&on(1)), DelaunayError::Flat { points: 9, span: Span::Line });
        if dimensions > 2 {
            assert_eq!(refused(&on(2)), DelaunayError::Flat { points: 9, span: Span::Plane });
        }
        for points in 0..=dimensions {
            let few = random(7, points, dimensions);
            assert_eq!(refused(&few), DelaunayError::TooFew { points });
        }
    }
}

#[test]
fn sizes_out_of_range_are_named() {
    for bad in [f64::NAN, f64::INFINITY, -1e49] {
        let error = Rows::new(2, vec![0.0, 0.0, 1.0, bad]).unwrap_err();
        let named = matches!(error, MotionError::OutOfRange { row: 1, column: 1, .. });
        assert!(named, "{error}");
    }
    for dimensions in Complex::DIMENSIONS {
        let mut values = random(3, 8, dimensions).values().to_vec();
        values[dimensions] = 1e-50;
        let error = Complex::new(&Rows::new(dimensions, values).unwrap()).unwrap_err();
        let expected = DelaunayError::OutOfRange { point: 1, value: 1e-50 };
        assert_eq!(error, MotionError::Delaunay(expected));
    }
    assert!(Rows::new(0, vec![]).is_err() && Rows::new(3, vec![0.0; 4]).is_err());
}

#[test]
fn other_dimensions_are_refused_and_nearest_neighbours_named() {
    for dimensions in [1, 5, 6] {
        let error = Complex::new(&random(1, 50, dimensions)).unwrap_err();
        assert_eq!(error, MotionError::Dimensions { dimensions });
        let text = error.to_string();
        assert!(text.contains(&format!("not {dimensions}")) && text.contains("knn"), "{text}");
    }
}
