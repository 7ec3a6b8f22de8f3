//! Four dimensions against the definition, in integers apart from the library's own predicates.

use handover_mesh::delaunay::{Delaunay, DelaunayError, MAGNITUDES, Span, Workspace, delaunay_4d};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// An integer point, coordinates up to 2¹⁵ in size.
type Cell = [i64; 4];

/// The determinant of as many columns as rows: those whose bits are set.
fn det(rows: &[[i128; 5]], columns: u32) -> i128 {
    let Some((first, rest)) = rows.split_first() else { return 1 };
    let mut sum = 0;
    let mut sign = 1;
    for column in (0..5).filter(|column| columns >> column & 1 == 1) {
        if first[column] != 0 {
            sum += sign * first[column] * det(rest, columns & !(1 << column));
        }
        sign = -sign;
    }
    sum
}

/// The difference and the square of its length.
fn minus(a: Cell, b: Cell) -> [i128; 5] {
    let mut row = [0; 5];
    for i in 0..4 {
        row[i] = i128::from(a[i] - b[i]);
        row[4] += row[i] * row[i];
    }
    row
}

/// `det(b − a, c − a, d − a, e − a)`.
fn volume([a, others @ ..]: [Cell; 5]) -> i128 {
    det(&others.map(|p| minus(p, a)), 0b01111)
}

/// Positive if `p` is strictly inside the sphere of a positively oriented simplex.
///
/// The determinant of the lifted differences to `p`. Differences are at most 2¹⁶, so its 120 terms
/// stay below 2¹⁰⁵.
fn in_sphere(corners: [Cell; 5], p: Cell) -> i128 {
    det(&corners.map(|corner| minus(corner, p)), 0b11111).signum()
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
            facets.entry(facet.try_into().expect("four corners")).or_default().push(apex);
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

/// By elimination without fractions (Bareiss 1968): every number is a minor, below 2⁷⁰.
fn spans(cells: &[Cell]) -> bool {
    let mut rows: Vec<[i128; 5]> = cells.iter().map(|&cell| minus(cell, cells[0])).collect();
    let mut last = 1;
    for column in 0..4 {
        let Some(place) = rows.iter().position(|row| row[column] != 0) else { return false };
        let pivot = rows.swap_remove(place);
        for row in &mut rows {
            let factor = row[column];
            for i in 0..4 {
                row[i] = (row[i] * pivot[column] - pivot[i] * factor) / last;
            }
        }
        last = pivot[column];
    }
    true
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

#[test]
fn later_points_may_lie_on_edges_and_facets_in_four_dimensions() {
    let corners = [[0; 4], [24, 0, 0, 0], [0, 24, 0, 0], [0, 0, 24, 0], [0, 0, 0, 24]];
    let inside = [
        [12, 0, 0, 0],   // an edge of the hull
        [8, 8, 0, 0],    // a triangle of the hull
        [6, 6, 6, 0],    // a facet of the hull
        [6, 6, 6, 6],    // the middle of the skew facet
        [5, 5, 5, 5],    // inside
        [3, 3, 3, 3],    // on an edge made by the last
        [2, 2, 2, 1],    // on a facet
        [48, 0, 0, 0],   // outside, on the line of an edge
        [24, 24, 0, 0],  // outside, in the plane of a triangle
        [24, 24, 24, 0], // outside, in the hyperplane of a facet
        [-5, -5, -5, -5],
    ];
    for length in 0..inside.len() {
        let cells: Vec<Cell> = corners.into_iter().chain(inside[..=length].to_vec()).collect();
        check(&cells, 1.0);
        check(&cells.iter().rev().copied().collect::<Vec<_>>(), 1.0);
    }
}

#[test]
fn duplicates_are_merged_into_the_first_in_four_dimensions() {
    let mut cells = grid(2);
    cells.extend([cells[7], cells[3], cells[7]]);
    cells.insert(0, cells[5]);
    assert_eq!(check(&cells, 0.125).duplicates(), [[6, 0], [17, 8], [18, 4], [19, 8]]);
}

#[test]
fn points_that_miss_a_dimension_are_named() {
    let error = |cells: &[Cell]| {
        delaunay_4d(&cells.iter().map(|&c| at(c, 0.1)).collect::<Vec<_>>()).unwrap_err()
    };
    for count in 0..5 {
        assert_eq!(error(&grid(2)[..count]), DelaunayError::TooFew { points: count });
    }
    let line = |i: i64| [i, 2 * i, 0, -i];
    let plane = |i: i64| [i * i % 31, i, 0, i];
    let space = |i: i64| [i * i % 31, i, i * i * i % 17, i];
    for (cells, span) in [
        (vec![[3, 1, 2, 0]; 70], Span::Point),
        ((0..70).map(line).collect(), Span::Line),
        ((0..70).map(plane).collect(), Span::Plane),
        ((0..70).map(space).collect::<Vec<_>>(), Span::Space),
    ] {
        assert_eq!(error(&cells), DelaunayError::Flat { points: 70, span });
        let more = cells.iter().chain(&[[1, 2, 3, 5]]);
        let points: Vec<[f64; 4]> = more.map(|&c| at(c, 0.1)).collect();
        assert_eq!(delaunay_4d(&points).is_ok(), span == Span::Space);
    }
    let text = error(&(0..70).map(space).collect::<Vec<_>>()).to_string();
    let expected = "the 70 points span three dimensions of four: all lie in one three-dimensional \
                    space";
    assert_eq!(text, expected);
}

#[test]
fn bad_coordinates_are_named_in_four_dimensions() {
    let mut points: Vec<[f64; 4]> = grid(3).into_iter().map(|c| at(c, 0.01)).collect();
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        points[9][3] = value;
        assert_eq!(delaunay_4d(&points), Err(DelaunayError::NotFinite { point: 9 }));
    }
    for value in [1e300, -1e49, 1e-49, -1e-300] {
        points[9][3] = value;
        assert_eq!(delaunay_4d(&points), Err(DelaunayError::OutOfRange { point: 9, value }));
    }
    for value in [MAGNITUDES[0], -MAGNITUDES[1], 0.0, 1e-40] {
        points[9][3] = value;
        let found = delaunay_4d(&points).unwrap();
        let used: BTreeSet<u32> = found.simplices().iter().flatten().copied().collect();
        assert_eq!(used.len() + found.duplicates().len(), points.len(), "{value}");
    }
}

/// Every choice of five with an empty sphere; all that are one, in general position.
fn by_definition(cells: &[Cell]) -> Vec<[u32; 5]> {
    let mut found = Vec::new();
    for chosen in (0_u32..1 << cells.len()).filter(|chosen| chosen.count_ones() == 5) {
        let mut places = (0..cells.len() as u32).filter(|v| chosen >> v & 1 == 1);
        let simplex = [0; 5].map(|_| places.next().expect("five bits"));
        let mut corners = simplex.map(|v| cells[v as usize]);
        if volume(corners) < 0 {
            corners.swap(0, 1);
        }
        if cells.iter().all(|&p| in_sphere(corners, p) <= 0) {
            found.push(simplex);
        }
    }
    found.sort_unstable();
    found
}

fn sorted(found: &Delaunay<5>, name: impl Fn(u32) -> u32) -> Vec<[u32; 5]> {
    let mut all: Vec<[u32; 5]> = found.simplices().iter().map(|s| s.map(&name)).collect();
    all.iter_mut().for_each(|s| s.sort_unstable());
    all.sort_unstable();
    all
}

/// A fixed set in general position: fractions of roots, by squares so that it is no lattice.
fn scattered(count: usize) -> Vec<[f64; 4]> {
    let fraction = |i: usize, prime: f64| ((i * i) as f64 * prime.sqrt()).fract();
    (1..=count).map(|i| [2.0, 3.0, 5.0, 7.0].map(|prime| fraction(i, prime))).collect()
}

#[test]
fn there_are_as_many_simplices_as_qhull_finds() {
    // `len(scipy.spatial.Delaunay(points).simplices)`, SciPy 1.17.1.
    for (count, simplices) in [(50, 592), (300, 6597)] {
        assert_eq!(delaunay_4d(&scattered(count)).unwrap().simplices().len(), simplices);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn scattered_points_in_four_dimensions(
        cells in prop::collection::vec(cell(1 << 15), 5..30), unit in unit(),
    ) {
        prop_assume!(spans(&cells));
        check(&cells, unit);
    }

    #[test]
    fn crowded_grids_in_four_dimensions(
        cells in prop::collection::vec(cell(1), 5..60), unit in unit(),
    ) {
        prop_assume!(spans(&cells));
        check(&cells, unit);
    }

    #[test]
    fn thin_boxes_in_four_dimensions(
        cells in prop::collection::vec((cell(1 << 15), 0_i64..2), 5..30), axis in 0_usize..4,
    ) {
        let flat = |(mut cell, height): (Cell, i64)| {
            cell[axis] = height;
            cell
        };
        let cells: Vec<Cell> = cells.into_iter().map(flat).collect();
        prop_assume!(spans(&cells));
        check(&cells, 1.0);
    }

    #[test]
    fn a_simplex_is_any_five_points_with_an_empty_sphere(
        cells in prop::collection::hash_set(cell(1 << 15), 6..11),
    ) {
        let cells: Vec<Cell> = cells.into_iter().collect();
        prop_assume!(spans(&cells));
        let points: Vec<[f64; 4]> = cells.iter().map(|&c| at(c, 0.5)).collect();
        prop_assert_eq!(sorted(&delaunay_4d(&points).unwrap(), |v| v), by_definition(&cells));
    }

    #[test]
    fn order_does_not_matter_in_four_dimensions(
        order in Just((0_usize..100).collect::<Vec<_>>()).prop_shuffle(),
    ) {
        let points = scattered(100);
        let shuffled: Vec<[f64; 4]> = order.iter().map(|&i| points[i]).collect();
        let mut workspace = Workspace::default();
        let one = workspace.delaunay_4d(&shuffled).unwrap();
        let other = workspace.delaunay_4d(&points).unwrap();
        prop_assert_eq!(&one, &delaunay_4d(&shuffled).unwrap());
        prop_assert_eq!(sorted(&one, |v| order[v as usize] as u32), sorted(&other, |v| v));
    }
}
