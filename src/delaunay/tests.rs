//! Structure: the links between cells, and the points on which the walk or the cavity could trip.

use super::cavity::SIDE;
use super::cells::FREE;
use super::*;
use proptest::prelude::*;

impl Workspace {
    /// Panics unless neighbours know each other, share a facet and see it from opposite sides.
    fn sanity_check(&self) {
        for (index, cell) in self.cells.iter().enumerate() {
            if cell.vertices == FREE {
                continue;
            }
            for facet in 0..4 {
                let across = cell.neighbours[facet];
                let other = &self.cells[(across >> 2) as usize];
                let back = (across & 3) as usize;
                assert_ne!(other.vertices, FREE);
                assert_eq!(other.neighbours[back] as usize, 4 * index + facet);
                let corners = |cell: &Cell, facet: usize| {
                    let mut corners = cells::FACET[facet].map(|i| cell.vertices[i]);
                    let least = (0..3).min_by_key(|&i| corners[i]).unwrap();
                    corners.rotate_left(least);
                    corners
                };
                let [a, b, c] = corners(cell, facet);
                assert_eq!(corners(other, back), [a, c, b]);
            }
        }
    }
}

fn check(points: &[Point]) -> Delaunay {
    let mut workspace = Workspace::default();
    let found = workspace.delaunay(points).unwrap();
    workspace.sanity_check();
    found
}

fn grid(side: i32) -> Vec<Point> {
    let cells =
        (0..side).flat_map(|x| (0..side).flat_map(move |y| (0..side).map(move |z| [x, y, z])));
    cells.map(|cell| Point::from(cell.map(f64::from))).collect()
}

#[test]
fn links_are_mutual_on_grids() {
    for side in 2..6 {
        let found = check(&grid(side));
        assert!(found.duplicates().is_empty());
    }
}

#[test]
fn a_cavity_of_many_corners_is_linked() {
    // A dome, and a point that sees all of its outside and is last along the curve.
    let axes = [[1.0, -1.0, -1.0], [1.0, 1.0, 0.0], [1.0, -1.0, 2.0]];
    let [axis, u, v] = axes.map(|axis| crate::Vector::from(axis).normalize());
    let mut points: Vec<Point> = (0..400)
        .map(f64::from)
        .map(|i| {
            let (height, turn) = (0.99 - i / 500.0, 2.4 * i);
            let r = (1.0 - height * height).sqrt();
            Point::from(axis * height + u * (r * turn.cos()) + v * (r * turn.sin()))
        })
        .collect();
    points.push(Point::new(1000.0, -1000.0, -1000.0));
    let mut workspace = Workspace::default();
    let found = workspace.delaunay(&points).unwrap();
    workspace.sanity_check();
    assert_eq!(workspace.order.last(), Some(&400));
    assert!(!workspace.links.edges.is_empty());
    let spokes = found.edges().iter().filter(|edge| edge[1] == 400).count();
    assert!(spokes > SIDE, "{spokes}");
}

#[test]
fn a_workspace_forgets() {
    let mut workspace = Workspace::default();
    let (large, small) = (grid(5), grid(3));
    let before = workspace.delaunay(&small).unwrap();
    workspace.delaunay(&large).unwrap();
    assert_eq!(
        workspace.delaunay(&small[..9]),
        Err(DelaunayError::Flat { points: 9, span: Span::Plane })
    );
    assert_eq!(workspace.delaunay(&small).unwrap(), before);
    workspace.sanity_check();
}

proptest! {
    /// Where the filter is sure it must be right; the points nearly share a sphere, so that it
    /// often is not, and may be far from the origin, so that centring rounds.
    #[test]
    fn the_filter_never_contradicts_the_exact_sign(
        turns in prop::array::uniform5(prop::array::uniform2(0.0..6.3_f64)),
        nudge in -50_i32..-20, nudged in any::<bool>(), shift in prop_oneof![Just(0.0), 0.0..1e6],
    ) {
        let mut points = turns.map(|[u, v]| {
            Point::new(shift + u.cos() * v.cos(), 0.3 * shift + u.sin() * v.cos(), v.sin())
        });
        if nudged {
            points[4] *= 1.0 + 2.0_f64.powi(nudge);
        }
        let [a, b, c, d, _] = &points;
        if predicates::orientation(a, b, c, d) < 0.0 {
            points.swap(0, 1);
        }
        let mut workspace = Workspace::default();
        workspace.prepare(&points).unwrap();
        let [a, b, c, d, _, _] = workspace.lifted[..] else { unreachable!() };
        let n = cells::plane(&a, &b, &c, &d);
        let q = &workspace.lifted[4];
        let value = n[0] * q[0] + n[1] * q[1] + n[2] * q[2] + n[3] * q[3] + n[4];
        let [a, b, c, d, _] = &points;
        prop_assume!(predicates::orientation(a, b, c, d) > 0.0);
        let exact = predicates::in_sphere([a, b, c, d], &points[4]);
        if value.abs() > workspace.bounds.sphere {
            prop_assert_eq!(value > 0.0, exact > 0.0);
        }
    }
}
