//! How forecasts are made.

/// How forecasts are made; the numbers were chosen on recordings that no table here is about.
#[derive(Debug, Clone, PartialEq)]
pub struct ForecastSettings {
    /// How far ahead `[s]`: rising, at least one, each > 0.
    pub horizons: Vec<f64>,
    /// The past over which a velocity is taken `[s]`.
    pub velocity_window: f64,
    /// How many seconds of velocity weigh as much as a place `[s]`.
    pub velocity_weight: f64,
    /// What the training motions are smoothed by `[s]`: see
    /// [`crate::Sequence::smoothed`].
    pub smoothing: f64,
    /// Ridge penalty per demonstrated moment.
    pub ridge_penalty: f64,
    /// Latent dimensions in which the nearest moments are looked for.
    pub dimensions: usize,
    /// Latent dimensions of the simplices: 2 to 4.
    pub simplex_dimensions: usize,
    /// How many nearest moments are neighbours.
    pub neighbours: usize,
    /// Over how many nearest moments a simplex corner's displacement is averaged.
    pub averaged: usize,
    /// How long a joint keeps its velocity relative to the root's `[s]`, for damped velocity.
    pub joint_damping: f64,
    /// How long the root keeps its velocity `[s]`, for damped velocity.
    pub root_damping: f64,
}

impl Default for ForecastSettings {
    fn default() -> Self {
        Self {
            horizons: vec![0.1, 0.2, 0.3, 0.5],
            velocity_window: 0.1,
            velocity_weight: 0.5,
            smoothing: 0.05,
            ridge_penalty: 3e-3,
            dimensions: 16,
            simplex_dimensions: 3,
            neighbours: 16,
            averaged: 32,
            joint_damping: 0.1,
            root_damping: 0.3,
        }
    }
}
