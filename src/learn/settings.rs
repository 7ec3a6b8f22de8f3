//! What learning may choose.

/// How the edges are searched for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LearnMethod {
    /// Not at all: no edge between the people.
    None,
    /// Edges are added to none.
    Grow,
    /// Edges are taken from those of the first frame's Delaunay tetrahedra of both people.
    Prune,
    /// Edges are added to none and taken away again.
    GrowPrune,
    /// All edges' weights follow the gradient of the distance.
    Gradient,
}

impl LearnMethod {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::None, Self::Grow, Self::Prune, Self::GrowPrune, Self::Gradient];

    /// The name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Grow => "grow",
            Self::Prune => "prune",
            Self::GrowPrune => "grow_prune",
            Self::Gradient => "gradient",
        }
    }

    /// The method of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|method| method.name() == name)
    }
}

/// Bounds and weights of learning.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnSettings {
    /// How the edges are searched for.
    pub method: LearnMethod,
    /// How many references at most, ≥ 1.
    pub references: usize,
    /// A step that brings the distance down by no more than this share `[-]` of it is not taken,
    /// ≥ 0; `gradient` ends where five steps together bring no more.
    pub tolerance: f64,
    /// Steps at most, ≥ 1; of `gradient` before small weights are dropped, and after.
    pub steps: usize,
    /// ω of the active hand `[-]`, > 0; of the other joints it is 1.
    pub hand_weight: f64,
    /// By how much more a frame at contact counts than one far from it `[-]`, ≥ 0.
    pub contact_weight: f64,
    /// How long before and after contact frames count more, fading `[s]`, > 0.
    pub contact_fade: f64,
    /// Phases that an edge has a factor for each (`gradient` only), ≥ 1.
    pub phases: usize,
    /// What a mean weight of 1 costs, as a share `[-]` of the distance without edges (`gradient`
    /// only), ≥ 0: edges that bring less vanish.
    pub sparsity: f64,
    /// Edges whose greatest mean weight is below this share `[-]` of all are dropped (`gradient`
    /// only).
    pub threshold: f64,
}

impl LearnSettings {
    /// The same with one phase, where the method knows no others.
    pub(super) fn with_own_phases(&self) -> Self {
        let phases = if self.method == LearnMethod::Gradient { self.phases } else { 1 };
        Self { phases, ..self.clone() }
    }
}

impl Default for LearnSettings {
    fn default() -> Self {
        Self {
            method: LearnMethod::Grow,
            references: 6,
            tolerance: 1e-3,
            steps: 100,
            hand_weight: 5.0,
            contact_weight: 5.0,
            contact_fade: 0.5,
            phases: 1,
            sparsity: 3e-3,
            threshold: 0.05,
        }
    }
}
