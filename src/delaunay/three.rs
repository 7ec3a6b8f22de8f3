//! Three dimensions. Exact signs: the adaptive expansions of Shewchuk (1997), by the crate
//! `robust`, in the orientation used here.
//!
//! Exact for the coordinates [`super::MAGNITUDES`] allows.

use super::dimension::{Dimension, Lifted};
use super::triangulation::Triangulation;
use robust::{Coord, Coord3D};

fn coord(&[x, y, z]: &[f64; 3]) -> Coord3D<f64> {
    Coord3D { x, y, z }
}

impl Dimension<3, 4> for Triangulation<3, 4> {
    const SOLID: f64 = 1024.0;
    const SPHERE: f64 = 8192.0;

    #[inline]
    fn orientation([a, b, c, d]: [&[f64; 3]; 4]) -> f64 {
        // NOTE: `robust` calls the mirror image positive.
        -robust::orient3d(coord(a), coord(b), coord(c), coord(d))
    }

    #[inline]
    fn in_sphere([a, b, c, d]: [&[f64; 3]; 4], p: &[f64; 3]) -> f64 {
        // NOTE: `robust` expects the mirror image, hence the exchange of the first two.
        robust::insphere(coord(b), coord(a), coord(c), coord(d), coord(p))
    }

    fn independent(corners: &[&[f64; 3]], p: &[f64; 3]) -> bool {
        match corners {
            [a] => *a != p,
            // On one line exactly if the shadows on the three coordinate planes are.
            [a, b] => [[0, 1], [1, 2], [2, 0]].into_iter().any(|[i, j]| {
                let shadow = |p: &[f64; 3]| Coord { x: p[i], y: p[j] };
                robust::orient2d(shadow(a), shadow(b), shadow(p)) != 0.0
            }),
            [a, b, c] => Self::orientation([a, b, c, p]) != 0.0,
            _ => corners.is_empty(),
        }
    }

    #[inline(always)]
    fn determinant([a, b, c, d]: [&Lifted<4>; 4]) -> f64 {
        let minus = |p: &Lifted<4>| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
        let (b, c, d) = (minus(b), minus(c), minus(d));
        b[0] * (c[1] * d[2] - c[2] * d[1])
            + b[1] * (c[2] * d[0] - c[0] * d[2])
            + b[2] * (c[0] * d[1] - c[1] * d[0])
    }

    /// Expanded by the minors of the first two rows.
    #[inline(always)]
    fn normal([q, a, b, c]: [&Lifted<4>; 4]) -> Lifted<4> {
        let minus = |p: &Lifted<4>| [p[0] - q[0], p[1] - q[1], p[2] - q[2], p[3] - q[3]];
        let (a, b, c) = (minus(a), minus(b), minus(c));
        let minor = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
        let (xy, xz, xw) = (minor(0, 1), minor(0, 2), minor(0, 3));
        let (yz, yw, zw) = (minor(1, 2), minor(1, 3), minor(2, 3));
        [
            c[1] * zw - c[2] * yw + c[3] * yz,
            c[2] * xw - c[0] * zw - c[3] * xz,
            c[0] * yw - c[1] * xw + c[3] * xy,
            c[1] * xz - c[0] * yz - c[2] * xy,
        ]
    }
}
#[cfg(test)]
mod tests {
    use super::*;
    use crate::delaunay::{MAGNITUDES, power_of_two};
    use crate::geometry::Point;
    use proptest::prelude::*;

    fn orientation(a: &Point, b: &Point, c: &Point, d: &Point) -> f64 {
        Triangulation::orientation([a, b, c, d].map(|p| p.coords.as_ref()))
    }

    fn in_sphere(simplex: [&Point; 4], p: &Point) -> f64 {
        Triangulation::in_sphere(simplex.map(|p| p.coords.as_ref()), p.coords.as_ref())
    }

    fn collinear(a: &Point, b: &Point, c: &Point) -> bool {
        !Triangulation::independent(&[a, b].map(|p| p.coords.as_ref()), c.coords.as_ref())
    }

    #[test]
    fn a_right_handed_corner_is_positive_and_holds_its_centre() {
        let [a, b, c, d] =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point::from);
        assert!(orientation(&a, &b, &c, &d) > 0.0);
        assert!(orientation(&b, &a, &c, &d) < 0.0);
        let sphere = [&a, &b, &c, &d];
        assert!(in_sphere(sphere, &Point::new(0.5, 0.5, 0.5)) > 0.0);
        assert!(in_sphere(sphere, &Point::new(0.9, 0.9, 0.9)) > 0.0);
        assert!(in_sphere(sphere, &Point::new(1.1, 1.1, 1.1)) < 0.0);
        assert_eq!(in_sphere(sphere, &Point::new(1.0, 1.0, 1.0)), 0.0);
    }

    #[test]
    fn three_on_a_skew_line_are_collinear_and_no_others() {
        let at = |t: f64| Point::new(1.0 + t, 2.0 - 3.0 * t, 0.5 * t);
        assert!(collinear(&at(0.0), &at(2.0), &at(-5.0)));
        assert!(collinear(&at(1.0), &at(1.0), &at(2.0)));
        let mut off = at(2.0);
        off.z = off.z.next_up();
        assert!(!collinear(&at(0.0), &off, &at(-5.0)));
    }

    /// Signs must not change under powers of two, which are exact unless something under- or
    /// overflows; the points nearly share a sphere or a plane and use all 53 bits.
    fn check_scale(points: &[Point; 5], exponent: i64) {
        let factor = power_of_two(exponent);
        let scaled = points.map(|p| p * factor);
        for p in &scaled {
            for c in p.coords.iter() {
                assert!(*c == 0.0 || (MAGNITUDES[0]..=MAGNITUDES[1]).contains(&c.abs()));
            }
        }
        let sphere = |[a, b, c, d, e]: &[Point; 5]| in_sphere([a, b, c, d], e);
        let solid = |[a, b, c, d, _]: &[Point; 5]| orientation(a, b, c, d);
        let sign = |x: f64| (x > 0.0) as i8 - (x < 0.0) as i8;
        assert_eq!(sign(sphere(points)), sign(sphere(&scaled)));
        assert_eq!(sign(solid(points)), sign(solid(&scaled)));
    }

    proptest! {
        #[test]
        fn signs_are_exact_at_both_ends_of_the_range(
            turns in prop::array::uniform5(prop::array::uniform2(0.0..6.3_f64)),
            shift in prop::array::uniform3(2.5..3.0_f64),
            flat in any::<bool>(),
            nudge in -2_i64..=2,
        ) {
            let mut points = turns.map(|[u, v]| {
                let v = if flat { 0.7 } else { v };
                Point::new(
                    shift[0] + u.cos() * v.cos(),
                    shift[1] + u.sin() * v.cos(),
                    shift[2] + v.sin(),
                )
            });
            points[4].x = f64::from_bits((points[4].x.to_bits() as i64 + nudge) as u64);
            check_scale(&points, -160);
            check_scale(&points, 158);
        }
    }
}
