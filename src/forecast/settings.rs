//! How forecasts are made.

use std::fmt::Debug;

use super::ForecastError;
use crate::motion::Complex;

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

impl ForecastSettings {
    /// Whether forecasts can be made so.
    ///
    /// # Errors
    /// [`ForecastError::Setting`] names the first setting out of its bounds.
    pub(super) fn check(&self) -> Result<(), ForecastError> {
        let wrong = |setting, value: &dyn Debug, bound| {
            Err(ForecastError::Setting { setting, value: format!("{value:?}"), bound })
        };
        let rising = self.horizons.is_sorted_by(|a, b| a < b);
        // No span of time is longer than a stamp can count.
        let ahead = self.horizons.iter().all(|horizon| *horizon > 0.0 && *horizon < 1e9);
        if self.horizons.is_empty() || !rising || !ahead {
            return wrong("horizons", &self.horizons, "some seconds ahead, rising");
        }
        let spans = [
            ("velocity_window", self.velocity_window),
            ("velocity_weight", self.velocity_weight),
            ("ridge_penalty", self.ridge_penalty),
            ("joint_damping", self.joint_damping),
            ("root_damping", self.root_damping),
        ];
        for (setting, value) in spans {
            if !(value > 0.0 && value.is_finite()) {
                return wrong(setting, &value, "a number above 0");
            }
        }
        let counts = [
            ("dimensions", self.dimensions),
            ("neighbours", self.neighbours),
            ("averaged", self.averaged),
        ];
        for (setting, value) in counts {
            if value == 0 {
                return wrong(setting, &value, "a whole number from 1");
            }
        }
        if !Complex::DIMENSIONS.contains(&self.simplex_dimensions) {
            return wrong("simplex_dimensions", &self.simplex_dimensions, "2, 3 or 4");
        }
        Ok(())
    }
}
