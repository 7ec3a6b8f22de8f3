//! Where a limb's joints lie when its ends are given.
//!
//! Geometry only: knows nothing of people, recordings or robots.

mod two_bone;

pub use two_bone::{TwoBone, two_bone};

/// The way gone after `part` of the time, both `[-]` in `[0, 1]`: from 0 to 1 with no velocity or
/// acceleration at either end, `10 s³ − 15 s⁴ + 6 s⁵` (Flash & Hogan 1985, eq. 5).
pub fn minimum_jerk(part: f64) -> f64 {
    part.powi(3) * (10.0 - 15.0 * part + 6.0 * part * part)
}
