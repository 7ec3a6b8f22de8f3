//! Delaunay tetrahedra against the definition: empty spheres, all of the hull, every vertex.
//!
//! Signs are computed in integers here, apart from the library's own predicates: coordinates are
//! integers up to 2²⁰ times a power of two.

mod definition;
mod four;

use definition::{Cell, at, check, in_sphere, volume};
use handover_mesh::Point;
use handover_mesh::delaunay::{Delaunay, DelaunayError, MAGNITUDES, Span, Workspace, delaunay};
use proptest::prelude::*;
use std::collections::BTreeSet;

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

fn quadruples(n: u32) -> impl Iterator<Item = [u32; 4]> {
    let pairs = move |from: u32| (from..n).flat_map(move |a| (a + 1..n).map(move |b| [a, b]));
    pairs(0).flat_map(move |[a, b]| pairs(b + 1).map(move |[c, d]| [a, b, c, d]))
}

/// With `robust` itself: any doubles, here at scales that are no power of two. Points that are
/// called flat must be so: no four of them span a volume.
#[track_caller]
fn check_rounded(points: &[Point]) {
    let corner = |v: u32| {
        let p = points[v as usize];
        robust::Coord3D { x: p.x, y: p.y, z: p.z }
    };
    let found = match delaunay(points) {
        Ok(found) => found,
        Err(DelaunayError::Flat { .. }) => {
            for [a, b, c, d] in quadruples(points.len() as u32) {
                let [a, b, c, d] = [a, b, c, d].map(corner);
                assert_eq!(robust::orient3d(a, b, c, d), 0.0);
            }
            return;
        }
        Err(other) => panic!("{other}"),
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
            for points in [points(&t_poses()), points(&grid(4))] {
                check_rounded(&points);
                assert!(delaunay(&points).is_ok(), "the points span a volume");
            }
        }
    }
}

/// Found by `any_doubles`: rounding left four nearly flat points exactly in one plane.
#[test]
fn four_points_rounded_into_a_plane_are_flat() {
    let points = [[0.0, 0.0], [0.5, 0.0], [0.0, 0.25], [0.75, 0.5]];
    let points: Vec<Point> = points.map(|[x, y]| Point::new(x, y, x + y)).to_vec();
    assert!(matches!(delaunay(&points), Err(DelaunayError::Flat { points: 4, .. })));
    check_rounded(&points);
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
