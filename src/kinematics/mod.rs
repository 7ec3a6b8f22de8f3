//! Where a limb's joints lie when its ends are given.
//!
//! Geometry only: knows nothing of people, recordings or robots.

mod two_bone;

pub use two_bone::{TwoBone, two_bone};

/// The way gone after `part` of the time, both `[-]`: 0 up to 0, 1 from 1 on, and between them
/// `10 s³ − 15 s⁴ + 6 s⁵`, without velocity or acceleration at either end (Flash & Hogan 1985,
/// eq. 5).
///
/// ```
/// use handover_mesh::kinematics::minimum_jerk;
/// assert_eq!([-1.0, 0.0, 0.5, 1.0, 2.0].map(minimum_jerk), [0.0, 0.0, 0.5, 1.0, 1.0]);
/// ```
pub fn minimum_jerk(part: f64) -> f64 {
    let s = part.clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}

#[cfg(test)]
mod tests {
    use super::minimum_jerk;

    #[test]
    fn a_reach_starts_and_ends_at_rest() {
        let h = 1e-4;
        let slope = |s: f64| (minimum_jerk(s + h) - minimum_jerk(s - h)) / (2.0 * h);
        assert!([0.0, 1.0].iter().all(|edge| slope(*edge).abs() < 1e-6));
        // Peak speed of the profile: 15/8.
        assert!((slope(0.5) - 1.875).abs() < 1e-6);
    }
}
