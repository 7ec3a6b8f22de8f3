//! Delaunay tetrahedra against the definition: empty spheres, all of the hull, every vertex.
//!
//! Signs are computed in integers here, apart from the library's own predicates: coordinates are
//! integers up to 2²⁰ times a power of two.

use handover_mesh::Point;
use handover_mesh::delaunay::{Delaunay, DelaunayError, MAGNITUDES, Span, Workspace, delaunay};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashMap};

type Cell = [i64; 3];

/// A signed integer of 256 bits, enough for an `insphere` of 21-bit coordinates squared over.
///
/// Differences have 22 bits, squared distances 46, a minor of three columns with one of those 90,
/// their products with the last column 138: more than an `i128` holds, so high and low parts.
#[derive(Clone, Copy, Default, PartialEq)]
struct Wide {
    high: i128,
    low: u64,
}

impl Wide {
    /// Adds `a · b` for `|a| < 2¹⁰⁰` and `|b| < 2⁵⁰`, exactly.
    fn add_product(&mut self, a: i128, b: i128) {
        let (top, bottom) = (a >> 64, a & 0xffff_ffff_ffff_ffff);
        let low = bottom * b + i128::from(self.low);
        self.low = low as u64;
        self.high += top * b + (low >> 64);
    }

    fn signum(self) -> i32 {
        if self.high == 0 { i32::from(self.low > 0) } else { self.high.signum() as i32 }
    }
}

/// `det(b − a, c − a, d − a)`.
fn volume(a: Cell, b: Cell, c: Cell, d: Cell) -> i128 {
    let minus = |p: Cell| [0, 1, 2].map(|i| i128::from(p[i] - a[i]));
    det([minus(b), minus(c), minus(d)])
}

fn det([b, c, d]: [[i128; 3]; 3]) -> i128 {
    b[0] * (c[1] * d[2] - c[2] * d[1])
        + b[1] * (c[2] * d[0] - c[0] * d[2])
        + b[2] * (c[0] * d[1] - c[1] * d[0])
}

/// Positive if `p` is strictly inside the sphere of a positively oriented tetrahedron.
///
/// The determinant of the lifted differences to `p`, expanded along the lifted column.
fn in_sphere(corners: [Cell; 4], p: Cell) -> i32 {
    let rows = corners.map(|corner| [0, 1, 2].map(|i| i128::from(corner[i] - p[i])));
    let lift = rows.map(|r| r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    let mut sum = Wide::default();
    for i in 0..4 {
        let others: Vec<[i128; 3]> = (0..4).filter(|&j| j != i).map(|j| rows[j]).collect();
        let minor = det([others[0], others[1], others[2]]);
        // Checked on a corner tetrahedron below.
        sum.add_product(if i % 2 == 0 { minor } else { -minor }, lift[i]);
    }
    sum.signum()
}

fn at(cell: Cell, unit: f64) -> Point {
    Point::from(cell.map(|c| c as f64 * unit))
}

/// All the definition asks for, exactly.
#[track_caller]
fn check(cells: &[Cell], unit: f64) -> Delaunay {
    let points: Vec<Point> = cells.iter().map(|&cell| at(cell, unit)).collect();
    let found = delaunay(&points).expect("the points span a volume");
    let corners = |t: &[u32; 4]| t.map(|v| cells[v as usize]);

    let mut first = HashMap::new();
    let mut dropped = Vec::new();
    for (index, cell) in cells.iter().enumerate() {
        match first.get(cell) {
            Some(&kept) => dropped.push([index, kept]),
            None => drop(first.insert(*cell, index)),
        }
    }
    assert_eq!(found.duplicates(), dropped);
    let used: BTreeSet<usize> = found.tetrahedra().iter().flatten().map(|&v| v as usize).collect();
    assert_eq!(used, first.values().copied().collect(), "vertices");

    // Facets by corners: two tetrahedra on opposite sides, or one and then a face of the hull.
    let mut facets: BTreeMap<[u32; 3], Vec<(u32, [u32; 3])>> = BTreeMap::new();
    let mut sum = 0;
    for t in found.tetrahedra() {
        let [a, b, c, d] = corners(t);
        assert!(volume(a, b, c, d) > 0, "{t:?} is flat or turned inside out");
        sum += volume(a, b, c, d);
        for cell in first.keys() {
            assert!(in_sphere([a, b, c, d], *cell) <= 0, "{cell:?} inside the sphere of {t:?}");
        }
        let [a, b, c, d] = *t;
        for (apex, facet) in [(a, [b, d, c]), (b, [a, c, d]), (c, [a, d, b]), (d, [a, b, c])] {
            let mut key = facet;
            key.sort_unstable();
            facets.entry(key).or_default().push((apex, facet));
        }
    }
    // The cone from one point over the hull's faces is the hull.
    let mut hull = 0;
    let mut rim: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for sides in facets.values() {
        assert!(sides.len() <= 2);
        let [a, b, c] = sides[0].1.map(|v| cells[v as usize]);
        let side = |v: u32| volume(a, b, c, cells[v as usize]).signum();
        if let [(one, _), (other, _)] = sides[..] {
            assert_eq!(side(one), -side(other), "both on one side");
            continue;
        }
        for cell in first.keys() {
            assert!(volume(a, b, c, *cell).signum() * side(sides[0].0) >= 0, "not the hull");
        }
        hull += volume(a, b, c, cells[0]).abs();
        let [a, b, c] = sides[0].1;
        for [i, j] in [[a, b], [b, c], [c, a]] {
            *rim.entry([i.min(j), i.max(j)]).or_default() += if i < j { 1 } else { -1 };
        }
    }
    assert!(rim.values().all(|&turns| turns == 0), "the boundary is not closed");
    assert_eq!(sum, hull, "volume");

    let edges = found.edges();
    assert!(edges.windows(2).all(|pair| pair[0] < pair[1]));
    let expected: BTreeSet<[usize; 2]> = (found.tetrahedra().iter())
        .flat_map(|t| (0..16).map(move |k| [t[k / 4] as usize, t[k % 4] as usize]))
        .filter(|[i, j]| i < j)
        .collect();
    assert!(edges.iter().eq(expected.iter()));
    found
}

fn sorted(found: &Delaunay, name: impl Fn(u32) -> u32) -> Vec<[u32; 4]> {
    let mut all: Vec<[u32; 4]> = found.tetrahedra().iter().map(|t| t.map(&name)).collect();
    all.iter_mut().for_each(|t| t.sort_unstable());
    all.sort_unstable();
    all
}

fn grid(side: i64) -> Vec<Cell> {
    let flat = |x| (0..side).flat_map(move |y| (0..side).map(move |z| [x, y, z]));
    (0..side).flat_map(flat).collect()
}

/// Two people in T-pose facing each other, both symmetric about x = 0 [cm].
fn t_poses() -> Vec<Cell> {
    let one = [
        [0, 0, 160],
        [0, 0, 140],
        [0, 0, 115],
        [20, 0, 140],
        [45, 0, 140],
        [70, 0, 140],
        [-20, 0, 140],
        [-45, 0, 140],
        [-70, 0, 140],
        [10, 0, 90],
        [10, 0, 50],
        [10, 0, 10],
        [-10, 0, 90],
        [-10, 0, 50],
        [-10, 0, 10],
    ];
    one.into_iter().chain(one.map(|[x, y, z]| [-x, 120 - y, z])).collect()
}

fn cell(size: i64) -> impl Strategy<Value = Cell> {
    prop::array::uniform3(-size..=size)
}

fn spans(cells: &[Cell]) -> bool {
    cells
        .iter()
        .any(|&b| cells.iter().any(|&c| cells.iter().any(|&d| volume(cells[0], b, c, d) != 0)))
}

/// A power of two that keeps integers up to 2²⁰ within the allowed sizes.
fn unit() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0), Just(-30), Just(20), Just(-160), Just(139), -160..=139]
        .prop_map(|exponent| 2.0_f64.powi(exponent))
}

#[test]
fn the_reference_signs_are_right() {
    let corner = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]];
    assert!(volume(corner[0], corner[1], corner[2], corner[3]) > 0);
    assert_eq!(in_sphere(corner, [1, 1, 1]), 1);
    assert_eq!(in_sphere(corner, [2, 2, 2]), 0);
    assert_eq!(in_sphere(corner, [3, 2, 2]), -1);
    let large = corner.map(|c| c.map(|x| (x - 1) << 20));
    assert_eq!(in_sphere(large, [(1 << 20) - 1, 1 << 20, 1 << 20]), 1);
    assert_eq!(in_sphere(large, [1 << 20; 3]), 0);
    assert_eq!(in_sphere(large, [(1 << 20) + 1, 1 << 20, 1 << 20]), -1);
}

#[test]
fn symmetric_sets_keep_every_vertex() {
    for unit in [1.0, 0.0078125, 1048576.0] {
        check(&t_poses(), unit);
        for side in 2..=5 {
            check(&grid(side), unit);
        }
        let octahedron = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
        assert_eq!(check(&octahedron, unit).tetrahedra().len(), 4);
        let centred: Vec<Cell> = octahedron.into_iter().chain([[0, 0, 0]]).collect();
        assert_eq!(check(&centred, unit).tetrahedra().len(), 8);
    }
    // The golden rectangles in Fibonacci numbers: an icosahedron but for a rounding.
    let mut icosahedron = Vec::new();
    for (a, b) in [(610, 987), (-610, 987), (610, -987), (-610, -987)] {
        icosahedron.extend([[a, b, 0], [0, a, b], [b, 0, a]]);
    }
    check(&icosahedron, 1.0);
}

#[test]
fn points_on_one_sphere_keep_every_vertex() {
    // All integer points with x² + y² + z² = 2021 … of which there are many.
    for (square, least) in [(2021, 40), (26 * 81, 40), (5 * 13 * 17, 40)] {
        let r = (square as f64).sqrt() as i64 + 1;
        let ball =
            (-r..=r).flat_map(|x| (-r..=r).flat_map(move |y| (-r..=r).map(move |z| [x, y, z])));
        let on = |p: &Cell| p.iter().map(|c| c * c).sum::<i64>() == square;
        let mut cells: Vec<Cell> = ball.filter(on).collect();
        assert!(cells.len() >= least, "{}", cells.len());
        cells.truncate(200);
        check(&cells, 1.0);
        cells.push([0, 0, 0]);
        check(&cells, 1.0);
        cells.rotate_right(1);
        check(&cells, 0.5);
    }
}

#[test]
fn later_points_may_lie_on_edges_and_faces() {
    let corners = [[0, 0, 0], [24, 0, 0], [0, 24, 0], [0, 0, 24]];
    let inside = [
        [12, 0, 0],  // an edge of the hull
        [8, 8, 0],   // a face of the hull
        [8, 8, 8],   // the middle of the skew face
        [6, 6, 6],   // inside
        [3, 3, 3],   // on an edge made by the last
        [2, 2, 1],   // on a face
        [48, 0, 0],  // outside, on the line of an edge
        [24, 24, 0], // outside, in the plane of a face
        [-5, -5, -5],
    ];
    for length in 0..inside.len() {
        let cells: Vec<Cell> = corners.into_iter().chain(inside[..=length].to_vec()).collect();
        check(&cells, 1.0);
        check(&cells.iter().rev().copied().collect::<Vec<_>>(), 1.0);
    }
}

#[test]
fn duplicates_are_merged_into_the_first() {
    let mut cells = t_poses();
    cells.extend([cells[7], cells[3], cells[7]]);
    cells.insert(0, cells[5]);
    let found = check(&cells, 0.125);
    assert_eq!(found.duplicates(), [[6, 0], [31, 8], [32, 4], [33, 8]]);
    let signed = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        .map(Point::from)
        .into_iter()
        .chain([Point::new(-0.0, 1.0, -0.0)]);
    assert_eq!(delaunay(&signed.collect::<Vec<_>>()).unwrap().duplicates(), [[4, 2]]);
}

#[test]
fn points_without_volume_are_named() {
    let error = |cells: &[Cell]| {
        delaunay(&cells.iter().map(|&c| at(c, 0.1)).collect::<Vec<_>>()).unwrap_err()
    };
    assert_eq!(error(&[]), DelaunayError::TooFew { points: 0 });
    assert_eq!(error(&grid(1)), DelaunayError::TooFew { points: 1 });
    for (cells, span) in [
        (vec![[3, 1, 2]; 70], Span::Point),
        ((0..70).map(|i| [i, 2 * i, 0]).collect(), Span::Line),
        ((0..70).map(|i| [i * i % 31, i, 0]).collect(), Span::Plane),
        (vec![[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0]], Span::Plane),
    ] {
        assert_eq!(error(&cells), DelaunayError::Flat { points: cells.len(), span });
    }
    assert_eq!(Span::Line.dimension(), 1);
    assert_eq!(error(&[[1, 1, 1]; 5]).to_string(), "the 5 points span no volume: all coincide");
}

#[test]
fn bad_coordinates_are_named() {
    let mut points: Vec<Point> = t_poses().into_iter().map(|c| at(c, 0.01)).collect();
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        points[9].y = value;
        assert_eq!(delaunay(&points), Err(DelaunayError::NotFinite { point: 9 }));
    }
    for value in [1e300, -1e49, 1e-49, -1e-300] {
        points[9].y = value;
        assert_eq!(delaunay(&points), Err(DelaunayError::OutOfRange { point: 9, value }));
    }
    let text = delaunay(&points).unwrap_err().to_string();
    assert!(
        text.starts_with("point 9 has the coordinate -1e-300, neither 0 nor of size"),
        "{text}"
    );
    for value in [MAGNITUDES[0], -MAGNITUDES[1], 0.0, 1e-40] {
        points[9].y = value;
        assert!(delaunay(&points).is_ok(), "{value}");
    }
}

/// With `robust` itself: any doubles, here at scales that are no power of two.
#[track_caller]
fn check_rounded(points: &[Point]) {
    let found = delaunay(points).unwrap();
    let corner = |v: u32| {
        let p = points[v as usize];
        robust::Coord3D { x: p.x, y: p.y, z: p.z }
    };
    let mut used: BTreeSet<u32> = BTreeSet::new();
    for t in found.tetrahedra() {
        used.extend(t.iter());
        let [a, b, c, d] = t.map(corner);
        assert!(robust::orient3d(a, c, b, d) > 0.0);
        for v in 0..points.len() as u32 {
            assert!(robust::insphere(a, c, b, d, corner(v)) <= 0.0);
        }
    }
    assert_eq!(used.len() + found.duplicates().len(), points.len());
}

#[test]
fn lengths_far_from_a_metre_serve_as_well() {
    for scale in [1e-9, 1e6, 1e-40, 1e40] {
        for shift in [0.0, 3.0, 1e5] {
            let points = |cells: &[Cell]| -> Vec<Point> {
                let shifted = |c: &Cell| Point::from(c.map(|x| (x as f64 * 0.01 + shift) * scale));
                cells.iter().map(shifted).collect()
            };
            check_rounded(&points(&t_poses()));
            check_rounded(&points(&grid(4)));
        }
    }
}

proptest! {
    #[test]
    fn scattered_points(
        cells in prop::collection::vec(cell(1 << 20), 4..60), unit in unit(),
    ) {
        prop_assume!(spans(&cells));
        check(&cells, unit);
    }

    #[test]
    fn crowded_grids(cells in prop::collection::vec(cell(1), 4..40), unit in unit()) {
        prop_assume!(spans(&cells));
        check(&cells, unit);
    }

    #[test]
    fn small_grids(
        cells in prop::collection::vec(prop::array::uniform3(0_i64..4), 4..90), unit in unit(),
    ) {
        prop_assume!(spans(&cells));
        check(&cells, unit);
    }

    #[test]
    fn thin_boxes(
        cells in prop::collection::vec((cell(1 << 20), 0_i64..2), 4..90), axis in 0_usize..3,
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
    fn people_with_a_joint_anywhere(moved in prop::collection::vec((0_usize..30, cell(160)), 0..5)) {
        let mut cells = t_poses();
        for (joint, cell) in moved {
            cells[joint] = cell;
        }
        check(&cells, 0.0078125);
    }

    #[test]
    fn order_does_not_matter_in_general_position(
        cells in prop::collection::hash_set(cell(1 << 20), 5..120)
            .prop_map(|set| { let mut cells: Vec<Cell> = set.into_iter().collect(); cells.sort(); cells })
            .prop_shuffle(),
    ) {
        prop_assume!(spans(&cells));
        let points: Vec<Point> = cells.iter().map(|&c| at(c, 1.0)).collect();
        let mut by_place: Vec<u32> = (0..cells.len() as u32).collect();
        by_place.sort_by_key(|&i| cells[i as usize]);
        let again: Vec<Point> = by_place.iter().map(|&i| points[i as usize]).collect();
        let mut workspace = Workspace::default();
        let (one, other) = (workspace.delaunay(&points).unwrap(), workspace.delaunay(&again).unwrap());
        prop_assert_eq!(&one, &delaunay(&points).unwrap());
        prop_assert_eq!(sorted(&one, |v| v), sorted(&other, |v| by_place[v as usize]));
    }

    #[test]
    fn any_doubles(
        points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 4..80),
        scale in -140_i32..150, nearly_flat in any::<bool>(),
    ) {
        let scale = 1.1 * 2.0_f64.powi(scale);
        let place = |[x, y, z]: [f64; 3]| {
            Point::new(x * scale, y * scale, (x + y + if nearly_flat { 0.0 } else { z }) * scale)
        };
        let points: Vec<Point> = points.into_iter().map(place).collect();
        check_rounded(&points);
    }
}
