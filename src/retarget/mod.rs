//! Laplacian retargeting: a demonstration's mesh and where the partner is → where the robot's
//! joints belong.
//!
//! Minimises `w_l Σ‖L v'ᵢ − Tᵢ δᵢ‖² + w_p Σ ω‖v'ⱼ − cⱼ‖² + w_b Σ‖(v'ᵢ − v'ⱼ) − l uᵢⱼ‖²` (Thai 2014,
//! eq. 3.3; Sorkine et al. 2004), where `uᵢⱼ` is the bone's direction at the last iterate (Weng et
//! al. 2006): each step is a back-substitution in one factorised system, and the energy with true
//! bones never rises.
//!
//! The path of the data: [`Retargeter::new`] (who is known: pattern of the system) →
//! [`Retargeter::assemble`] (a mesh: its numbers) → [`Retargeter::factor`] →
//! [`Retargeter::solve`] (targets) → [`project_bones`] where bones must be exact.

mod adjoint;
mod band;
mod bones;
mod energy;
mod error;
mod fill;
mod implicit;
mod neighbourhoods;
mod prepared;
mod pull;
mod row_slopes;
mod settings;
mod solve;
mod system;

pub use adjoint::NoDerivative;
pub use band::{BandMatrix, NotPositiveDefinite};
pub use bones::project_bones;
pub use error::RetargetError;
pub use prepared::{Prepared, Variation, VariationError};
pub use settings::{Constraint, RetargetSettings, SettingsError, Start, Transform};
pub use solve::{Residual, Retargeter, Workspace};
