//! What is believed of a stream of sightings.

use crate::settings::{OutOfBounds, Setting, check, real};

/// What is believed of a stream of sightings; the numbers were chosen on recordings (SBU classes
/// 04, 05, 08) that no table here is about.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterSettings {
    /// Joints of less confidence count as untracked: 0 to 1.
    pub confidence: f64,
    /// No joint is faster `[m/s]`: 0.5 to 50.
    pub joint_speed: f64,
    /// How far off a joint may be seen besides `[m]`: 0 to 1.
    pub joint_slack: f64,
    /// By what share of its usual length a bone may be seen too long or too short: 0.05 to 5.
    pub bone_share: f64,
    /// A joint seen elsewhere for this long is believed there `[s]`: 0 to 5.
    pub believe: f64,
    /// Cut-off of the smoothing at rest `[Hz]`: 0.01 to 100.
    pub min_cutoff: f64,
    /// How much the cut-off rises with speed `[Hz/(m/s)]`: 0 to 100.
    pub cutoff_per_speed: f64,
    /// Cut-off of the speed that the cut-off rises with `[Hz]`: 0.01 to 100.
    pub speed_cutoff: f64,
    /// A missing joint moves with its parent for this long, then it is lost `[s]`: 0 to 2.
    pub bridge: f64,
    /// How long a joint keeps its velocity relative to the body's `[s]`: 0.01 to 10.
    pub joint_damping: f64,
    /// How long the body keeps its velocity `[s]`: 0.01 to 10.
    pub body_damping: f64,
    /// How far past the newest sighting joints are carried `[s]`: 0 to 2.
    pub carry: f64,
    /// No person moves faster than expected by more `[m/s]`: 0.1 to 20.
    pub body_speed: f64,
    /// How far off a whole person may be seen besides `[m]`: 0.05 to 2.
    pub body_slack: f64,
    /// Someone elsewhere, or a clock set back, is believed after this long `[s]`: 0 to 10.
    pub settle: f64,
    /// Whoever was not seen for this long is nobody's continuation `[s]`: 0.1 to 60.
    pub forget: f64,
    /// A partner not heard of for this long is stale `[s]`: 0.01 to 10.
    pub stale: f64,
    /// Left and right are kept exchanged for this long at most, then labels are believed `[s]`:
    /// 0 to 10.
    pub swap: f64,
    /// How far stamps may be from `now`, either way `[s]`: 0.01 to 10.
    pub clock_tolerance: f64,
}

impl Default for FilterSettings {
    fn default() -> Self {
        Self {
            confidence: 0.3,
            joint_speed: 8.0,
            joint_slack: 0.1,
            bone_share: 0.5,
            believe: 0.3,
            min_cutoff: 2.0,
            cutoff_per_speed: 1.5,
            speed_cutoff: 1.5,
            bridge: 0.3,
            joint_damping: 0.1,
            body_damping: 0.3,
            carry: 0.2,
            body_speed: 3.0,
            body_slack: 0.25,
            settle: 0.5,
            forget: 2.0,
            stale: 0.2,
            swap: 1.0,
            clock_tolerance: 0.5,
        }
    }
}

impl FilterSettings {
    /// All settings with their bounds.
    pub fn settings(&mut self) -> [Setting<'_>; 19] {
        [
            real("filter.confidence", &mut self.confidence, 0.0, 1.0),
            real("filter.joint_speed", &mut self.joint_speed, 0.5, 50.0),
            real("filter.joint_slack", &mut self.joint_slack, 0.0, 1.0),
            real("filter.bone_share", &mut self.bone_share, 0.05, 5.0),
            real("filter.believe", &mut self.believe, 0.0, 5.0),
            real("filter.min_cutoff", &mut self.min_cutoff, 0.01, 100.0),
            real("filter.cutoff_per_speed", &mut self.cutoff_per_speed, 0.0, 100.0),
            real("filter.speed_cutoff", &mut self.speed_cutoff, 0.01, 100.0),
            real("filter.bridge", &mut self.bridge, 0.0, 2.0),
            real("filter.joint_damping", &mut self.joint_damping, 0.01, 10.0),
            real("filter.body_damping", &mut self.body_damping, 0.01, 10.0),
            real("filter.carry", &mut self.carry, 0.0, 2.0),
            real("filter.body_speed", &mut self.body_speed, 0.1, 20.0),
            real("filter.body_slack", &mut self.body_slack, 0.05, 2.0),
            real("filter.settle", &mut self.settle, 0.0, 10.0),
            real("filter.forget", &mut self.forget, 0.1, 60.0),
            real("filter.stale", &mut self.stale, 0.01, 10.0),
            real("filter.swap", &mut self.swap, 0.0, 10.0),
            real("filter.clock_tolerance", &mut self.clock_tolerance, 0.01, 10.0),
        ]
    }

    /// Whether all settings are within their bounds.
    ///
    /// # Errors
    /// [`OutOfBounds`] names the first that is not.
    pub fn check(&self) -> Result<(), OutOfBounds> {
        check(self.clone().settings())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_setting_out_of_bounds_is_named() {
        assert_eq!(FilterSettings::default().check(), Ok(()));
        let settings = FilterSettings { stale: f64::NAN, swap: -1.0, ..FilterSettings::default() };
        let error = settings.check().unwrap_err();
        assert_eq!(error.to_string(), "filter.stale is NaN, not 0.01 to 10");
    }
}
