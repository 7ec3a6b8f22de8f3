//! Stamps → how many frames a second, and where that changes.
//!
//! A file's rate is one over the median step. Where the median of nine consecutive steps is off
//! by more than a factor 1.6, the rate changes there: a few dropped frames move no median.

use super::error::{Place, Reason, Violations};
use crate::time::Stamp;

/// Consecutive steps whose median is compared with the file's.
const WINDOW: usize = 9;
/// Jitter and dropped frames stay below, half or double the rate is above.
const FACTOR: f64 = 1.6;

/// Frames a second `[Hz]`: one over the median step; `None` for fewer than two stamps.
///
/// ```
/// use handover_mesh::{Stamp, formats::rate};
/// let stamps = [0, 100, 200, 400, 500].map(|ms| Stamp(ms * 1_000_000));
/// assert_eq!(rate(stamps.into_iter()), Some(10.0));
/// ```
pub fn rate(stamps: impl Iterator<Item = Stamp>) -> Option<f64> {
    let stamps: Vec<Stamp> = stamps.collect();
    lower_median(&mut steps(&stamps)).map(f64::recip)
}

fn steps(stamps: &[Stamp]) -> Vec<f64> {
    stamps.windows(2).map(|pair| (pair[1] - pair[0]).seconds()).collect()
}

/// The middle value; of two middle ones the lower, because their mean is a step nobody took.
fn lower_median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len().checked_sub(1)? / 2).copied()
}

/// Notes where the rate changes: once for each stretch of another rate.
///
/// - `stamps`: rising.
/// - `places`: where each frame starts.
pub(super) fn check(
    stamps: &[Stamp],
    places: &[impl Clone + Into<Place>],
    violations: &mut Violations,
) {
    let steps = steps(stamps);
    let Some(usual) = lower_median(&mut steps.clone()) else { return };
    let is_off = |step: f64| step > FACTOR * usual || step * FACTOR < usual;
    let mut inside = false;
    for (at, window) in steps.windows(WINDOW).enumerate() {
        let first = window.iter().position(|step| is_off(*step)).unwrap_or(0);
        let median = lower_median(&mut window.to_vec()).filter(|median| is_off(*median));
        if let (Some(median), false) = (median, inside) {
            let reason = Reason::MixedRates { rate: median.recip(), usual: usual.recip() };
            violations.add(places[at + first].clone(), reason);
        }
        inside = median.is_some();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_steps(milliseconds: &[i64]) -> Vec<(Place, String)> {
        let mut stamps = vec![Stamp(0)];
        for step in milliseconds {
            stamps.push(Stamp(stamps[stamps.len() - 1].0 + step * 1_000_000));
        }
        let lines: Vec<u64> = (0..stamps.len() as u64).map(|k| 2 + 10 * k).collect();
        let mut violations = Violations::default();
        check(&stamps, &lines, &mut violations);
        let found = violations.or(None::<()>).unwrap_err();
        found.violations().iter().map(|v| (v.place.clone(), v.reason.to_string())).collect()
    }

    #[test]
    fn dropped_frames_are_no_change_of_rate() {
        assert_eq!(check_steps(&[33, 33, 66, 33, 66, 33, 33, 99, 33, 33]), []);
        assert_eq!(check_steps(&[30, 54, 31, 33, 50, 30, 40]), []);
        assert_eq!(check_steps(&[33, 66, 66, 66]), []);
        // A bad second: four of nine steps are double, the rest of the file is not.
        assert_eq!(check_steps(&[33, 33, 66, 33, 66, 66, 33, 66, 33, 33, 33, 33, 33]), []);
    }

    #[test]
    fn a_change_is_named_once_where_it_starts() {
        let found = check_steps(&[33, 33, 33, 33, 33, 33, 66, 66, 66, 66, 66, 66]);
        let text = "mixed rates: 15.2 Hz from here on, 30.3 Hz in most of the file";
        assert_eq!(found, [(Place::Line(62), text.into())]);
    }
}
