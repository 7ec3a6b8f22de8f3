//! Which way shapes are blended.

use super::{BlendError, Tetrisation};
use crate::settings::{self, count, real};

/// How the maps of one tetrahedron are blended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Rotation {
    /// `Blend_P`: angles up to π, stretches added; may turn a tetrahedron inside out.
    Principal,
    /// `Blend_C`: angles continuous over neighbours, logarithms of stretches added.
    Continuous,
}

impl Rotation {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Principal, Self::Continuous];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Principal => "p",
            Self::Continuous => "c",
        }
    }
}

/// What the vertices make least.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Energy {
    /// `E_T = Σ W‖Â − C‖²`: one solve.
    Transforms,
    /// `E_S = Σ W‖S(Â) − S(C)‖²`, whatever way the tetrahedra are turned, by turns of
    /// `R = polar(Â S(C))` and of the minimum of `Σ W‖Â − R S(C)‖²`, which never rises.
    Shears,
    /// The same with `R = polar(Â)`, as it is printed: it may rise.
    ShearsPrinted,
}

impl Energy {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Transforms, Self::Shears, Self::ShearsPrinted];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Transforms => "t",
            Self::Shears => "s",
            Self::ShearsPrinted => "s_printed",
        }
    }
}

/// How shapes are blended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlendSettings {
    /// Where the ghosts are, of triangles.
    pub tetrisation: Tetrisation,
    /// How maps are blended.
    pub rotation: Rotation,
    /// What is made least.
    pub energy: Energy,
    /// Iterations of `E_S` at most, 1 to 100,000.
    pub iterations: usize,
    /// An iteration of `E_S` that moves no vertex farther than this share of the reference's extent
    /// `[-]`, 0 to 1, is the last.
    pub tolerance: f64,
}

impl Default for BlendSettings {
    fn default() -> Self {
        Self {
            tetrisation: Tetrisation::Vertex,
            rotation: Rotation::Continuous,
            energy: Energy::Transforms,
            iterations: 100,
            tolerance: 1e-6,
        }
    }
}

impl BlendSettings {
    pub(super) fn check(mut self) -> Result<Self, BlendError> {
        settings::check([
            count("iterations", &mut self.iterations, 1, 100_000),
            real("tolerance", &mut self.tolerance, 0.0, 1.0),
        ])?;
        Ok(self)
    }
}
