//! Why a retargeting fails.

use super::SettingsError;

/// Why a retargeting could not be set up or solved. Joints count over both people.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RetargetError {
    /// A setting is outside its bounds.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Constraints, targets or lengths do not fit the mesh.
    #[error("{what}: {got} given, {expected} expected")]
    Shape {
        /// What does not fit.
        what: &'static str,
        /// How many are expected.
        expected: usize,
        /// How many were given.
        got: usize,
    },
    /// A soft constraint's weight is not a positive number.
    #[error("frame {frame}, joint {joint}: constraint weight {weight} must be finite and > 0")]
    Weight {
        /// The frame, counted from 0.
        frame: usize,
        /// The joint.
        joint: usize,
        /// The weight at fault.
        weight: f64,
    },
    /// A known joint's target, or a bone's length, is NaN or infinite.
    #[error("frame {frame}, joint {joint}: target is not finite")]
    NotFinite {
        /// The frame, counted from 0.
        frame: usize,
        /// The joint.
        joint: usize,
    },
    /// A bone's length is not a positive number.
    #[error("bone {bone}: length {length} must be finite and > 0")]
    Length {
        /// The bone, in [`crate::mesh::Pair::bones`] order.
        bone: usize,
        /// Its length `[m]`.
        length: f64,
    },
    /// The known joints do not determine where this one is.
    #[error("frame {frame}, joint {joint}: nothing known holds it in place")]
    Unanchored {
        /// The frame, counted from 0.
        frame: usize,
        /// The joint.
        joint: usize,
    },
}
