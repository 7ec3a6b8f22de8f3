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
    Around, Complex, Dimensions, MotionError, Neighbourhood, Neighbours, Pca, Rows,
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
    k_delaunay: Neighbours,
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
    /// # Errors
    /// [`ForecastError::Alike`] if the moments span too few dimensions for simplices;
    /// [`ForecastError::Motion`].
    pub(super) fn fit(
        examples: &Examples,
        settings: &ForecastSettings,
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
            k_delaunay: Neighbours::new(points, Neighbourhood::KDelaunay, k)?,
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
            k_delaunay: self.k_delaunay.around(),
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
                self.k_delaunay.find(&search.expected, &mut search.k_delaunay);
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
    let along = Along::new(points);
    let mut averaged = vec![0.0; examples.len() * horizons * joints];
    let rows = averaged.par_chunks_exact_mut(horizons * joints).enumerate();
    let room = || Vec::with_capacity(settings.averaged);
    rows.for_each_init(room, |near, (point, means)| {
        along.nearest(point, settings.averaged, near);
        for horizon in 0..horizons {
            let (before, mean) = means.split_at_mut(horizon * joints);
            let mean = &mut mean[..joints];
            let mut count = 0.0;
            for &(_, moment) in &*near {
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
    });
    averaged
}

/// Points in the order of their first coordinate, along which all of them look for their nearest:
/// past those as far off along it as the nearest are at all, nobody is nearer.
struct Along<'a> {
    points: &'a Rows,
    order: Vec<usize>,
    /// Each point's place in the order.
    place: Vec<usize>,
}

impl<'a> Along<'a> {
    fn new(points: &'a Rows) -> Self {
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by(|a, b| points.row(*a)[0].total_cmp(&points.row(*b)[0]));
        let mut place = vec![0; order.len()];
        order.iter().enumerate().for_each(|(at, point)| place[*point] = at);
        Self { points, order, place }
    }

    /// The `count` points nearest to one of them, itself among them, as [`Nearest::nearest`](crate::motion::Nearest::nearest) finds
    /// them: squared distance and row, nearest first, of equally near ones the first.
    fn nearest(&self, point: usize, count: usize, found: &mut Vec<(f64, usize)>) {
        found.clear();
        let here = self.points.row(point);
        let (mut below, mut above) = (self.place[point], self.place[point]);
        let mut farthest = f64::INFINITY;
        let gap = |at: usize| (self.points.row(self.order[at])[0] - here[0]).powi(2);
        loop {
            let down = below.checked_sub(1).map(|at| (gap(at), at));
            let up = (above < self.order.len()).then(|| (gap(above), above));
            let next = match (down, up) {
                (Some(down), Some(up)) => {
                    if down.0 < up.0 {
                        down
                    } else {
                        up
                    }
                }
                (Some(one), None) | (None, Some(one)) => one,
                (None, None) => return,
            };
            if next.0 > farthest {
                return;
            }
            if next.1 < below {
                below = next.1;
            } else {
                above += 1;
            }
            let other = self.order[next.1];
            let axes = self.points.row(other).iter().zip(here);
            let near = (axes.map(|(a, b)| (a - b) * (a - b)).sum::<f64>(), other);
            if near.0 <= farthest {
                let nearer = |known: &(f64, usize)| *known < near;
                let at = found.partition_point(nearer);
                if at == count {
                    continue;
                }
                found.truncate(count - 1);
                found.insert(at, near);
                if found.len() == count {
                    farthest = found[count - 1].0;
                }
            }
        }
    }
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

#[cfg(test)]
mod tests {
    use rand::{Rng as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::motion::Nearest;

    #[test]
    fn along_an_axis_the_nearest_are_those_of_all() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        for (dimensions, count) in [(2, 1), (2, 7), (3, 90), (4, 150)] {
            // Whole numbers of few sizes: many points at one place, and equally far.
            for size in [0.0, 3.0, 1e6] {
                let mut number = || f64::round(random.random_range(-1.0..1.0) * size);
                let values = (0..dimensions * count).map(|_| number()).collect();
                let points = Rows::new(dimensions, values).unwrap();
                let (along, nearest) = (Along::new(&points), Nearest::new(&points));
                for k in [1, 5, 200] {
                    let (mut found, mut known) = (Vec::new(), Vec::new());
                    for point in 0..count {
                        along.nearest(point, k, &mut found);
                        nearest.nearest(points.row(point), k, &mut known);
                        let known = known.iter().map(|n| (n.squared_distance, n.point as usize));
                        assert_eq!(found, known.collect::<Vec<_>>(), "{dimensions}, {size}, {k}");
                    }
                }
            }
        }
    }
}
