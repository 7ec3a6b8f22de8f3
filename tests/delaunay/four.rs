//! Four dimensions against the definition, in integers apart from the library's own predicates.

use handover_mesh::delaunay::{Delaunay, DelaunayError, MAGNITUDES, Span, delaunay_4d};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// An integer point, coordinates up to 2¹⁵ in size.
type Cell = [i64; 4];

/// By rows, whatever their number.
fn det(rows: &[Vec<i128>]) -> i128 {
    let Some((first, rest)) = rows.split_first() else { return 1 };
    let mut sum = 0;
    for column in 0..first.len() {
        if first[column] == 0 {
            continue;
        }
        let minor: Vec<Vec<i128>> =
            (rest.iter()).map(|row| [&row[..column], &row[column + 1..]].concat()).collect();
        sum += if column % 2 == 0 { 1 } else { -1 } * first[column] * det(&minor);
    }
    sum
}

fn minus(a: Cell, b: Cell) -> Vec<i128> {
    (0..4).map(|i| i128::from(a[i] - b[i])).collect()
}

/// `det(b − a, c − a, d − a, e − a)`.
fn volume([a, others @ ..]: [Cell; 5]) -> i128 {
    det(&others.map(|p| minus(p, a)))
}

/// Positive if `p` is strictly inside the sphere of a positively oriented simplex.
///
/// The sign is that of the centre of a corner, as [`the_reference_signs_are_right`] asks.
fn in_sphere(corners: [Cell; 5], p: Cell) -> i128 {
    let rows = corners.map(|corner| {
        let mut row = minus(corner, p);
        row.push(row.iter().map(|x| x * x).sum());
        row
    });
    det(&rows).signum()
}

fn at(cell: Cell, unit: f64) -> [f64; 4] {
    cell.map(|c| c as f64 * unit)
}

/// All the definition asks for, exactly.
#[track_caller]
fn check(cells: &[Cell], unit: f64) -> Delaunay<5> {
    let points: Vec<[f64; 4]> = cells.iter().map(|&cell| at(cell, unit)).collect();
    let found = delaunay_4d(&points).expect("the points span four dimensions");
    let corners = |simplex: &[u32; 5]| simplex.map(|v| cells[v as usize]);

    let mut first = HashMap::new();
    let mut dropped = Vec::new();
    for (index, cell) in cells.iter().enumerate() {
        match first.get(cell) {
            Some(&kept) => dropped.push([index, kept]),
            None => drop(first.insert(*cell, index)),
        }
    }
    assert_eq!(found.duplicates(), dropped);
    let used: BTreeSet<usize> = found.simplices().iter().flatten().map(|&v| v as usize).collect();
    assert_eq!(used, first.values().copied().collect(), "vertices");

    // Facets by corners, with whom they are opposite of in which simplex.
    let mut facets: BTreeMap<[u32; 4], Vec<u32>> = BTreeMap::new();
    let mut sum = 0;
    for simplex in found.simplices() {
        let places = corners(simplex);
        assert!(volume(places) > 0, "{simplex:?} is flat or turned inside out");
        sum += volume(places);
        for cell in first.keys() {
            assert!(in_sphere(places, *cell) <= 0, "{cell:?} inside the sphere of {simplex:?}");
        }
        for opposite in 0..5 {
            let mut facet: Vec<u32> = simplex.to_vec();
            let apex = facet.remove(opposite);
            facet.sort_unstable();
            facets.entry(facet.try_into().unwrap()).or_default().push(apex);
        }
    }
    // The cone from one point over the hull's facets is the hull.
    let mut hull = 0;
    let mut ridges: BTreeMap<Vec<u32>, usize> = BTreeMap::new();
    for (facet, apexes) in &facets {
        let side = |cell: Cell| {
            let [a, b, c, d] = facet.map(|v| cells[v as usize]);
            volume([cell, a, b, c, d])
        };
        let apex = |index: usize| side(cells[apexes[index] as usize]).signum();
        if apexes.len() == 2 {
            assert_eq!(apex(0), -apex(1), "both on one side");
            continue;
        }
        assert_eq!(apexes.len(), 1);
        for cell in first.keys() {
            assert!(side(*cell).signum() * apex(0) >= 0, "not the hull");
        }
        hull += side(cells[0]).abs();
        for omitted in 0..4 {
            let mut ridge = facet.to_vec();
            ridge.remove(omitted);
            *ridges.entry(ridge).or_default() += 1;
        }
    }
    assert!(ridges.values().all(|&facets| facets == 2), "the boundary is not closed");
    assert_eq!(sum, hull, "volume");

    let expected: BTreeSet<[usize; 2]> = (found.simplices().iter())
        .flat_map(|s| (0..25).map(move |k| [s[k / 5] as usize, s[k % 5] as usize]))
        .filter(|[i, j]| i < j)
        .collect();
    assert!(found.edges().iter().eq(expected.iter()));
    found
}

fn grid(side: i64) -> Vec<Cell> {
    let digit = |i: i64, place: u32| i / side.pow(place) % side;
    (0..side.pow(4)).map(|i| [0, 1, 2, 3].map(|place| digit(i, place))).collect()
}

/// All integer points whose coordinates satisfy `on`.
fn ball(radius: i64, on: impl Fn(&Cell) -> bool) -> Vec<Cell> {
    let centred = |cell: Cell| cell.map(|c| c - radius);
    grid(2 * radius + 1).into_iter().map(centred).filter(on).collect()
}

fn square(cell: &Cell) -> i64 {
    cell.iter().map(|c| c * c).sum()
}

fn spans(cells: &[Cell]) -> bool {
    let rows: Vec<Vec<i128>> = cells.iter().map(|&cell| minus(cell, cells[0])).collect();
    // The Gram determinant of the axes is zero where they are dependent.
    let dot = |i: usize, j: usize| rows.iter().map(|row| row[i] * row[j]).sum();
    let gram: Vec<Vec<i128>> = (0..4).map(|i| (0..4).map(|j| dot(i, j)).collect()).collect();
    det(&gram) != 0
}

fn cell(size: i64) -> impl Strategy<Value = Cell> {
    prop::array::uniform4(-size..=size)
}

/// A power of two that keeps integers up to 2¹⁵ within the allowed sizes.
fn unit() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0), Just(-30), Just(20), Just(-160), Just(144), -160..=144]
        .prop_map(|exponent| 2.0_f64.powi(exponent))
}

#[test]
fn the_reference_signs_are_right() {
    let corner = [[0; 4], [2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 2]];
    assert_eq!(volume(corner), 16);
    assert_eq!(in_sphere(corner, [1; 4]), 1);
    assert_eq!(in_sphere(corner, [2; 4]), 0);
    assert_eq!(in_sphere(corner, [3, 2, 2, 2]), -1);
}

#[test]
fn symmetric_sets_keep_every_vertex_in_four_dimensions() {
    for unit in [1.0, 0.0078125, 2.0_f64.powi(-160), 2.0_f64.powi(150)] {
        for side in 2..=3 {
            check(&grid(side), unit);
        }
        let cross = ball(1, |cell| square(cell) == 1);
        assert_eq!(check(&cross, unit).simplices().len(), 8);
        let centred: Vec<Cell> = cross.iter().copied().chain([[0; 4]]).collect();
        assert_eq!(check(&centred, unit).simplices().len(), 16);
        // The 24-cell: the corners of the hypercube and those of a cross twice as large.
        let on = |cell: &Cell| {
            square(cell) == 4 && cell.iter().all(|c| c.abs() != 1)
                || cell.iter().all(|c| c.abs() == 1)
        };
        let corners = ball(2, on);
        assert_eq!(corners.len(), 24);
        check(&corners, unit);
    }
}

#[test]
fn points_on_one_sphere_keep_every_vertex_in_four_dimensions() {
    for (radius, least) in [(7, 64), (10, 40), (14, 64)] {
        let mut cells = ball(4, |cell| square(cell) == radius);
        assert!(cells.len() >= least, "{}", cells.len());
        cells.truncate(60);
        check(&cells, 1.0);
        cells.push([0; 4]);
        check(&cells, 1.0);
        cells.rotate_right(1);
        check(&cells, 0.5);
    }
}
