//! Demonstrated moments in latent spaces, and what really came next.
//!
//! The nearest moments are looked for among all features, in their principal directions. Simplices
//! need fewer dimensions, so theirs are those along which ridge regression expects motions to
//! differ: the principal directions of what it predicts (reduced-rank regression, Izenman 1975).

use rayon::prelude::*;

use super::examples::Examples;
use super::regression::Regression;
use super::{ForecastError, ForecastSettings};
use crate::motion::{
    Around, Complex, Dimensions, MotionError, Neighbourhood, Neighbours, Pca, Rows, nearest_of_all,
};

/// The most moments whose spread latent directions are taken from: more change them little.
const MOST_SPREAD: usize = 2000;

/// Demonstrated moments as latent points, each with its displacement over the horizons.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fields {
    pub(super) regression: Regression,
    features: Pca,
    nearest: Neighbours,
    /// `moments × horizons × joints` `[m]`.
    displacements: Vec<f64>,
    expected: Pca,
    delaunay: Neighbours,
    /// None where only the mixed methods are asked.
    k_delaunay: Option<Neighbours>,
    /// The same, averaged over the moments nearest to each: a simplex has too few corners to even
    /// out how much single motions scatter.
    averaged: Vec<f64>,
}

/// What a search through the fields keeps.
#[derive(Debug, Clone)]
pub(super) struct Search {
    features: Vec<f64>,
    nearest: Around,
    expected: Vec<f64>,
    delaunay: Around,
    k_delaunay: Around,
}

impl Fields {
    /// - `all`: whether more than the methods that are mixed will be asked.
    ///
    /// # Errors
    /// [`ForecastError::Alike`] if the moments span too few dimensions for simplices;
    /// [`ForecastError::Motion`].
    pub(super) fn fit(
        examples: &Examples,
        settings: &ForecastSettings,
        all: bool,
    ) -> Result<Self, ForecastError> {
        let outputs = settings.horizons.len() * examples.joints;
        let regression = Regression::fit(examples, settings.horizons.len(), settings.ridge_penalty);
        let mut expected = vec![0.0; examples.len() * outputs];
        expected.par_chunks_exact_mut(outputs).enumerate().for_each(|(moment, row)| {
            regression.predict(examples.features_of(moment), row);
        });
        let seen = Rows::new(examples.width, examples.features.clone())?;
        let (features, points) = latent(&seen, settings.dimensions)?;
        let k = settings.neighbours;
        let nearest = Neighbours::new(points, Neighbourhood::Knn, k)?;
        let (expected, points) =
            latent(&Rows::new(outputs, expected)?, settings.simplex_dimensions)?;
        if points.width() < *Complex::DIMENSIONS.start() {
            return Err(ForecastError::Alike { moments: points.len(), rank: points.width() });
        }
        let averaged = averaged(examples, &points, settings);
        Ok(Self {
            regression,
            features,
            nearest,
            displacements: completed(examples, &averaged, outputs),
            expected,
            delaunay: Neighbours::new(points.clone(), Neighbourhood::Delaunay, k)?,
            k_delaunay: all
                .then(|| Neighbours::new(points, Neighbourhood::KDelaunay, k))
                .transpose()?,
            averaged,
        })
    }

    /// Room for searches.
    pub(super) fn search(&self) -> Search {
        Search {
            features: vec![0.0; self.features.dimensions()],
            nearest: self.nearest.around(),
            expected: vec![0.0; self.expected.dimensions()],
            delaunay: self.delaunay.around(),
            k_delaunay: self.k_delaunay.as_ref().map(Neighbours::around).unwrap_or_default(),
        }
    }

    /// The mean displacement of the moments around one, by their weights; overwritten.
    ///
    /// - `features`: of the moment.
    /// - `expected`: what [`Self::regression`] expects of it.
    pub(super) fn predict(
        &self,
        neighbourhood: Neighbourhood,
        features: &[f64],
        expected: &[f64],
        search: &mut Search,
        displacement: &mut [f64],
    ) {
        let (around, values) = match neighbourhood {
            Neighbourhood::Knn => {
                self.features.project_pose(features, &mut search.features);
                self.nearest.find(&search.features, &mut search.nearest);
                (&search.nearest, &self.displacements)
            }
            Neighbourhood::Delaunay => {
                self.expected.project_pose(expected, &mut search.expected);
                self.delaunay.find(&search.expected, &mut search.delaunay);
                (&search.delaunay, &self.averaged)
            }
            Neighbourhood::KDelaunay => {
                self.expected.project_pose(expected, &mut search.expected);
                if let Some(k_delaunay) = &self.k_delaunay {
                    k_delaunay.find(&search.expected, &mut search.k_delaunay);
                }
                (&search.k_delaunay, &self.averaged)
            }
        };
        displacement.fill(0.0);
        for neighbour in around.neighbours() {
            let row = neighbour.pose as usize * displacement.len();
            let of = &values[row..][..displacement.len()];
            displacement.iter_mut().zip(of).for_each(|(d, v)| *d += neighbour.weight * v);
        }
    }
}

/// The principal directions of rows, and the rows along them; fewer where they span fewer.
///
/// # Errors
/// [`ForecastError::Alike`] if they span none.
fn latent(rows: &Rows, dimensions: usize) -> Result<(Pca, Rows), ForecastError> {
    let step = rows.len().div_ceil(MOST_SPREAD).max(1);
    let spread = rows.iter().step_by(step).flatten().copied().collect();
    let spread = Rows::new(rows.width(), spread)?;
    let pca = match Pca::fit(&spread, Dimensions::Count(dimensions)) {
        Err(MotionError::Rank { rank: 0, .. }) => {
            return Err(ForecastError::Alike { moments: rows.len(), rank: 0 });
        }
        Err(MotionError::Rank { rank, .. }) => Pca::fit(&spread, Dimensions::Count(rank))?,
        fitted => fitted?,
    };
    let points = pca.project(rows);
    Ok((pca, points))
}

/// Every moment's displacement as the mean over those nearest to it, itself among them, as far as
/// their motions reach. Where none reaches a horizon, the displacement over the one before stays.
fn averaged(examples: &Examples, points: &Rows, settings: &ForecastSettings) -> Vec<f64> {
    let (horizons, joints) = (settings.horizons.len(), examples.joints);
    let nearest = nearest_of_all(points, settings.averaged);
    let near = nearest.chunks_exact(settings.averaged.min(points.len()));
    let mut averaged = vec![0.0; examples.len() * horizons * joints];
    for (near, means) in near.zip(averaged.chunks_exact_mut(horizons * joints)) {
        for horizon in 0..horizons {
            let (before, mean) = means.split_at_mut(horizon * joints);
            let mean = &mut mean[..joints];
            let mut count = 0.0;
            for &moment in near {
                let moment = moment as usize;
                if examples.reach[moment] as usize > horizon {
                    let of = examples.displacement_of(moment, horizon, horizons);
                    mean.iter_mut().zip(of).for_each(|(m, d)| *m += d);
                    count += 1.0;
                }
            }
            if count > 0.0 {
                mean.iter_mut().for_each(|m| *m /= count);
            } else if let Some(before) = before.rchunks_exact(joints).next() {
                mean.copy_from_slice(before);
            }
        }
    }
    averaged
}

/// Every moment's own displacement; beyond its motion's end, the averaged one.
fn completed(examples: &Examples, averaged: &[f64], outputs: usize) -> Vec<f64> {
    let mut completed = examples.displacements.clone();
    let rows = completed.chunks_exact_mut(outputs).zip(averaged.chunks_exact(outputs));
    for ((own, mean), reach) in rows.zip(&examples.reach) {
        let from = *reach as usize * examples.joints;
        own[from..].copy_from_slice(&mean[from..]);
    }
    completed
}
