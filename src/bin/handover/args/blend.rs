//! What `handover blend` is told.

use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;
use handover_mesh::blend::{BlendSettings, Energy, Rotation, Tetrisation};

use crate::UsageError;

/// Blend poses of one shape, by more or less than all of each.
///
/// All weights 0 are the reference, one of them 1 and the others 0 that pose; below 0 and above 1
/// they go beyond. Limbs turn where a plain mean would shrink them (Kaji, Tetrisation of triangular
/// meshes and its application in shape blending, 2015); docs/blend.md says how.
///
/// What is written is REFERENCE with other places and normals: its faces, groups, materials and
/// texture coordinates stay as they are. With several -w, or with --frames, files are numbered:
/// OUT_000.obj, OUT_001.obj and so on.
#[derive(Debug, Args)]
pub(crate) struct Blend {
    /// The shape that all weights 0 stand for (.obj)
    #[arg(value_name = "REFERENCE")]
    pub(crate) reference: PathBuf,
    /// The same shape in other poses: as many vertices, the same faces
    #[arg(value_name = "POSE", required = true)]
    pub(crate) poses: Vec<PathBuf>,
    /// How much of each pose, any numbers with commas between, e.g. -0.5,1.5; may be repeated
    #[arg(long, short, value_name = "W1,W2", required = true, allow_hyphen_values = true,
          value_parser = weights)]
    pub(crate) weights: Vec<Weights>,
    /// Write the shape here (.obj)
    #[arg(long, short, value_name = "OUT")]
    pub(crate) out: PathBuf,
    /// What makes tetrahedra of triangles: a ghost vertex over each face, edge or vertex
    /// [default: vertex]
    #[arg(long, value_name = "OVER",
          value_parser = PossibleValuesParser::new(Tetrisation::ALL.map(Tetrisation::name)))]
    tetrisation: Option<String>,
    /// What is kept as well as it can be: each tetrahedron's transform (t), or only its shear (s,
    /// by iterations that come to rest slowly; s_printed as the paper has it) [default: t]
    #[arg(long, value_name = "E",
          value_parser = PossibleValuesParser::new(Energy::ALL.map(Energy::name)))]
    energy: Option<String>,
    /// Rotations by their principal logarithm and shears by their mean (p), or both by logarithms
    /// that are continuous over the shape (c) [default: c]
    #[arg(long, value_name = "R",
          value_parser = PossibleValuesParser::new(Rotation::ALL.map(Rotation::name)))]
    rotation: Option<String>,
    /// Iterations of the energies s and s_printed at most [default: 100]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    iterations: Option<u32>,
    /// An iteration that moves no vertex farther than this share of the reference's extent is the
    /// last [default: 1e-6]
    #[arg(long, value_name = "X", value_parser = tolerance, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Write N shapes on the way from the reference through each -w in turn, all of them included
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub(crate) frames: Option<u32>,
}

/// One weight a pose.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Weights(pub(crate) Vec<f64>);

impl Blend {
    /// The settings asked for.
    ///
    /// # Errors
    /// [`UsageError`] if an option would do nothing.
    pub(crate) fn settings(&self) -> Result<BlendSettings, UsageError> {
        let mut settings = BlendSettings::default();
        let is = |given: &Option<String>, name: &str| given.as_deref() == Some(name);
        settings.tetrisation = named(Tetrisation::ALL, |t| is(&self.tetrisation, t.name()))
            .unwrap_or(settings.tetrisation);
        settings.energy =
            named(Energy::ALL, |e| is(&self.energy, e.name())).unwrap_or(settings.energy);
        settings.rotation =
            named(Rotation::ALL, |r| is(&self.rotation, r.name())).unwrap_or(settings.rotation);
        if settings.energy == Energy::Transforms {
            let idle = [
                ("iterations", self.iterations.is_some()),
                ("tolerance", self.tolerance.is_some()),
            ];
            if let Some((option, _)) = idle.into_iter().find(|(_, given)| *given) {
                return Err(UsageError(format!(
                    "--{option}: the energy t is solved at once (hint: --energy s)"
                )));
            }
        }
        settings.iterations = self.iterations.map_or(settings.iterations, |n| n as usize);
        settings.tolerance = self.tolerance.unwrap_or(settings.tolerance);
        Ok(settings)
    }
}

fn named<T: Copy>(all: impl IntoIterator<Item = T>, is: impl Fn(&T) -> bool) -> Option<T> {
    all.into_iter().find(is)
}

/// `1,0.5,-2`.
fn weights(text: &str) -> Result<Weights, String> {
    let weight = |text: &str| match text.trim().parse::<f64>() {
        Ok(weight) if weight.is_finite() => Ok(weight),
        _ => Err(format!("'{text}' is no finite number")),
    };
    text.split(',').map(weight).collect::<Result<_, _>>().map(Weights)
}

/// A share from 0 to 1.
fn tolerance(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|share| (0.0..=1.0).contains(share));
    share.ok_or_else(|| "not a number from 0 to 1".to_owned())
}
