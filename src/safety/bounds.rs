//! How far derivatives can get from what they are at samples, between the samples.
//!
//! A value with second derivative at most `f″` is nowhere farther than `h²/8 f″` from the chord
//! between samples `h` apart. The coordinates of a plan are polynomials `y` whose fourth and fifth
//! derivative are bounded exactly, so that samples bound all lower ones. A direction is
//! `n = y / ρ`, `ρ² = s = y·y`. From `y⁽ᵏ⁾ = Σ (k over j) ρ⁽ʲ⁾ n⁽ᵏ⁻ʲ⁾` the part of `n⁽ᵏ⁾` across `n`
//! is at most `bₖ + Σ (k over j) qⱼ nₖ₋ⱼ` (sum over `0 < j < k`), and from `(n·n)⁽ᵏ⁾ = 0` the part
//! along it at most `½ Σ (k over j) nⱼ nₖ₋ⱼ`, with `bₖ = |y⁽ᵏ⁾| / ρ`, `qₖ = |ρ⁽ᵏ⁾| / ρ`.
//!
//! Knows nothing of limits.

use super::jet::Jet;

/// Least `|y|²` of a direction before it is normalised: nearer to zero, directions turn fast.
const LEAST_SQUARE: f64 = 0.16;

/// What a coordinate was at the samples of a piece, at most.
#[derive(Debug, Clone, Copy)]
pub(super) struct Peaks {
    /// Least `|y|²`.
    least: f64,
    /// Squares of `y` and its derivatives.
    squares: [f64; 4],
    /// Derivatives of `s = y·y`.
    radial: [f64; 3],
}

impl Peaks {
    /// Before the first sample.
    pub(super) const NONE: Self =
        Self { least: f64::INFINITY, squares: [0.0; 4], radial: [0.0; 3] };

    /// Takes a sample.
    ///
    /// - `s`: `y·y` and its derivatives.
    pub(super) fn take(&mut self, y: &Jet, s: &[f64; 4]) {
        self.least = self.least.min(s[0]);
        self.squares[0] = self.squares[0].max(s[0]);
        for (most, value) in self.squares[1..].iter_mut().zip(&y[1..]) {
            *most = most.max(value.norm_squared());
        }
        for (most, value) in self.radial.iter_mut().zip(&s[1..]) {
            *most = most.max(value.abs());
        }
    }

    /// Bounds of `|y|`, …, `|y⁗′|` in the whole piece.
    ///
    /// - `steepest`: bounds of the fourth and fifth derivative.
    /// - `step`: between samples `[s]`.
    fn polynomial(&self, steepest: [f64; 2], step: f64) -> [f64; 6] {
        let (chord, [y4, y5]) = (step * step / 8.0, steepest);
        let [y0, y1, y2, y3] = self.squares.map(f64::sqrt);
        let (y3, y2) = (y3 + chord * y5, y2 + chord * y4);
        [y0 + chord * y2, y1 + chord * y3, y2, y3, y4, y5]
    }

    /// Bounds of the third, fourth and fifth derivative of a place in the whole piece.
    ///
    /// - `steepest`, `step`: as for [`Self::polynomial`].
    pub(super) fn of_place(&self, steepest: [f64; 2], step: f64) -> [f64; 3] {
        let [.., y3, y4, y5] = self.polynomial(steepest, step);
        [y3, y4, y5]
    }

    /// The same of a direction; none if it may come too near zero.
    ///
    /// - `steepest`, `step`: as for [`Self::polynomial`].
    pub(super) fn of_direction(&self, steepest: [f64; 2], step: f64) -> Option<[f64; 3]> {
        let chord = step * step / 8.0;
        let [y0, y1, y2, y3, y4, y5] = self.polynomial(steepest, step);
        let s5 = 2.0 * (y0 * y5 + 5.0 * y1 * y4 + 10.0 * y2 * y3);
        let s4 = 2.0 * (y0 * y4 + 4.0 * y1 * y3 + 3.0 * y2 * y2);
        let s3 = self.radial[2] + chord * s5;
        let s2 = self.radial[1] + chord * s4;
        let s1 = self.radial[0] + chord * s3;
        let s0 = self.least - chord * s2;
        if s0.is_nan() || s0 < LEAST_SQUARE {
            return None;
        }
        // ρ ρ′ = s′/2, and its derivatives.
        let half = 0.5 / s0;
        let q1 = s1 * half;
        let q2 = s2 * half + q1 * q1;
        let q3 = s3 * half + 3.0 * q1 * q2;
        let q4 = s4 * half + 4.0 * q1 * q3 + 3.0 * q2 * q2;
        let inverse = 1.0 / s0.sqrt();
        let [b1, b2, b3, b4, b5] = [y1, y2, y3, y4, y5].map(|y| y * inverse);
        let norm = |across: f64, along: f64| (across * across + along * along).sqrt();
        let n1 = b1;
        let n2 = norm(b2 + 2.0 * q1 * n1, n1 * n1);
        let n3 = norm(b3 + 3.0 * (q1 * n2 + q2 * n1), 3.0 * n1 * n2);
        let across = b4 + 4.0 * (q1 * n3 + q3 * n1) + 6.0 * q2 * n2;
        let n4 = norm(across, 4.0 * n1 * n3 + 3.0 * n2 * n2);
        let across = b5 + 5.0 * (q1 * n4 + q4 * n1) + 10.0 * (q2 * n3 + q3 * n2);
        let n5 = norm(across, 5.0 * n1 * n4 + 10.0 * n2 * n3);
        Some([n3, n4, n5])
    }
}

#[cfg(test)]
mod tests {
    use super::super::jet::{normalised, polynomial, squared};
    use super::*;
    use crate::geometry::Vector;

    #[test]
    fn derivatives_are_within_their_bounds_between_samples() {
        let mut tightest = [0.0f64; 3];
        for seed in 0..400 {
            let random = |k: u32| {
                let phase = f64::from(seed * 31 + k * 7);
                let part = |by: f64| (phase * by).sin();
                Vector::new(part(1.3), part(2.9), part(5.3))
            };
            // Near the start like a turning unit vector, or like anything.
            let consistent = seed % 2 == 0;
            let turn = random(1).cross(&Vector::x()) * 4.0;
            let curve = [
                Vector::x(),
                if consistent { turn } else { random(1) * 3.0 },
                random(2) * 6.0 - Vector::x() * (0.5 * turn.norm_squared()),
                random(3) * 60.0,
                random(4) * 500.0,
                random(5) * 4000.0,
            ];
            let (lead, count) = (0.06, 4 + seed % 5);
            let step = lead / f64::from(count);
            let mut peaks = Peaks::NONE;
            for k in 0..=count {
                let y = polynomial(&curve, step * f64::from(k));
                peaks.take(&y, &squared(&y));
            }
            let fourth = |t: f64| (curve[4] * 24.0 + curve[5] * (120.0 * t)).norm();
            let steepest = [fourth(0.0).max(fourth(lead)), (curve[5] * 120.0).norm()];
            let place = peaks.of_place(steepest, step);
            let Some(direction) = peaks.of_direction(steepest, step) else { continue };
            let jet = |t: f64| polynomial(&curve, t);
            let turned = |t: f64| normalised(&jet(t), &squared(&jet(t)));
            for (bound, at) in [(place, &jet as &dyn Fn(f64) -> Jet), (direction, &turned)] {
                for k in 0..=600 {
                    let (t, h) = (lead * (0.01 + 0.98 * f64::from(k) / 600.0), 1e-4);
                    let (before, now, after) = (at(t - h)[3], at(t)[3], at(t + h)[3]);
                    let sizes = [
                        now.norm(),
                        ((after - before) / (2.0 * h)).norm(),
                        ((after - now * 2.0 + before) / (h * h)).norm(),
                    ];
                    for order in 0..3 {
                        let share = sizes[order] / bound[order];
                        assert!(share < 1.0 + 1e-3, "{seed} {order}: {share}");
                        tightest[order] = tightest[order].max(share);
                    }
                }
            }
        }
        assert!(tightest.iter().all(|share| *share > 0.9), "{tightest:?}");
        let mut through_zero = Peaks::NONE;
        let curve = [Vector::x(), Vector::x() * -20.0, Vector::y(), Vector::z(), Vector::z() * 0.0];
        let curve = [curve[0], curve[1], curve[2], curve[3], curve[4], curve[4]];
        for t in [0.0, 0.1] {
            let y = polynomial(&curve, t);
            through_zero.take(&y, &squared(&y));
        }
        assert!(through_zero.of_direction([0.0; 2], 0.1).is_none());
    }
}
