//! Stature `[m]` → where the fifteen joints sit on an upright body.
//!
//! Segment lengths are fractions of stature (Drillis & Contini 1966, as printed in Winter,
//! *Biomechanics and Motor Control of Human Movement*, figure 4.1). Two departures, since a tracker
//! sees joints and not outlines: the hand is its middle, half a hand beyond the wrist, and hip
//! joints are half the hip breadth apart.

use handover_mesh::{Side, Vector};

/// Upper arm: shoulder to elbow.
const UPPER_ARM: f64 = 0.186;
/// Forearm 0.146 and half of the hand's 0.108: elbow to the middle of the hand.
const FOREARM_AND_PALM: f64 = 0.146 + 0.108 / 2.0;
/// Thigh: hip joint at 0.530 above the floor, knee at 0.285.
const THIGH: f64 = 0.530 - 0.285;
/// Shank: knee at 0.285, ankle at 0.039.
const SHANK: f64 = 0.285 - 0.039;
/// Ankle above the floor.
const ANKLE: f64 = 0.039;
/// Shoulder joints above the floor.
const SHOULDER: f64 = 0.818;
/// Half the shoulder breadth.
const HALF_SHOULDERS: f64 = 0.129;
/// A quarter of the hip breadth of 0.191.
const HALF_HIPS: f64 = 0.191 / 4.0;
/// Eye level: the head's middle.
const HEAD: f64 = 0.936;
/// Trackers put the neck a little above the line of the shoulders, below the chin at 0.870.
const NECK: f64 = 0.835;
/// Nobody stands with locked knees: the hips hang this much below a straight leg.
const KNEE_BEND: f64 = 0.985;

/// The lengths of one body `[m]`, all in proportion to its stature.
///
/// Offsets are in the body's upright frame: x ahead, y to its left, z up.
///
/// ```
/// use handover_sim::body::Body;
/// let body = Body::of_stature(1.75);
/// assert!((body.arm() - 0.6755).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    stature: f64,
}

impl Body {
    /// The body of a person this tall `[m]`; any finite stature > 0.
    pub fn of_stature(stature: f64) -> Self {
        Self { stature }
    }

    /// How tall `[m]`.
    pub fn stature(&self) -> f64 {
        self.stature
    }

    /// Shoulder to elbow `[m]`.
    pub fn upper_arm(&self) -> f64 {
        UPPER_ARM * self.stature
    }

    /// Elbow to the middle of the hand `[m]`.
    pub fn forearm(&self) -> f64 {
        FOREARM_AND_PALM * self.stature
    }

    /// The arm stretched out `[m]`.
    pub fn arm(&self) -> f64 {
        self.upper_arm() + self.forearm()
    }

    /// Hip to knee `[m]`.
    pub fn thigh(&self) -> f64 {
        THIGH * self.stature
    }

    /// Knee to ankle `[m]`.
    pub fn shank(&self) -> f64 {
        SHANK * self.stature
    }

    /// The ankle above the floor `[m]`, the foot flat.
    pub fn ankle_height(&self) -> f64 {
        ANKLE * self.stature
    }

    /// The middle between the hips above the floor `[m]`, standing.
    pub fn hip_height(&self) -> f64 {
        (ANKLE + (THIGH + SHANK) * KNEE_BEND) * self.stature
    }

    /// From the middle of the hips to a hip joint.
    pub fn hip(&self, side: Side) -> Vector {
        Vector::new(0.0, sign(side) * HALF_HIPS * self.stature, 0.0)
    }

    /// From the middle of the hips up to the trunk's middle.
    pub fn torso(&self) -> Vector {
        Vector::new(0.0, 0.0, (NECK - ANKLE - THIGH - SHANK) / 2.0 * self.stature)
    }

    /// From the trunk's middle up to the neck: as far again.
    pub fn neck(&self) -> Vector {
        self.torso()
    }

    /// From the neck to a shoulder joint.
    pub fn shoulder(&self, side: Side) -> Vector {
        Vector::new(0.0, sign(side) * HALF_SHOULDERS, SHOULDER - NECK) * self.stature
    }

    /// From the neck to the middle of the head.
    pub fn head(&self) -> Vector {
        Vector::new(0.02, 0.0, HEAD - NECK) * self.stature
    }

    /// The shoulders above the floor `[m]`, standing.
    pub fn shoulder_height(&self) -> f64 {
        self.hip_height() + (2.0 * self.torso() + self.shoulder(Side::Left)).z
    }
}

/// +1 on the left, where y points.
pub(crate) fn sign(side: Side) -> f64 {
    match side {
        Side::Left => 1.0,
        Side::Right => -1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_stands_as_tall_as_its_parts() {
        let body = Body::of_stature(1.8);
        let bend = (body.thigh() + body.shank()) * (1.0 - KNEE_BEND);
        assert!((body.shoulder_height() - (0.818 * 1.8 - bend)).abs() < 1e-12);
        assert!(body.hip(Side::Right).y < 0.0 && body.shoulder(Side::Left).y > 0.0);
    }
}
