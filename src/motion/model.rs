//! All of it together: what sequences of poses say about where and how poses move.

use std::ops::Range;

use super::complex::Complex;
use super::field::{self, FollowSettings, Path};
use super::nearest::nearest_of_all;
use super::neighbourhood::{Around, Neighbourhood, Neighbours};
use super::{Dimensions, MotionError, MotionGraph, Pca, Rows};

/// How a motion model is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionSettings {
    /// How many latent dimensions.
    pub dimensions: Dimensions,
    /// Which poses are around a place.
    pub neighbourhood: Neighbourhood,
    /// How many nearest poses are neighbours; at least 1.
    pub k: usize,
}

impl Default for MotionSettings {
    /// The paper's: two dimensions, sixteen neighbours; both kinds of neighbours together.
    fn default() -> Self {
        Self { dimensions: Dimensions::Count(2), neighbourhood: Neighbourhood::KDelaunay, k: 16 }
    }
}

impl MotionSettings {
    /// Whether such a model may be made at all: whoever asks for too many dimensions need not wait
    /// for it, nor be told first of another reason.
    ///
    /// # Errors
    /// [`MotionError::Dimensions`].
    pub fn check(&self) -> Result<(), MotionError> {
        match self.dimensions {
            Dimensions::Count(dimensions)
                if self.neighbourhood.has_simplices()
                    && !Complex::DIMENSIONS.contains(&dimensions) =>
            {
                Err(MotionError::Dimensions { dimensions })
            }
            _ => Ok(()),
        }
    }
}

/// Sequences of poses in their latent space, with the field of their velocities; immutable.
///
/// ```
/// use handover_mesh::motion::{FollowSettings, MotionModel, MotionSettings, Rows};
/// // Two rounds on a slightly tilted circle.
/// let circle = |radius: f64| {
///     let turns = (0..240).map(|k| f64::from(k) / 20.0);
///     Rows::new(3, turns.flat_map(|t| [radius * t.cos(), radius * t.sin(), 0.1 * t.cos()]).collect())
/// };
/// let model = MotionModel::fit(&[circle(1.0)?, circle(1.1)?], MotionSettings::default())?;
/// let start = model.pca().project(&Rows::new(3, vec![1.05, 0.0, 0.1])?);
/// let settings = FollowSettings { steps: 40, still: 0.0, goal: None };
/// let path = model.follow(start.row(0), &settings);
/// let poses = model.pca().reproject(&path.points);
/// assert!(poses.iter().all(|p| (1.0..1.12).contains(&p[0].hypot(p[1]))));
/// # Ok::<(), handover_mesh::motion::MotionError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct MotionModel {
    pca: Pca,
    sequences: Vec<Range<usize>>,
    neighbours: Neighbours,
    velocities: Rows,
}

impl MotionModel {
    /// Learns from sequences of poses; an empty sequence says nothing.
    ///
    /// # Errors
    /// [`MotionError`]: no poses, sequences of different channels, poses that span too few
    /// dimensions, or simplices asked for in more than there are any.
    pub fn fit(sequences: &[Rows], settings: MotionSettings) -> Result<Self, MotionError> {
        settings.check()?;
        let channels = sequences.first().ok_or(MotionError::NoPoses)?.width();
        let mut values = Vec::new();
        let mut ranges = Vec::with_capacity(sequences.len());
        let mut count = 0;
        for (sequence, poses) in sequences.iter().enumerate() {
            if poses.width() != channels {
                let (expected, got) = (channels, poses.width());
                return Err(MotionError::Channels { sequence, expected, got });
            }
            values.extend_from_slice(poses.values());
            if !poses.is_empty() {
                ranges.push(count..count + poses.len());
            }
            count += poses.len();
        }
        let poses = Rows::computed(channels, values);
        let pca = Pca::fit(&poses, settings.dimensions)?;
        let points = pca.project(&poses);
        let velocities = field::velocities(&points, &ranges);
        let neighbours = Neighbours::new(points, settings.neighbourhood, settings.k)?;
        Ok(Self { pca, sequences: ranges, neighbours, velocities })
    }

    /// The latent space.
    pub fn pca(&self) -> &Pca {
        &self.pca
    }

    /// Every pose in the latent space, sequence after sequence.
    pub fn points(&self) -> &Rows {
        self.neighbours.points()
    }

    /// Every pose's velocity in the latent space, per frame and halved as in the paper.
    pub fn velocities(&self) -> &Rows {
        &self.velocities
    }

    /// The poses of each sequence that has any.
    pub fn sequences(&self) -> &[Range<usize>] {
        &self.sequences
    }

    /// The triangulation; none with nearest neighbours alone.
    pub fn complex(&self) -> Option<&Complex> {
        self.neighbours.complex()
    }

    /// Which poses are around a place.
    pub fn neighbourhood(&self) -> Neighbourhood {
        self.neighbours.neighbourhood()
    }

    /// Room for searches of this model, so that none of them allocates.
    pub fn around(&self) -> Around {
        self.neighbours.around()
    }

    /// Finds the poses around a latent point, and how much each counts.
    ///
    /// Without allocation if `around` is from [`Self::around`].
    ///
    /// # Panics
    /// If the point has other dimensions: the caller's bug.
    pub fn find(&self, point: &[f64], around: &mut Around) {
        self.neighbours.find(point, around);
    }

    /// The field's velocity at a latent point, per frame and halved as in the paper.
    ///
    /// Without allocation if `around` is from [`Self::around`].
    ///
    /// # Panics
    /// If the point or the velocity has other dimensions: the caller's bug.
    pub fn velocity(&self, point: &[f64], around: &mut Around, velocity: &mut [f64]) {
        self.find(point, around);
        field::mean_velocity(around, &self.velocities, velocity);
    }

    /// Follows the field from a latent point until a condition ends the path.
    ///
    /// # Panics
    /// If the start or the goal has other dimensions: the caller's bug.
    pub fn follow(&self, start: &[f64], settings: &FollowSettings) -> Path {
        field::follow(&self.neighbours, &self.velocities, start, settings)
    }

    /// The demonstrated pose that is nearest to any pose, in the latent space: an end of a
    /// transition ([`super::ShortestPaths::transition`]).
    ///
    /// `None` if the pose is not finite.
    ///
    /// # Panics
    /// If the pose has other channels: the caller's bug.
    pub fn nearest_pose(&self, pose: &[f64]) -> Option<usize> {
        let mut point = vec![0.0; self.pca.dimensions()];
        self.pca.project_pose(pose, &mut point);
        let mut near = Vec::with_capacity(1);
        self.neighbours.nearest(&point, 1, &mut near);
        near.first().map(|near| near.point as usize)
    }

    /// Which pose may follow which: see [`MotionGraph`].
    pub fn graph(&self) -> MotionGraph {
        let points = self.points();
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        if self.neighbourhood() != Neighbourhood::Delaunay {
            // The pose itself is one of them.
            let k = self.neighbours.k();
            let rows = nearest_of_all(points, k + 1);
            for (pose, row) in (0..).zip(rows.chunks_exact((k + 1).min(points.len()))) {
                let others = row.iter().filter(|other| **other != pose).take(k);
                pairs.extend(others.map(|other| [pose, *other]));
            }
        }
        if let Some(complex) = self.complex() {
            pairs.extend(self.neighbours.with_copies(complex.edges()));
        }
        MotionGraph::new(points, &self.velocities, &self.sequences, &pairs)
    }
}
