//! Shapes of the same vertices → what lies between them and beyond, each part turned and stretched
//! as little as possible (Kaji 2015).
//!
//! A shape is cut into tetrahedra. `Âᵢ` is the linear part of the map that takes tetrahedron `i` of
//! the reference to that of another shape; the maps of all shapes are blended, tetrahedron by
//! tetrahedron, to `Cᵢ`, and the vertices put where their own maps come nearest to them:
//! `E_T = Σ Wᵢ‖Âᵢ − Cᵢ‖²` (Kaji, eq. 3) or, whatever way the tetrahedra are turned,
//! `E_S = Σ Wᵢ‖S(Âᵢ) − S(Cᵢ)‖²` (eq. 4).
//!
//! ```text
//! triangles ─ tetrise ─ structure ─┬─ normal: one sparse factor for x, y and z
//! shapes ───── ghosts ─────────────┴─ gradients ─ maps ─ logarithms ─ (weights) ─ Cᵢ ─ vertices
//! ```
//!
//! Knows nothing of people, joints or time; of units only that all shapes have the same.

mod blender;
mod branches;
mod connections;
mod dense;
mod error;
mod gradients;
mod logarithms;
mod normal;
mod settings;
mod structure;
mod tangent;
mod tetrise;
mod triangles;

pub use blender::{Blended, Blender, Workspace};
pub use dense::{Apart, DenseBlender, DenseWorkspace};
pub use error::BlendError;
pub use settings::{BlendSettings, Energy, Rotation};
pub use structure::Structure;
pub use tetrise::{Tetrisation, Tetrised, tetrise};
pub use triangles::Triangles;
