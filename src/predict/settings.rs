//! The numbers behind a prediction.

use crate::align::WarpSettings;
use crate::mesh::Kernel;
use crate::retarget::RetargetSettings;

/// How a solve takes the joints that are known: the partner's, and the robot's base.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KnownJoints {
    /// Exactly, as constants of the system.
    Eliminated,
    /// As targets with [`RetargetSettings::known_weight`].
    Soft,
}

/// How several demonstrations become one reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReferenceBlend {
    /// Their weighted mean, joint by joint.
    Mean,
    /// As shapes, each part turned and stretched as little as possible (Kaji 2015).
    Rigid,
}

/// How demonstrations are aligned, meshed and retargeted, and how the baselines are fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictSettings {
    /// How many of the nearest demonstrations make the reference, ≥ 1.
    pub demonstrations: usize,
    /// How they make it.
    pub blend: ReferenceBlend,
    /// Standard deviation of the smoothing of observed and demonstrated motion `[s]`, ≥ 0.
    pub smoothing: f64,
    /// Bounds of the time alignment; the penalty is in metres.
    pub warp: WarpSettings,
    /// Weight `[-]` of the two people's distance beside the partner's pose in the alignment, ≥ 0.
    pub distance_weight: f64,
    /// How long before and after contact `mesh` holds the demonstrations' gap at contact in its
    /// reference, fading `[s]`, > 0.
    pub contact_fade: f64,
    /// How an interperson edge's weight falls with distance.
    pub kernel: Kernel,
    /// Weight `[-]` of the mesh's temporal edges, ≥ 0.
    pub time_weight: f64,
    /// Whether known joints are exact.
    pub known: KnownJoints,
    /// The solve.
    pub retarget: RetargetSettings,
    /// Ridge penalty `[-]` of `ridge`, per sample, on standardised features; > 0.
    pub ridge_penalty: f64,
    /// Basis functions of `promp`, ≥ 2.
    pub promp_bases: usize,
    /// Share `[-]` of the demonstrations' variance, summed over all coordinates, that `promp` takes
    /// for noise; > 0.
    pub promp_noise: f64,
    /// How long before and after contact `attach` fades its hand in and out `[s]`, > 0.
    pub attach_fade: f64,
}

impl Default for PredictSettings {
    fn default() -> Self {
        Self {
            demonstrations: 5,
            blend: ReferenceBlend::Mean,
            smoothing: 0.05,
            warp: WarpSettings { pause_penalty: 0.02, slack: 0.1 },
            distance_weight: 0.2,
            contact_fade: 1.0,
            kernel: Kernel::InverseDistance {
                scale: 30.0,
                power: 4.0,
                reference: 0.1,
                minimum: 0.05,
            },
            time_weight: 1.0,
            known: KnownJoints::Eliminated,
            retarget: RetargetSettings::default(),
            ridge_penalty: 1e-2,
            promp_bases: 15,
            promp_noise: 0.03,
            attach_fade: 1.0,
        }
    }
}
