//! Structure: the links between cells, and the points on which the walk or the cavity could trip.

use super::cells::{Cell, FREE, Plane, Side};
use super::dimension::Dimension;
use super::links::SIDE;
use super::*;
use proptest::prelude::*;
use std::array::from_fn;

impl<const D: usize, const N: usize> Triangulation<D, N> {
    /// Panics unless neighbours know each other, share a facet and see it from opposite sides.
    pub(super) fn sanity_check(&self) {
        for (index, cell) in self.cells.iter().enumerate() {
            if cell.vertices[0] == FREE {
                continue;
            }
            for facet in 0..N {
                let across = cell.neighbours[facet];
                let other = &self.cells[across.cell() as usize];
                assert_ne!(other.vertices[0], FREE);
                assert_eq!(other.neighbours[across.facet()], Side::new(index as u32, facet));
                let corners = |cell: &Cell<N>, facet: usize| {
                    let mut corners = Self::facets(cell.vertices)[facet];
                    let turned =
                        (0..D * D).filter(|k| corners[k / D] > corners[k % D] && k / D < k % D);
                    let odd = turned.count() % 2 == 1;
                    corners.sort_unstable();
                    (corners, odd)
                };
                let (one, odd) = corners(cell, facet);
                assert_eq!(corners(other, across.facet()), (one, !odd));
            }
        }
    }
}

fn check(points: &[Point]) -> Delaunay {
    let mut workspace = Workspace::default();
    let found = workspace.delaunay(points).unwrap();
    workspace.0.sanity_check();
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
    workspace.0.sanity_check();
    assert_eq!(workspace.0.order.last(), Some(&400));
    assert!(!workspace.0.links.ridges.is_empty());
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
    workspace.0.sanity_check();
}

fn check_4d(points: &[[f64; 4]]) -> Delaunay<5> {
    let mut workspace = Workspace::default();
    let found = workspace.delaunay_4d(points).unwrap();
    workspace.0.sanity_check();
    found
}

fn scattered_4d(count: usize) -> Vec<[f64; 4]> {
    let fraction = |i: usize, prime: f64| ((i * i) as f64 * prime.sqrt()).fract();
    (1..=count).map(|i| [2.0, 3.0, 5.0, 7.0].map(|prime| fraction(i, prime))).collect()
}

#[test]
fn links_are_mutual_in_four_dimensions() {
    let cells = |side: usize| {
        let place = move |i: usize| [1, side, side.pow(2), side.pow(3)].map(|n| i / n % side);
        (0..side.pow(4)).map(move |i| place(i).map(|c| c as f64)).collect::<Vec<_>>()
    };
    for side in 2..4 {
        assert!(check_4d(&cells(side)).duplicates().is_empty());
    }
    for count in [5, 6, 7, 20, 300] {
        check_4d(&scattered_4d(count));
    }
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
        check_filter(points.map(|p| [p.x, p.y, p.z]), |[a, b, c, d, p]| {
            Triangulation::in_sphere([a, b, c, d], p)
        });
    }

    #[test]
    fn the_filter_never_contradicts_the_exact_sign_in_four_dimensions(
        turns in prop::array::uniform6(prop::array::uniform3(0.0..6.3_f64)),
        nudge in -50_i32..-20, nudged in any::<bool>(), shift in prop_oneof![Just(0.0), 0.0..1e6],
    ) {
        let mut points = turns.map(|[u, v, w]| {
            let ring = w.cos();
            [
                shift + ring * u.cos() * v.cos(),
                0.3 * shift + ring * u.sin() * v.cos(),
                ring * v.sin(),
                w.sin(),
            ]
        });
        if nudged {
            points[5] = points[5].map(|c| c * (1.0 + 2.0_f64.powi(nudge)));
        }
        check_filter(points, four::exact_in_sphere);
    }

    #[test]
    fn any_doubles_in_four_dimensions(
        points in prop::collection::vec(prop::array::uniform4(-1.0..1.0_f64), 5..24),
        scale in -140_i32..150, nearly_flat in any::<bool>(),
    ) {
        let scale = 1.1 * 2.0_f64.powi(scale);
        let place = |[x, y, z, v]: [f64; 4]| {
            [x, y, z, x + y + z + if nearly_flat { 0.0 } else { v }].map(|c| c * scale)
        };
        let points: Vec<[f64; 4]> = points.into_iter().map(place).collect();
        if delaunay_4d(&points).is_err_and(|error| matches!(error, DelaunayError::Flat { .. })) {
            prop_assume!(!nearly_flat);
        }
        let found = check_4d(&points);
        let mut used = vec![false; points.len()];
        for simplex in found.simplices() {
            let [a, b, c, d, e] = simplex.map(|v| &points[v as usize]);
            prop_assert!(Triangulation::orientation([a, b, c, d, e]) > 0.0);
            for p in &points {
                prop_assert!(four::exact_in_sphere([a, b, c, d, e, p]) <= 0.0);
            }
            simplex.iter().for_each(|&v| used[v as usize] = true);
        }
        prop_assert!(used.into_iter().all(|used| used));
    }
}

/// The last of the points against the sphere of the others, and their orientation.
#[track_caller]
fn check_filter<const D: usize, const N: usize, const K: usize>(
    mut points: [[f64; D]; K],
    in_sphere: impl Fn([&[f64; D]; K]) -> f64,
) where
    Triangulation<D, N>: Dimension<D, N>,
{
    let corners = |points: &[[f64; D]; K]| Triangulation::orientation(from_fn(|i| &points[i]));
    if corners(&points) < 0.0 {
        points.swap(0, 1);
    }
    let exact = corners(&points);
    let mut made = Triangulation::<D, N>::default();
    made.prepare(points.into_iter()).unwrap();
    let lifted: [&[f64; N]; N] = from_fn(|i| &made.lifted[i]);
    let rounded = Triangulation::determinant(lifted);
    if rounded.abs() > made.bounds.solid {
        assert_eq!(rounded > 0.0, exact > 0.0);
    }
    if exact == 0.0 {
        return;
    }
    let rounded = Plane::through::<D>(lifted).value(&made.lifted[N]);
    if rounded.abs() > made.bounds.sphere {
        let exact = in_sphere(points.each_ref());
        assert_eq!(rounded > 0.0, exact > 0.0);
    }
}
