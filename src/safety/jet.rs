//! Values with their first three derivatives by time, exact.
//!
//! Truncated Taylor arithmetic: sums by linearity, products by Leibniz' rule, `s^(−1/2)` by
//! differentiating `2 s w′ = −s′ w`.

use crate::geometry::Vector;

/// A vector and its first, second and third derivative by time.
pub(super) type Jet = [Vector; 4];

/// `y · y` with its derivatives.
pub(super) fn squared(y: &Jet) -> [f64; 4] {
    let [y0, y1, y2, y3] = y;
    [
        y0.dot(y0),
        2.0 * y0.dot(y1),
        2.0 * (y0.dot(y2) + y1.dot(y1)),
        2.0 * (y0.dot(y3) + 3.0 * y1.dot(y2)),
    ]
}

/// `y / |y|` with its derivatives. Not finite where `y` is zero.
///
/// - `square`: of `y`, as of [`squared`].
pub(super) fn normalised(y: &Jet, square: &[f64; 4]) -> Jet {
    let ([y0, y1, y2, y3], [s0, s1, s2, s3]) = (y, square);
    let half = -0.5 / s0;
    let w0 = 1.0 / s0.sqrt();
    let w1 = half * s1 * w0;
    let w2 = half * (s2 * w0 + 3.0 * s1 * w1);
    let w3 = half * (s3 * w0 + 4.0 * s2 * w1 + 5.0 * s1 * w2);
    [
        y0 * w0,
        y1 * w0 + y0 * w1,
        y2 * w0 + y1 * (2.0 * w1) + y0 * w2,
        y3 * w0 + y2 * (3.0 * w1) + y1 * (3.0 * w2) + y0 * w3,
    ]
}

/// The quintic through place, velocity and acceleration at both ends, as coefficients of powers of
/// time: `[a, b, …]` is `a + b t + …`.
///
/// - `start`, `end`: value and first two derivatives.
/// - `duration`: `[s]`, > 0.
pub(super) fn quintic(start: &[Vector; 3], end: &[Vector; 3], duration: f64) -> [Vector; 6] {
    let t = duration;
    let [p0, v0, a0] = start;
    let [p1, v1, a1] = end;
    let (way, v0t, v1t) = (p1 - p0, v0 * t, v1 * t);
    let (a0t, a1t) = (a0 * (t * t), a1 * (t * t));
    let cube = 0.5 / (t * t * t);
    [
        *p0,
        *v0,
        a0 * 0.5,
        (way * 20.0 - v1t * 8.0 - v0t * 12.0 - a0t * 3.0 + a1t) * cube,
        (way * -30.0 + v1t * 14.0 + v0t * 16.0 + a0t * 3.0 - a1t * 2.0) * (cube / t),
        (way * 12.0 - (v0t + v1t) * 6.0 - a0t + a1t) * (cube / (t * t)),
    ]
}

/// A polynomial's value and derivatives at a time `[s]`.
pub(super) fn polynomial(c: &[Vector; 6], t: f64) -> Jet {
    [
        c[0] + (c[1] + (c[2] + (c[3] + (c[4] + c[5] * t) * t) * t) * t) * t,
        c[1] + (c[2] * 2.0 + (c[3] * 3.0 + (c[4] * 4.0 + c[5] * (5.0 * t)) * t) * t) * t,
        c[2] * 2.0 + (c[3] * 6.0 + (c[4] * 12.0 + c[5] * (20.0 * t)) * t) * t,
        c[3] * 6.0 + (c[4] * 24.0 + c[5] * (60.0 * t)) * t,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vector(seed: f64) -> Vector {
        Vector::new((3.0 * seed).sin(), (5.0 * seed).cos(), (7.0 * seed + 1.0).sin())
    }

    #[test]
    fn jets_are_those_of_finite_differences() {
        let curve = [0.3, 1.1, 2.7, 0.9, 4.2, 5.5].map(vector);
        let raw = |t: f64| polynomial(&curve, t);
        let jet = |t: f64| normalised(&raw(t), &squared(&raw(t)));
        let h = 1e-5;
        for t in [0.0, 0.1, 0.33] {
            assert!((jet(t)[0].norm() - 1.0).abs() < 1e-15);
            for order in 0..3 {
                let slope = (jet(t + h)[order] - jet(t - h)[order]) / (2.0 * h);
                let off = (slope - jet(t)[order + 1]).norm();
                assert!(off < 1e-5 * (1.0 + slope.norm()), "{t} {order}: {off}");
            }
        }
    }

    #[test]
    fn a_quintic_goes_through_both_its_ends() {
        let (start, end) = ([0.3, 1.1, 2.7].map(vector), [0.9, 4.2, 5.5].map(vector));
        let curve = quintic(&start, &end, 0.7);
        let (first, last) = (polynomial(&curve, 0.0), polynomial(&curve, 0.7));
        for order in 0..3 {
            assert!((first[order] - start[order]).norm() < 1e-14);
            assert!((last[order] - end[order]).norm() < 1e-12);
        }
    }
}
