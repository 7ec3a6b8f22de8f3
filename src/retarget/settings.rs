//! What a retargeting may choose: transform, weights, steps, who is known.

/// How the Laplacian coordinates may turn with the mesh: the `Tᵢ` of the energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Transform {
    /// Not at all: `Tᵢ = I`.
    None,
    /// Linearised similarity of each neighbourhood, part of the linear system (Sorkine et al.
    /// 2004): couples x, y and z.
    Implicit,
    /// A rotation for each neighbourhood, alternating with the solve, in the edge form of
    /// as-rigid-as-possible (Sorkine & Alexa 2007).
    LocalGlobal,
}

/// What is known of one joint in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Constraint {
    /// Nothing: it is solved for.
    Free,
    /// A target with this weight `ω > 0` `[-]`, times [`RetargetSettings::known_weight`].
    Soft(f64),
    /// Its exact place; it is no unknown any more, but its own Laplacian row stays.
    Fixed,
}

/// Where the first iterate stands, which the bones' directions are taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// The demonstration as it is: the caller has placed it.
    Reference,
    /// The demonstration, moved rigidly so that its known joints are nearest their targets.
    Aligned,
}

/// Weights and bounds of a solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RetargetSettings {
    /// How Laplacian coordinates may turn.
    pub transform: Transform,
    /// `w_l` `[-]`, > 0.
    pub laplacian_weight: f64,
    /// `w_p` `[-]`, > 0.
    pub known_weight: f64,
    /// `w_b` `[-]`, ≥ 0.
    pub bone_weight: f64,
    /// Steps at most, ≥ 1.
    pub steps: usize,
    /// A step that moves no coordinate farther than this `[m]`, ≥ 0, is the last.
    pub tolerance: f64,
    /// Where the first iterate stands; `local_global` takes rotations against the reference as
    /// it stands there.
    pub start: Start,
    /// `ε` `[-]`, > 0: how much a neighbourhood keeps its last rotation where it is nearly flat or
    /// straight (`local_global` only).
    pub rotation_memory: f64,
}

impl Default for RetargetSettings {
    /// The thesis' weights, no transform, five steps.
    fn default() -> Self {
        Self {
            transform: Transform::None,
            laplacian_weight: 1.0,
            known_weight: 1.5,
            bone_weight: 3.0,
            steps: 5,
            tolerance: 0.0,
            start: Start::Reference,
            rotation_memory: 1e-3,
        }
    }
}

/// Settings outside their bounds, all at once.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", violations.join("; "))]
pub struct SettingsError {
    /// One sentence each: which setting, its value, its bound.
    pub violations: Vec<String>,
}

impl RetargetSettings {
    /// Checks every bound.
    ///
    /// # Errors
    /// [`SettingsError`] with all violations.
    pub fn check(&self) -> Result<(), SettingsError> {
        let positive = |name: &str, value: f64| {
            let fine = value.is_finite() && value > 0.0;
            (!fine).then(|| format!("{name} is {value}, must be finite and > 0"))
        };
        let not_negative = |name: &str, value: f64| {
            let fine = value.is_finite() && value >= 0.0;
            (!fine).then(|| format!("{name} is {value}, must be finite and >= 0"))
        };
        let violations: Vec<String> = [
            positive("laplacian_weight", self.laplacian_weight),
            positive("known_weight", self.known_weight),
            not_negative("bone_weight", self.bone_weight),
            not_negative("tolerance", self.tolerance),
            positive("rotation_memory", self.rotation_memory),
            (self.steps == 0).then(|| "steps is 0, must be >= 1".to_owned()),
        ]
        .into_iter()
        .flatten()
        .collect();
        if violations.is_empty() { Ok(()) } else { Err(SettingsError { violations }) }
    }
}
