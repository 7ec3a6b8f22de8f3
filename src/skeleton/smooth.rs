//! Smoothing without delay: each joint's path through a Gaussian window in time.
//!
//! `p̃(t) = Σₖ w(tₖ − t) pₖ / Σₖ w(tₖ − t)`, `w(τ) = exp(−τ²/2σ²)` (Nadaraya 1964), over the real
//! stamps, so jitter and gaps count as they are. For recordings; a live stream needs a causal
//! filter.

use super::Sequence;
use crate::geometry::{Point, Vector};

impl Sequence {
    /// The motion through a Gaussian window of standard deviation `sigma` `[s]`, cut at 3 σ.
    ///
    /// Noise of neighbouring frames averages out, a peak of width σ loses height. Zero or less
    /// leaves the motion as it is.
    pub fn smoothed(&self, sigma: f64) -> Self {
        // NaN must not smooth either.
        if sigma.is_nan() || sigma <= 0.0 {
            return self.clone();
        }
        let seconds: Vec<f64> = self.stamps().map(|stamp| stamp.seconds()).collect();
        self.map_frames(|at, points| {
            let now = seconds[at];
            let first = seconds.partition_point(|t| *t < now - 3.0 * sigma);
            let last = seconds.partition_point(|t| *t <= now + 3.0 * sigma);
            let weights: Vec<f64> = seconds[first..last]
                .iter()
                .map(|t| (-0.5 * ((t - now) / sigma).powi(2)).exp())
                .collect();
            let total: f64 = weights.iter().sum();
            for (joint, point) in points.iter_mut().enumerate() {
                let window = self.frames()[first..last].iter().zip(&weights);
                let sum: Vector = window.map(|(f, w)| f.positions[joint].coords * *w).sum();
                *point = Point::from(sum / total);
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Frame, Skeleton};
    use super::*;
    use crate::time::Stamp;

    fn line(noise: f64) -> Sequence {
        let frame = |k: i64| {
            let off = if k % 2 == 0 { noise } else { -noise };
            let p = Point::new(k as f64 * 0.01 + off, 1.0, -off);
            Frame { stamp: Stamp(k * 33_000_000), positions: vec![p; 15].into() }
        };
        Sequence::new(Skeleton::nite(), (0..60).map(frame).collect()).unwrap()
    }

    #[test]
    fn a_straight_path_stays_and_jitter_goes() {
        let worst = |a: &Sequence| {
            let inner = 10..50;
            inner
                .map(|k| (a.frames()[k].positions[0] - line(0.0).frames()[k].positions[0]).norm())
                .fold(0.0, f64::max)
        };
        assert!(worst(&line(0.0).smoothed(0.1)) < 1e-12);
        assert!(worst(&line(0.02).smoothed(0.1)) < 1e-4);
        assert_eq!(line(0.02).smoothed(0.0), line(0.02));
    }
}
