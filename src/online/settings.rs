//! The numbers behind a tick.

use crate::filter::FilterSettings;
use crate::forecast::ForecastSettings;
use crate::safety::SafetySettings;
use crate::settings::{OutOfBounds, Setting, check, count, real};
use crate::track::TrackSettings;

/// The numbers behind a tick.
#[derive(Debug, Clone, PartialEq)]
pub struct OnlineSettings {
    /// How skeletons are believed and smoothed.
    pub filter: FilterSettings,
    /// What the robot may do at most.
    pub safety: SafetySettings,
    /// Ticks a second of replays `[Hz]`, 1 to 10,000; live, the caller's clock decides.
    pub tick_rate: f64,
    /// How long the partner may not be known, for whatever reason, before the robot, once it goes
    /// on, does so gently `[s]`.
    pub stop_after: f64,
    /// How the partner is looked for in the demonstrations; the window is on the same grid of time.
    pub track: TrackSettings,
    /// How the partner is forecast.
    pub forecast: ForecastSettings,
    /// Frames of the window before now, ≥ 0.
    pub past: usize,
    /// Frames of the window after now, ≥ 1.
    pub future: usize,
    /// Steps of a solve at most, ≥ 1: each starts from the last tick's solution.
    pub steps: usize,
    /// How soon a forecast of the partner counts for less than how the demonstrations go on
    /// `[s]`, > 0: its share falls by `exp(−t/this)`.
    pub trust: f64,
    /// How long one of the partner's joints goes unseen until its place is that of the
    /// demonstrations followed alone `[s]`, > 0; until then, by share, where it went with its parent.
    pub guess: f64,
    /// How far off the moment of contact may be foreseen `[s]`, ≥ 0: for so long before and after
    /// it the reference holds the gap at contact in full.
    pub contact_hold: f64,
    /// By how much a weight may change before the system is factored anew, as a share of itself
    /// `[-]`, ≥ 0.
    pub refactor: f64,
}

impl Default for OnlineSettings {
    fn default() -> Self {
        Self {
            filter: FilterSettings::default(),
            safety: SafetySettings::default(),
            tick_rate: 30.0,
            stop_after: 1.0,
            track: TrackSettings::default(),
            forecast: ForecastSettings::default(),
            past: 2,
            future: 15,
            steps: 3,
            trust: 0.5,
            guess: 2.0,
            contact_hold: 0.4,
            refactor: 1e-3,
        }
    }
}

impl OnlineSettings {
    /// The settings of tick and window with their bounds; the parts have their own.
    pub fn settings(&mut self) -> [Setting<'_>; 9] {
        [
            real("tick.rate", &mut self.tick_rate, 1.0, 10_000.0),
            real("tick.stop_after", &mut self.stop_after, 0.01, 60.0),
            count("window.past", &mut self.past, 0, 60),
            count("window.future", &mut self.future, 1, 120),
            count("window.steps", &mut self.steps, 1, 10_000),
            real("window.trust", &mut self.trust, 0.001, 60.0),
            real("window.guess", &mut self.guess, 0.001, 600.0),
            real("window.contact_hold", &mut self.contact_hold, 0.0, 60.0),
            real("window.refactor", &mut self.refactor, 0.0, 1.0),
        ]
    }

    /// Whether the settings of tick, window, filter and tracker are within their bounds; forecaster
    /// and gate look at their own.
    ///
    /// # Errors
    /// [`OutOfBounds`] names the first that is not.
    pub fn check(&self) -> Result<(), OutOfBounds> {
        check(self.clone().settings())?;
        self.filter.check()?;
        self.track.check()
    }
}
