//! Why there is no motion model.

use super::LARGEST;
use crate::delaunay::DelaunayError;

/// Why poses make no motion model; sequences, poses, rows and columns count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MotionError {
    /// Numbers that fill no rows of this width.
    #[error("{values} numbers make no rows of {width}")]
    Ragged {
        /// Numbers per row.
        width: usize,
        /// Numbers there are.
        values: usize,
    },
    /// A number is NaN, infinite, or of a size nothing here has.
    #[error("row {row}, column {column}: {value:e} is no number of size up to {LARGEST:e}")]
    OutOfRange {
        /// Which row.
        row: usize,
        /// Which column.
        column: usize,
        /// The number.
        value: f64,
    },
    /// Nothing to learn from.
    #[error("no sequence, or none with a pose")]
    NoPoses,
    /// A sequence's poses have other channels than the first's.
    #[error("sequence {sequence} has poses of {got} channels, the first one of {expected}")]
    Channels {
        /// Which sequence.
        sequence: usize,
        /// The first one's channels.
        expected: usize,
        /// This one's.
        got: usize,
    },
    /// The share of variance asked for is none.
    #[error("a share of the variance lies above 0 and not above 1, got {share}")]
    Share {
        /// What was asked for.
        share: f64,
    },
    /// The poses do not fill as many dimensions.
    #[error("{dimensions} latent dimensions, but {}", spanned(*.poses, *.rank))]
    Rank {
        /// Dimensions asked for, at least 1.
        dimensions: usize,
        /// How many poses there are.
        poses: usize,
        /// Dimensions they span.
        rank: usize,
    },
    /// No triangulation in as many dimensions.
    #[error(
        "the Delaunay triangulation takes 2 to 4 latent dimensions, not {dimensions}: above 4 its \
         simplices are too many (hint: neighbourhood knn takes any)"
    )]
    Dimensions {
        /// Dimensions asked for.
        dimensions: usize,
    },
    /// The latent points have no triangulation.
    #[error("no Delaunay triangulation of the latent points: {0} (hint: neighbourhood knn)")]
    Delaunay(#[from] DelaunayError),
    /// Too many poses for a table of all pairs.
    #[error("shortest paths between all of {poses} poses, at most {most} are taken")]
    TooManyPaths {
        /// How many poses there are.
        poses: usize,
        /// The most there may be.
        most: usize,
    },
}

fn spanned(poses: usize, rank: usize) -> String {
    match rank {
        0 => format!("the {poses} poses are all alike"),
        _ => format!("the {poses} poses span {rank} (hint: fewer dimensions)"),
    }
}
