//! How well a motion model makes up a motion it never saw: the paper's cross-validation.
//!
//! Each sequence of a fold is left out, a model is learned from the other folds' sequences, and the
//! field is followed from the left-out one's first pose for as many steps as it has. The path is
//! then compared with the true one in the latent space (Gauch & Peters IV).

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use crate::motion::{
    Dimensions, FollowSettings, MotionError, MotionModel, MotionSettings, Neighbourhood, Pca, Rows,
    error_a, error_f,
};
use crate::statistics::median;

/// A sequence of poses and what it is called.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedSequence {
    /// The recording, and the person where it has several.
    pub name: String,
    /// Frame after frame.
    pub poses: Rows,
}

/// What a cross-validation may choose.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionProtocol {
    /// The columns.
    pub neighbourhoods: Vec<Neighbourhood>,
    /// How many latent dimensions.
    pub dimensions: Dimensions,
    /// How many nearest poses are neighbours.
    pub k: usize,
    /// Into how many folds the sequences are dealt; at least 2.
    pub folds: usize,
}

impl MotionProtocol {
    /// Of each column's model.
    fn settings(&self) -> impl Iterator<Item = MotionSettings> + '_ {
        let Self { dimensions, k, .. } = *self;
        let of = move |&neighbourhood| MotionSettings { dimensions, neighbourhood, k };
        self.neighbourhoods.iter().map(of)
    }
}

/// One path through one neighbourhood's field, beside the true one.
#[derive(Debug, Clone, PartialEq)]
pub struct PathErrors {
    /// Error A, in the poses' unit.
    pub a: f64,
    /// Error F, in the poses' unit.
    pub f: f64,
    /// Steps taken.
    pub steps: usize,
    /// Of these outside the hull.
    pub outside: usize,
    /// After how many of them it goes nowhere any more: no later step is as long as a thousandth of
    /// the usual one in what was learned from.
    pub moving: usize,
    /// The latent points it passed.
    pub points: Rows,
}

/// A sequence that was left out, and the paths from its start.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    /// The sequence.
    pub name: String,
    /// Its length in frames.
    pub frames: usize,
    /// Its own latent points.
    pub truth: Rows,
    /// A path per neighbourhood, in the columns' order.
    pub paths: Vec<PathErrors>,
}

/// What was learned without a fold, and how it fared on that.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionFold {
    /// Latent dimensions.
    pub dimensions: usize,
    /// The share of the variance they explain.
    pub explained: f64,
    /// Poses learned from: their latent points.
    pub points: Rows,
    /// Edges of the motion graph, per neighbourhood.
    pub edges: Vec<usize>,
    /// Strongly connected components of the motion graph, per neighbourhood.
    pub components: Vec<usize>,
    /// The fold's own sequences.
    pub left_out: Vec<LeftOut>,
}

/// A whole cross-validation.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionEvaluation {
    /// The columns.
    pub neighbourhoods: Vec<Neighbourhood>,
    /// Fold by fold.
    pub folds: Vec<MotionFold>,
}

/// Why there is no cross-validation.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MotionEvaluationError {
    /// Nobody is left to learn from.
    #[error("{sequences} sequence(s); each is made up from the others and needs one")]
    TooFew {
        /// How many there are.
        sequences: usize,
    },
    /// No such model at all.
    #[error(transparent)]
    Settings(MotionError),
    /// No model without a fold.
    #[error("without {left_out}: {error}")]
    Fold {
        /// The sequences left out.
        left_out: String,
        /// Why.
        error: MotionError,
    },
}

/// Leaves out each fold's sequences in turn.
///
/// - `sequences`: dealt one after another, so that up to `folds` of them are left out singly.
/// - `done`: called after each fold, from any thread.
///
/// # Errors
/// [`MotionEvaluationError`] if there is one sequence only, or no model without a fold.
pub fn cross_validate(
    sequences: &[NamedSequence],
    protocol: &MotionProtocol,
    done: impl Fn() + Sync,
) -> Result<MotionEvaluation, MotionEvaluationError> {
    if sequences.len() < 2 {
        return Err(MotionEvaluationError::TooFew { sequences: sequences.len() });
    }
    for settings in protocol.settings() {
        settings.check().map_err(MotionEvaluationError::Settings)?;
    }
    let count = protocol.folds.clamp(2, sequences.len());
    let folds = (0..count).into_par_iter().map(|fold| {
        let (left_out, others): (Vec<_>, Vec<_>) =
            sequences.iter().enumerate().partition(|(at, _)| at % count == fold);
        let left_out: Vec<&NamedSequence> = left_out.into_iter().map(|(_, s)| s).collect();
        let others: Vec<Rows> = others.into_iter().map(|(_, s)| s.poses.clone()).collect();
        let found = one_fold(&left_out, &others, protocol);
        done();
        found.map_err(|error| {
            let names: Vec<&str> = left_out.iter().map(|sequence| sequence.name.as_str()).collect();
            MotionEvaluationError::Fold { left_out: names.join(", "), error }
        })
    });
    // NOTE: collected straight into one result, the error kept would be that of any fold.
    let folds: Vec<Result<MotionFold, MotionEvaluationError>> = folds.collect();
    let folds = folds.into_iter().collect::<Result<_, _>>()?;
    Ok(MotionEvaluation { neighbourhoods: protocol.neighbourhoods.clone(), folds })
}

fn one_fold(
    left_out: &[&NamedSequence],
    others: &[Rows],
    protocol: &MotionProtocol,
) -> Result<MotionFold, MotionError> {
    let models = protocol.settings().map(|settings| MotionModel::fit(others, settings));
    let models: Vec<MotionModel> = models.collect::<Result<_, _>>()?;
    let graphs: Vec<_> = models.iter().map(MotionModel::graph).collect();
    // They differ in their neighbourhoods only.
    let first = models.first().ok_or(MotionError::NoPoses)?;
    let pca = first.pca();
    let paths = |sequence: &&NamedSequence| -> Result<LeftOut, MotionError> {
        let truth = project(pca, &sequence.poses)?;
        let paths = models.iter().map(|model| path_errors(model, &truth)).collect();
        Ok(LeftOut { name: sequence.name.clone(), frames: truth.len(), truth, paths })
    };
    Ok(MotionFold {
        dimensions: pca.dimensions(),
        explained: pca.explained()[..pca.dimensions()].iter().sum(),
        points: first.points().clone(),
        edges: graphs.iter().map(|graph| graph.edge_count()).collect(),
        components: graphs.iter().map(|graph| graph.components().len()).collect(),
        left_out: left_out.iter().map(paths).collect::<Result<_, _>>()?,
    })
}

/// A sequence that was left out, in the latent space.
fn project(pca: &Pca, poses: &Rows) -> Result<Rows, MotionError> {
    if poses.width() != pca.channels() {
        let (expected, got) = (pca.channels(), poses.width());
        return Err(MotionError::Channels { sequence: 0, expected, got });
    }
    if poses.is_empty() { Err(MotionError::NoPoses) } else { Ok(pca.project(poses)) }
}

/// The path from a sequence's first point, as long as the sequence.
fn path_errors(model: &MotionModel, truth: &Rows) -> PathErrors {
    let settings = FollowSettings { steps: truth.len() - 1, still: 0.0, goal: None };
    let path = model.follow(truth.row(0), &settings);
    PathErrors {
        a: error_a(&path.points, truth),
        f: error_f(&path.points, truth),
        steps: path.points.len() - 1,
        outside: path.outside,
        moving: moving(&path.points, usual_step(model)),
        points: path.points,
    }
}

/// The median step of the poses that a model was learned from, as long as the field takes it.
fn usual_step(model: &MotionModel) -> f64 {
    let length = |velocity: &[f64]| velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
    median(model.velocities().iter().map(length).collect()).unwrap_or(0.0)
}

/// Steps until none is as long as a thousandth of the usual one.
fn moving(points: &Rows, usual: f64) -> usize {
    let step = |at: usize| -> f64 {
        let (from, to) = (points.row(at - 1), points.row(at));
        from.iter().zip(to).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    };
    (1..points.len()).rev().find(|at| step(*at) > 1e-3 * usual).unwrap_or(0)
}

impl MotionEvaluation {
    /// All sequences that were left out, fold by fold.
    pub fn left_out(&self) -> impl Iterator<Item = &LeftOut> {
        self.folds.iter().flat_map(|fold| &fold.left_out)
    }

    /// The median over all sequences, per neighbourhood.
    pub fn medians(&self, error: impl Fn(&PathErrors) -> f64) -> Vec<Option<f64>> {
        let of = |column: usize| median(self.left_out().map(|s| error(&s.paths[column])).collect());
        (0..self.neighbourhoods.len()).map(of).collect()
    }

    /// `{"dims","folds":[{"dims","explained","poses","edges":{N},"components":{N},"sequences":[
    /// {"name","frames","error_a":{N},"error_f":{N},"steps":{N},"moving":{N},"outside":{N}}]}],"error_a":{N},
    /// "error_f":{N}}` with a number per neighbourhood `N`; the last two are medians over all
    /// sequences, `dims` is null where folds differ.
    pub fn to_json(&self) -> Value {
        let folds: Vec<Value> = self.folds.iter().map(|fold| self.fold_json(fold)).collect();
        let dims = self.folds.first().map(|fold| fold.dimensions);
        let dims = dims.filter(|dims| self.folds.iter().all(|fold| fold.dimensions == *dims));
        json!({
            "dims": dims,
            "folds": folds,
            "error_a": self.each(&self.medians(|errors| errors.a)),
            "error_f": self.each(&self.medians(|errors| errors.f)),
        })
    }

    fn fold_json(&self, fold: &MotionFold) -> Value {
        let sequences = fold.left_out.iter().map(|sequence| {
            let each = |value: fn(&PathErrors) -> Value| {
                self.each(&sequence.paths.iter().map(value).collect::<Vec<_>>())
            };
            json!({
                "name": sequence.name,
                "frames": sequence.frames,
                "error_a": each(|errors| json!(errors.a)),
                "error_f": each(|errors| json!(errors.f)),
                "steps": each(|errors| json!(errors.steps)),
                "moving": each(|errors| json!(errors.moving)),
                "outside": each(|errors| json!(errors.outside)),
            })
        });
        json!({
            "dims": fold.dimensions,
            "explained": fold.explained,
            "poses": fold.points.len(),
            "edges": self.each(&fold.edges),
            "components": self.each(&fold.components),
            "sequences": sequences.collect::<Vec<_>>(),
        })
    }

    /// `{NEIGHBOURHOOD: value}`.
    fn each<T: serde::Serialize>(&self, values: &[T]) -> Value {
        let columns = self.neighbourhoods.iter().zip(values);
        Value::Object(
            columns.map(|(n, value)| (n.name().to_owned(), json!(value))).collect::<Map<_, _>>(),
        )
    }
}
