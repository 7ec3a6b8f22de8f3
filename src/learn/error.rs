//! Why nothing is learned.

use crate::mesh::MeshError;
use crate::predict::{EdgesError, PredictError};
use crate::retarget::{NoDerivative, RetargetError, VariationError};

/// Why nothing is learned.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LearnError {
    /// Nothing to learn from.
    #[error("no reference motion to learn from: edges take demonstrations of at least two groups")]
    NoLessons,
    /// The skeletons make no pair of people who could be joined.
    #[error(transparent)]
    Edges(#[from] EdgesError),
    /// A reference could not be aligned.
    #[error(transparent)]
    Predict(#[from] PredictError),
    /// A reference makes no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A reference could not be solved.
    #[error(transparent)]
    Retarget(#[from] RetargetError),
    /// The transform has no derivatives.
    #[error("learn.method is gradient, and {0}")]
    NoDerivative(#[from] NoDerivative),
    /// A step to redo does not fit: it is of another run.
    #[error("step {step} is not of this run: {reason}")]
    Step {
        /// The step, counted from 1.
        step: usize,
        /// What does not fit.
        reason: String,
    },
}

impl From<VariationError> for LearnError {
    fn from(error: VariationError) -> Self {
        match error {
            VariationError::Mesh(error) => Self::Mesh(error),
            VariationError::Retarget(error) => Self::Retarget(error),
        }
    }
}
