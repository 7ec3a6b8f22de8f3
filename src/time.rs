//! Time as an integer count of nanoseconds; reads no clock.
//!
//! Stamps come with the data (a sensor's header, a file's column) or from the caller, so the same
//! input gives the same output on any day.

use std::fmt;
use std::ops::{Add, Sub};

const NANOSECONDS_PER_SECOND: f64 = 1e9;

/// An instant, in nanoseconds since an epoch of the data's own (ROS time, a recording's start).
///
/// ```
/// use handover_mesh::{Span, Stamp};
/// let start = Stamp::from_seconds(1.5).unwrap();
/// assert_eq!(start + Span::from_seconds(0.25).unwrap(), Stamp(1_750_000_000));
/// assert_eq!((Stamp(2_000_000_000) - start).seconds(), 0.5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Stamp(pub i64);

/// A signed length of time, in nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Span(pub i64);

/// Seconds → nanoseconds, rounded; `None` if not finite or beyond ±292 years.
fn nanoseconds(seconds: f64) -> Option<i64> {
    let scaled = (seconds * NANOSECONDS_PER_SECOND).round();
    // 2^63 itself is not an i64, and every f64 below it is.
    (scaled.is_finite() && scaled.abs() < 9.223_372_036_854_775e18).then_some(scaled as i64)
}

impl Stamp {
    /// Rounds to the nearest nanosecond; `None` if not finite or out of range.
    pub fn from_seconds(seconds: f64) -> Option<Self> {
        nanoseconds(seconds).map(Self)
    }

    /// Seconds since the epoch; exact to a microsecond for any recording, not for dates.
    pub fn seconds(self) -> f64 {
        self.0 as f64 / NANOSECONDS_PER_SECOND
    }
}

impl Span {
    /// Rounds to the nearest nanosecond; `None` if not finite or out of range.
    pub fn from_seconds(seconds: f64) -> Option<Self> {
        nanoseconds(seconds).map(Self)
    }

    /// The span in seconds.
    pub fn seconds(self) -> f64 {
        self.0 as f64 / NANOSECONDS_PER_SECOND
    }

    /// The span in milliseconds.
    pub fn milliseconds(self) -> f64 {
        self.0 as f64 / 1e6
    }
}

impl Add<Span> for Stamp {
    type Output = Self;
    /// Saturates at the ends of the range: stamps come from files.
    fn add(self, span: Span) -> Self {
        Self(self.0.saturating_add(span.0))
    }
}

impl Sub for Stamp {
    type Output = Span;
    /// Saturates at the ends of the range: stamps come from files.
    fn sub(self, other: Self) -> Span {
        Span(self.0.saturating_sub(other.0))
    }
}

impl fmt::Display for Stamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.4} s", self.seconds())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_out_of_range_are_no_stamp() {
        for seconds in [f64::NAN, f64::INFINITY, 1e10, -1e10] {
            assert_eq!(Stamp::from_seconds(seconds), None, "{seconds}");
        }
        assert_eq!(Stamp::from_seconds(-9e9), Some(Stamp(-9_000_000_000_000_000_000)));
        assert_eq!(Stamp(i64::MAX) - Stamp(i64::MIN), Span(i64::MAX));
    }
}
