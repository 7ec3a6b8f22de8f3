//! What the robot may do at most.

use crate::geometry::{Point, is_finite};

/// Limits of every joint in the world, and how plans are made within them.
#[derive(Debug, Clone, PartialEq)]
pub struct SafetySettings {
    /// Speed of any joint at most `[m/s]`, 0.01 to 10.
    pub speed: f64,
    /// Acceleration of any joint at most `[m/s²]`, 0.1 to 100.
    pub acceleration: f64,
    /// Jerk of any joint at most `[m/s³]`, 1 to 10,000.
    pub jerk: f64,
    /// Lowest and highest corner of the box that all joints stay in: `[m]` in the world; none:
    /// anywhere.
    pub workspace: Option<[Point; 2]>,
    /// Least distance between the robot's bones and the partner's head, neck and torso `[m]`, 0
    /// to 5. Hands and forearms of the partner are exempt: they are to be met.
    pub separation: f64,
    /// How fast the partner is taken to come nearer while the robot brakes `[m/s]`, 0 to 5.
    pub partner_speed: f64,
    /// How long a plan goes on before it brakes, if no newer one replaces it `[s]`, 0.005 to 0.5:
    /// about one and a half periods of the ticks.
    pub lead: f64,
    /// How far ahead of now the proposal is aimed at `[s]`, 0.05 to 1 and at least `lead`: the
    /// shorter, the closer it is followed and the more its noise counts.
    pub aim: f64,
    /// How long limits rise from 30 % to their full values after a start and after a long stop
    /// `[s]`, 0 to 10.
    pub recover: f64,
}

impl Default for SafetySettings {
    fn default() -> Self {
        Self {
            speed: 1.7,
            acceleration: 13.0,
            jerk: 1000.0,
            workspace: None,
            separation: 0.2,
            partner_speed: 0.0,
            lead: 0.05,
            aim: 0.1,
            recover: 0.5,
        }
    }
}

/// Why there is no gate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SafetyError {
    /// A setting is not finite or out of range.
    #[error("safety.{name} is {value}, must be {low} to {high}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// What it is.
        value: f64,
        /// The least it may be.
        low: f64,
        /// The most it may be.
        high: f64,
    },
    /// The workspace holds nothing.
    #[error("safety.workspace must be a finite lowest and highest corner, got {low} and {high}")]
    Workspace {
        /// What should be the lowest corner `[m]`.
        low: Point,
        /// What should be the highest corner `[m]`.
        high: Point,
    },
    /// Not one length for each bone.
    #[error("{lengths} bone lengths for {bones} bones")]
    Bones {
        /// How many lengths there are.
        lengths: usize,
        /// How many bones there are.
        bones: usize,
    },
    /// A bone's length is no length.
    #[error("bone {bone} is {length} m long, must be above 0, at most 10")]
    Length {
        /// The bone's place in the skeleton's order.
        bone: usize,
        /// What was given `[m]`.
        length: f64,
    },
    /// No braking motion was found within the limits.
    #[error("no stop from full speed within safety.acceleration and safety.jerk")]
    Brake,
}

impl SafetySettings {
    /// Checks every setting.
    ///
    /// # Errors
    /// The first [`SafetyError`] there is.
    pub(super) fn check(&self) -> Result<(), SafetyError> {
        let bounds = [
            ("speed", self.speed, 0.01, 10.0),
            ("acceleration", self.acceleration, 0.1, 100.0),
            ("jerk", self.jerk, 1.0, 1e4),
            ("separation", self.separation, 0.0, 5.0),
            ("partner_speed", self.partner_speed, 0.0, 5.0),
            ("lead", self.lead, 0.005, 0.5),
            ("aim", self.aim, f64::max(0.05, self.lead), 1.0),
            ("recover", self.recover, 0.0, 10.0),
        ];
        for (name, value, low, high) in bounds {
            if !(low..=high).contains(&value) {
                return Err(SafetyError::Setting { name, value, low, high });
            }
        }
        match self.workspace {
            Some([low, high])
                if !is_finite(&low) || !is_finite(&high) || (0..3).any(|i| low[i] >= high[i]) =>
            {
                Err(SafetyError::Workspace { low, high })
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_out_of_range_are_named() {
        let good = SafetySettings::default();
        assert_eq!(good.check(), Ok(()));
        let bad = SafetySettings { jerk: f64::NAN, ..good.clone() };
        assert!(bad.check().unwrap_err().to_string().contains("safety.jerk is NaN"));
        let bad = SafetySettings { aim: 0.1, lead: 0.2, ..good.clone() };
        assert!(bad.check().unwrap_err().to_string().contains("must be 0.2 to 1"));
        let flat = Some([Point::origin(), Point::new(1.0, 0.0, 1.0)]);
        let bad = SafetySettings { workspace: flat, ..good };
        assert!(matches!(bad.check(), Err(SafetyError::Workspace { .. })));
    }
}
