//! How the partner is looked for in the demonstrations.

use crate::settings::{OutOfBounds, Setting, check, count, real};

/// How the partner is looked for in the demonstrations.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackSettings {
    /// Frames a second of the grid that demonstrations and windows are laid on `[Hz]`, 5 to 120.
    pub rate: f64,
    /// How many demonstrations make the reference at most, ≥ 1.
    pub demonstrations: usize,
    /// How many seconds of velocity tell as much as a place does `[s]`, ≥ 0.
    pub velocity_weight: f64,
    /// The past over which a velocity is taken `[s]`, > 0.
    pub velocity_window: f64,
    /// Weight `[-]` of the people's distance beside the partner's pose, ≥ 0.
    pub distance_weight: f64,
    /// Latent dimensions of moments, ≥ 1; no more are taken than the moments span.
    pub dimensions: usize,
    /// How far a moment is from the demonstrated one at the same place in time `[m]`, as a
    /// standard deviation, > 0.
    pub spread: f64,
    /// How far from its beginning a demonstration is taken up before anything is seen `[s]`, > 0:
    /// the chance falls by `exp(−t/this)`.
    pub start: f64,
    /// How likely time stands still for a frame `[-]`, and how likely it goes twice as fast; their
    /// sum is below 1.
    pub pause: f64,
    /// See [`Self::pause`].
    pub hurry: f64,
    /// The same of an interaction that begins anew `[s]`, > 0.
    pub restart: f64,
    /// How likely the interaction begins anew, per frame `[-]`, 0 to 0.5.
    pub leap: f64,
    /// How far from the likeliest moment of a demonstration others count for where in it the
    /// interaction is `[s]`, 0 to 60: who stands still may do so before or after they reach, but
    /// hardly in the middle.
    pub stretch: f64,
    /// How long ago still counts for which demonstrations are followed `[s]`, > 0.
    pub memory: f64,
    /// How long ago still counts for how fast time goes `[s]`, > 0.
    pub pace_memory: f64,
    /// How many times as far as demonstrations are from each other a partner may be from all of
    /// them `[-]`, > 0, and how many times as far turned from the robot (60 to 120 degrees in any
    /// case); farther is no demonstrated interaction.
    pub strangeness: f64,
}

impl Default for TrackSettings {
    fn default() -> Self {
        Self {
            rate: 30.0,
            demonstrations: 5,
            velocity_weight: 0.4,
            velocity_window: 0.1,
            distance_weight: 0.2,
            dimensions: 16,
            spread: 0.05,
            start: 2.0,
            pause: 0.3,
            hurry: 0.25,
            restart: 0.3,
            leap: 1e-3,
            stretch: 0.8,
            memory: 1.0,
            pace_memory: 0.5,
            strangeness: 3.0,
        }
    }
}

impl TrackSettings {
    /// All settings with their bounds.
    pub fn settings(&mut self) -> [Setting<'_>; 16] {
        [
            real("track.rate", &mut self.rate, 5.0, 120.0),
            count("track.demonstrations", &mut self.demonstrations, 1, 1000),
            real("track.velocity_window", &mut self.velocity_window, 0.001, 10.0),
            real("track.velocity_weight", &mut self.velocity_weight, 0.0, 1000.0),
            real("track.distance_weight", &mut self.distance_weight, 0.0, 100.0),
            count("track.dimensions", &mut self.dimensions, 1, 1000),
            real("track.spread", &mut self.spread, 0.001, 10.0),
            real("track.start", &mut self.start, 0.01, 600.0),
            real("track.pause", &mut self.pause, 0.0, 0.45),
            real("track.hurry", &mut self.hurry, 0.0, 0.45),
            real("track.restart", &mut self.restart, 0.01, 600.0),
            real("track.leap", &mut self.leap, 0.0, 0.5),
            real("track.stretch", &mut self.stretch, 0.0, 60.0),
            real("track.memory", &mut self.memory, 0.001, 60.0),
            real("track.pace_memory", &mut self.pace_memory, 0.001, 60.0),
            real("track.strangeness", &mut self.strangeness, 0.01, 1000.0),
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
