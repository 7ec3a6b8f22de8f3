//! Poses → points of a latent space of few dimensions, and back: principal component analysis.
//!
//! With the poses' mean `μ` and the right singular vectors `V` of the centred poses `X = U S Vᵀ`
//! (Gauch & Peters III-A; Pearson 1901), `z = Vᵀ(x − μ)` and back `x ≈ μ + V z`. The variance along
//! the k-th direction is `s_k² / n`.
//!
//! Channels are taken as they come: whoever mixes units scales them first.

use faer::{Mat, MatRef};

use super::{MotionError, Rows};

/// How many latent dimensions are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Dimensions {
    /// As many; at least 1.
    Count(usize),
    /// The fewest that explain this share of the variance, `0 < share ≤ 1`.
    Share(f64),
}

/// A latent space: its origin and its directions in the space of poses, immutable.
///
/// ```
/// use handover_mesh::motion::{Dimensions, Pca, Rows};
/// // Three poses on a line of the plane.
/// let poses = Rows::new(2, vec![0.0, 1.0, 1.0, 3.0, 2.0, 5.0])?;
/// let pca = Pca::fit(&poses, Dimensions::Count(1))?;
/// assert!((pca.explained()[0] - 1.0).abs() < 1e-12);
/// let back = pca.reproject(&pca.project(&poses));
/// assert!(back.values().iter().zip(poses.values()).all(|(a, b)| (a - b).abs() < 1e-12));
/// # Ok::<(), handover_mesh::motion::MotionError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Pca {
    mean: Vec<f64>,
    /// Latent direction after latent direction, each as long as a pose.
    directions: Vec<f64>,
    /// The share of the variance along each direction the poses span, falling.
    explained: Vec<f64>,
    dimensions: usize,
}

impl Pca {
    /// Finds the directions along which poses vary most.
    ///
    /// A direction's sign is chosen so that its largest component is positive.
    ///
    /// # Errors
    /// [`MotionError::NoPoses`]; [`MotionError::Rank`] if the poses span fewer dimensions;
    /// [`MotionError::Share`].
    pub fn fit(poses: &Rows, dimensions: Dimensions) -> Result<Self, MotionError> {
        if let Dimensions::Share(share) = dimensions
            && !(share > 0.0 && share <= 1.0)
        {
            return Err(MotionError::Share { share });
        }
        let (count, channels) = (poses.len(), poses.width());
        if count == 0 {
            return Err(MotionError::NoPoses);
        }
        let mut mean = vec![0.0; channels];
        // The second time adds what rounding took from the first.
        for _ in 0..2 {
            let mut off = vec![0.0; channels];
            for pose in poses.iter() {
                let parts =
                    pose.iter().zip(&mean).map(|(value, mean)| (value - mean) / count as f64);
                off.iter_mut().zip(parts).for_each(|(off, part)| *off += part);
            }
            mean.iter_mut().zip(off).for_each(|(mean, off)| *mean += off);
        }
        let mut centred = Mat::from_fn(count, channels, |i, j| poses.row(i)[j] - mean[j]);
        // Of a size whose squares neither vanish nor overflow.
        let size = centred.norm_max();
        if size > 0.0 {
            centred /= faer::Scale(size);
        }
        let (singular, vectors) = right_singular(&centred);
        // What rounding leaves of nothing: in the decomposition, and in the poses before it.
        let largest = poses.values().iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let first = singular.first().copied().unwrap_or(0.0);
        let floor = f64::EPSILON * count.max(channels) as f64 * first.max(largest / size);
        let rank = singular.iter().take_while(|s| **s > floor).count();
        let squares: Vec<f64> = singular[..rank].iter().map(|s| s * s).collect();
        let total: f64 = squares.iter().sum();
        let explained: Vec<f64> = squares.iter().map(|square| square / total).collect();
        let dimensions = match dimensions {
            Dimensions::Count(dimensions) => dimensions,
            Dimensions::Share(share) => fewest(&explained, share),
        };
        if !(1..=rank).contains(&dimensions) {
            let dimensions = dimensions.max(1);
            return Err(MotionError::Rank { dimensions, poses: count, rank });
        }
        let mut directions = Vec::with_capacity(dimensions * channels);
        for k in 0..dimensions {
            let column = (0..channels).map(|j| vectors[(j, k)]);
            let largest =
                column.clone().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
            directions.extend(column.map(|value| value * largest.signum()));
        }
        Ok(Self { mean, directions, explained, dimensions })
    }

    /// The number of latent dimensions.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// The number of channels of a pose.
    pub fn channels(&self) -> usize {
        self.mean.len()
    }

    /// The share of the variance along each direction the poses span, falling; its sum is 1, that
    /// of the first [`Self::dimensions`] is what the latent space keeps.
    pub fn explained(&self) -> Vec<f64> {
        self.explained.clone()
    }

    /// Poses → latent points.
    ///
    /// # Panics
    /// If the poses have not [`Self::channels`] channels: the caller's bug.
    pub fn project(&self, poses: &Rows) -> Rows {
        let mut points = vec![0.0; poses.len() * self.dimensions];
        for (pose, point) in poses.iter().zip(points.chunks_exact_mut(self.dimensions)) {
            self.project_pose(pose, point);
        }
        Rows::computed(self.dimensions, points)
    }

    /// One pose → a latent point, without allocation.
    ///
    /// # Panics
    /// If the lengths are not [`Self::channels`] and [`Self::dimensions`]: the caller's bug.
    pub fn project_pose(&self, pose: &[f64], point: &mut [f64]) {
        assert_eq!((pose.len(), point.len()), (self.channels(), self.dimensions));
        for (direction, value) in self.directions.chunks_exact(pose.len()).zip(point) {
            let centred = pose.iter().zip(&self.mean).map(|(x, mean)| x - mean);
            *value = direction.iter().zip(centred).map(|(v, x)| v * x).sum();
        }
    }

    /// Latent points → the poses they stand for.
    ///
    /// # Panics
    /// If the points have not [`Self::dimensions`] dimensions: the caller's bug.
    pub fn reproject(&self, points: &Rows) -> Rows {
        let mut poses = vec![0.0; points.len() * self.channels()];
        for (point, pose) in points.iter().zip(poses.chunks_exact_mut(self.channels())) {
            self.reproject_point(point, pose);
        }
        Rows::computed(self.channels(), poses)
    }

    /// One latent point → the pose it stands for, without allocation.
    ///
    /// # Panics
    /// If the lengths are not [`Self::dimensions`] and [`Self::channels`]: the caller's bug.
    pub fn reproject_point(&self, point: &[f64], pose: &mut [f64]) {
        assert_eq!((point.len(), pose.len()), (self.dimensions, self.channels()));
        pose.copy_from_slice(&self.mean);
        for (direction, value) in self.directions.chunks_exact(pose.len()).zip(point) {
            pose.iter_mut().zip(direction).for_each(|(x, v)| *x += v * value);
        }
    }
}

/// Singular values, falling, and the right singular vectors as columns.
fn right_singular(centred: &Mat<f64>) -> (Vec<f64>, Mat<f64>) {
    // NOTE: of finite numbers the iteration converges; were it not to, there would be no direction.
    let Ok(svd) = centred.thin_svd() else { return (Vec::new(), Mat::new()) };
    let singular = svd.S().column_vector().iter().copied().collect();
    let vectors: MatRef<'_, f64> = svd.V();
    (singular, vectors.to_owned())
}

/// How many of the first explain this share of all.
fn fewest(explained: &[f64], share: f64) -> usize {
    let mut sum = 0.0;
    let reached = explained.iter().position(|part| {
        sum += part;
        // Rounding must not ask for more than there is.
        sum >= share * (1.0 - 1e-12)
    });
    reached.map_or(explained.len(), |at| at + 1)
}
