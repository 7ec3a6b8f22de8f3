//! How the partner is looked for in the demonstrations.

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
    /// How likely the interaction begins anew, per frame `[-]`, 0 to 0.5.
    pub leap: f64,
    /// How long ago still counts for which demonstrations are followed `[s]`, > 0.
    pub memory: f64,
    /// How long ago still counts for how fast time goes `[s]`, > 0.
    pub pace_memory: f64,
    /// How many times as far as demonstrations are from each other a partner may be from all of
    /// them `[-]`, > 0; farther is no demonstrated interaction.
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
            leap: 1e-3,
            memory: 1.0,
            pace_memory: 0.5,
            strangeness: 3.0,
        }
    }
}
