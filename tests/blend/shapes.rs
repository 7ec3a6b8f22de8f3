//! Made-up shapes.

use handover_mesh::Point;
use handover_mesh::blend::Triangles;
use nalgebra::{Rotation3, Vector3};

/// Cross-sections of a bar, and vertices around each.
pub const SECTIONS: u32 = 33;
pub const AROUND: u32 = 8;

/// A bar along x, open at both ends, turned about its axis by an angle that grows along it.
pub fn bar(twist: f64) -> Vec<Point> {
    let vertex = |section: u32, around: u32| {
        let along = f64::from(section) / f64::from(SECTIONS - 1);
        let angle = std::f64::consts::TAU * f64::from(around) / f64::from(AROUND) + twist * along;
        Point::new(4.0 * along, 0.5 * angle.cos(), 0.3 * angle.sin())
    };
    (0..SECTIONS).flat_map(|section| (0..AROUND).map(move |at| vertex(section, at))).collect()
}

/// The same bar, its elliptic sections turned rigidly.
pub fn turned_bar(twist: f64) -> Vec<Point> {
    let straight = bar(0.0);
    let turned =
        straight.iter().map(|place| Rotation3::new(Vector3::x() * twist * place.x / 4.0) * place);
    turned.collect()
}

pub fn bar_triangles() -> Triangles {
    let corners = (0..SECTIONS - 1).flat_map(|s| (0..AROUND).map(move |j| (s, j)));
    let corners = corners.flat_map(|(s, j)| {
        let at = |s: u32, j: u32| s * AROUND + j % AROUND;
        let [a, b, c, d] = [at(s, j), at(s + 1, j), at(s + 1, j + 1), at(s, j + 1)];
        [[a, c, b], [a, d, c]]
    });
    Triangles::new((SECTIONS * AROUND) as usize, corners.collect()).unwrap()
}
