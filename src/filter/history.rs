//! The last moments of a person, from which any instant among them is interpolated.

use super::seconds_since;
use crate::geometry::Point;
use crate::time::Stamp;

/// How many poses are kept.
const KEPT: usize = 128;
/// Poses are this far apart at least `[s]`; so [`KEPT`] of them last 0.64 s at any rate.
const APART: f64 = 0.005;

/// A ring of poses with rising stamps.
#[derive(Debug, Clone)]
pub(super) struct History {
    joints: usize,
    stamps: Box<[Stamp]>,
    places: Box<[Point]>,
    /// Where the oldest lies, and how many there are.
    oldest: usize,
    len: usize,
}

impl History {
    pub(super) fn new(joints: usize) -> Self {
        Self {
            joints,
            stamps: vec![Stamp(0); KEPT].into(),
            places: vec![Point::origin(); KEPT * joints].into(),
            oldest: 0,
            len: 0,
        }
    }

    pub(super) fn forget(&mut self) {
        self.len = 0;
    }

    /// Adds a pose later than all others; where the last two came in close succession the newest
    /// gives way.
    pub(super) fn push(&mut self, stamp: Stamp, places: impl Iterator<Item = Point>) {
        let crowded = self.len >= 2
            && seconds_since(self.stamp(self.len - 1), self.stamp(self.len - 2)) < APART;
        if crowded {
            self.len -= 1;
        } else if self.len == KEPT {
            self.oldest = (self.oldest + 1) % KEPT;
            self.len -= 1;
        }
        let slot = self.slot(self.len);
        self.stamps[slot] = stamp;
        let slots = &mut self.places[slot * self.joints..][..self.joints];
        slots.iter_mut().zip(places).for_each(|(slot, place)| *slot = place);
        self.len += 1;
    }

    /// The pose at an instant up to the newest, held before the oldest; nothing where there is none.
    pub(super) fn at(&self, stamp: Stamp, out: &mut [Point]) {
        if self.len == 0 {
            return;
        }
        let after = (0..self.len).rev().take_while(|&k| self.stamp(k) >= stamp).last();
        let after = after.unwrap_or(self.len - 1);
        let before = after.saturating_sub(1);
        let step = seconds_since(self.stamp(after), self.stamp(before));
        let part = if step > 0.0 {
            (seconds_since(stamp, self.stamp(before)) / step).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let between = self.pose(before).iter().zip(self.pose(after));
        for (place, (a, b)) in out.iter_mut().zip(between) {
            *place = a + (b - a) * part;
        }
    }

    fn slot(&self, at: usize) -> usize {
        (self.oldest + at) % KEPT
    }

    fn stamp(&self, at: usize) -> Stamp {
        self.stamps[self.slot(at)]
    }

    fn pose(&self, at: usize) -> &[Point] {
        &self.places[self.slot(at) * self.joints..][..self.joints]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One joint that moves 1 m a second, seen every `step` ms for 3 s.
    fn history(step: i64) -> History {
        let mut history = History::new(1);
        for ms in (0..=3_000).step_by(step as usize) {
            let place = Point::new(ms as f64 / 1e3, 0.0, 0.0);
            history.push(Stamp(ms * 1_000_000), [place].into_iter());
        }
        history
    }

    #[test]
    fn the_last_moments_are_kept_at_any_rate() {
        for step in [1, 3, 8, 33, 66] {
            let history = history(step);
            let newest = history.stamp(history.len - 1);
            let mut out = [Point::origin()];
            for back in [0, 1, 17, 250, 600] {
                let stamp = Stamp(newest.0 - back * 1_000_000);
                history.at(stamp, &mut out);
                assert!((out[0].x - stamp.seconds()).abs() < 1e-9, "{step} ms, {back} ms ago");
            }
            history.at(Stamp(i64::MIN), &mut out);
            assert_eq!(out[0].x, history.stamp(0).seconds());
            history.at(Stamp(i64::MAX), &mut out);
            assert_eq!(out[0].x, newest.seconds());
        }
    }
}
