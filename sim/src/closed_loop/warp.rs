//! The time of the scene as the partner plays it: they may stop half-way, or go back.
//!
//! Pieces in which the rate `r = dτ/dt` goes from one value to another by the minimum-jerk step
//! `m(u) = 10u³ − 15u⁴ + 6u⁵` (Flash & Hogan 1985), so that no joint jumps in speed or in
//! acceleration: `τ(t) = τ₀ + d (r₀ u + (r₁ − r₀) M(u))`, `M(u) = ∫m = 2.5u⁴ − 3u⁵ + u⁶`, `u` the
//! part done of a piece that lasts `d`.

/// One piece: the rate goes over from one value to another.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    /// When it starts `[s]`, played.
    start: f64,
    /// The scene's time then `[s]`.
    from: f64,
    /// How long it lasts `[s]`, played; the last one lasts for ever.
    duration: f64,
    /// At its start and at its end `[-]`.
    rates: [f64; 2],
}

impl Piece {
    fn at(&self, seconds: f64) -> f64 {
        let [before, after] = self.rates;
        let elapsed = seconds - self.start;
        if before == after {
            return self.from + before * elapsed;
        }
        let u = (elapsed / self.duration).clamp(0.0, 1.0);
        let area = u.powi(4) * (2.5 + u * (u - 3.0));
        self.from + self.duration * (before * u + (after - before) * area)
    }

    fn end(&self) -> f64 {
        self.start + self.duration
    }
}

/// Seconds played → seconds of the scene.
///
/// ```
/// use handover_sim::closed_loop::TimeWarp;
/// let warp = TimeWarp::hesitation(2.0, 1.0);
/// assert_eq!(warp.scene_time(1.0), 1.0);
/// assert!((warp.scene_time(2.6) - 2.0).abs() < 1e-12); // Standing.
/// assert!((warp.scene_time(5.0) - 3.7).abs() < 1e-12); // A second and some later than planned.
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TimeWarp {
    pieces: Vec<Piece>,
}

impl TimeWarp {
    /// How long people take to stop and to go on `[s]`: within a usual reach, at accelerations of
    /// a usual reach.
    pub const BLEND: f64 = 0.3;

    /// Everything as planned.
    pub fn none() -> Self {
        let always = Piece { start: 0.0, from: 0.0, duration: f64::INFINITY, rates: [1.0, 1.0] };
        Self { pieces: vec![always] }
    }

    /// The partner stops at `scene_time` `[s]`, stands for `pause` `[s]`, and goes on.
    pub fn hesitation(scene_time: f64, pause: f64) -> Self {
        let mut warp = Self::none();
        // Half of the blend's length goes by in the scene before they stand.
        warp.turn(scene_time - Self::BLEND / 2.0, Self::BLEND, 0.0);
        warp.turn_in(pause, Self::BLEND, 1.0);
        warp
    }

    /// The partner stops at `scene_time` `[s]`, and goes back the way they came; their time runs
    /// backwards for good, so that they stand there, alive.
    pub fn withdrawal(scene_time: f64) -> Self {
        let mut warp = Self::none();
        warp.turn(scene_time - Self::BLEND / 2.0, Self::BLEND, 0.0);
        warp.turn_in(0.0, Self::BLEND, -1.0);
        warp
    }

    /// From `start` `[s]` on the rate goes over to `rate` within `blend` `[s]`, and stays so.
    fn turn(&mut self, start: f64, blend: f64, rate: f64) {
        let last = self.last();
        let start = start.max(last.start);
        let before = last.rates[1];
        let from = last.at(start);
        if let Some(last) = self.pieces.last_mut() {
            last.duration = start - last.start;
        }
        let turning = Piece { start, from, duration: blend, rates: [before, rate] };
        let (start, from) = (turning.end(), turning.at(turning.end()));
        let steady = Piece { start, from, duration: f64::INFINITY, rates: [rate, rate] };
        self.pieces.extend([turning, steady]);
    }

    /// [`Self::turn`], so long after the rate has become steady.
    fn turn_in(&mut self, wait: f64, blend: f64, rate: f64) {
        self.turn(self.last().start + wait, blend, rate);
    }

    fn last(&self) -> Piece {
        // There is always one: `none` makes it, and nothing takes it away.
        self.pieces[self.pieces.len() - 1]
    }

    /// The scene's time `[s]` after so many seconds; before 0 as planned.
    pub fn scene_time(&self, seconds: f64) -> f64 {
        let after = self.pieces.partition_point(|piece| piece.start <= seconds);
        self.pieces[after.saturating_sub(1)].at(seconds)
    }

    /// When the scene's time is first `scene_time` `[s]`, to a nanosecond; `None`: never.
    pub fn when(&self, scene_time: f64) -> Option<f64> {
        let piece = self.pieces.iter().find(|piece| {
            let end = if piece.duration.is_finite() {
                piece.at(piece.end())
            } else {
                f64::INFINITY * piece.rates[1]
            };
            piece.rates != [0.0, 0.0] && end >= scene_time
        })?;
        let mut low = piece.start;
        let mut high = if piece.duration.is_finite() {
            piece.end()
        } else {
            low + (scene_time - piece.from) / piece.rates[1]
        };
        // Rates of a piece that comes as far have one sign, so its time only rises.
        while high - low > 1e-9 {
            let middle = low.midpoint(high);
            if piece.at(middle) < scene_time { low = middle } else { high = middle }
        }
        Some(high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rate and its slope never jump: differences of the time shrink with the step.
    #[track_caller]
    fn check_smooth(warp: &TimeWarp) {
        let step = 1e-3;
        let rate = |t: f64| (warp.scene_time(t + step) - warp.scene_time(t)) / step;
        let mut t = 0.0;
        while t < 8.0 {
            // 15/8 is the steepest slope of the step, over the shortest blend; twice that from 1 to −1.
            let slope = (rate(t + step) - rate(t)) / step;
            assert!(slope.abs() < 1.9 / TimeWarp::BLEND, "{t}: {slope}");
            t += step;
        }
    }

    #[test]
    fn who_hesitates_stands_and_goes_on_later() {
        let warp = TimeWarp::hesitation(2.0, 1.0);
        check_smooth(&warp);
        assert!([2.2, 2.7, 3.1].iter().all(|t| (warp.scene_time(*t) - 2.0).abs() < 1e-9));
        let late = 1.0 + TimeWarp::BLEND;
        assert!((warp.when(2.5).unwrap() - (2.5 + late)).abs() < 1e-6);
        assert!((warp.when(1.0).unwrap() - 1.0).abs() < 1e-6);
        assert_eq!(TimeWarp::none().when(3.0), Some(3.0));
    }

    #[test]
    fn who_withdraws_goes_no_farther_and_back() {
        let warp = TimeWarp::withdrawal(2.0);
        check_smooth(&warp);
        let farthest = (0..800).map(|k| warp.scene_time(f64::from(k) * 0.01)).fold(0.0, f64::max);
        assert!((farthest - 2.0).abs() < 1e-3, "{farthest}");
        assert_eq!(warp.when(2.1), None);
        assert!(warp.scene_time(6.0) < 0.0);
        assert!((warp.when(1.9).unwrap() - 1.9).abs() < 0.1);
    }

    #[test]
    fn what_comes_before_the_start_stops_there() {
        let warp = TimeWarp::hesitation(0.0, 0.5);
        check_smooth(&warp);
        assert_eq!(warp.scene_time(0.0), 0.0);
    }
}
