//! The protocol `thesis`: one input motion, retargeted to each of several recordings, before and
//! after its interaction mesh was trained on one of them (Thai 2014, 4.2, tables 4.1 and 4.2).
//!
//! The distance is `d(V', V) = Σᵢ ωᵢ ‖vᵢ − v'ᵢ‖` `[m]` (eq. 3.9) over all frames and the robot
//! role's joints, ωᵢ = 1; what is known (the partner, the robot's base) is exact and adds nothing,
//! joints to be ignored are left out.
//!
//! The input motion is laid on each target's time and place as predictions are, by the observed
//! partner alone. All recordings, input and targets, are smoothed alike; distances are those of the
//! solved mesh, whose bones are soft, and no gap is held at contact: what edges do is not mixed
//! with what else brings hands together.

use std::sync::Arc;

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::TrialError;
use super::predictors::{EvaluateError, EvaluateSettings};
use super::trial::UnknownJoint;
use crate::demonstration::Demonstration;
use crate::learn::{LearnMethod, LearnSettings, Lessons, Move, Search, Step};
use crate::mesh::{Kernel, Pair};
use crate::predict::{LearnedEdges, Predictor};

/// The row of the table that nothing was learned for.
const UNTRAINED: &str = "untrained";

/// What was learned on one target, and what it is worth on all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Training {
    /// The edges found, named for the hands that meet in the input motion.
    pub edges: LearnedEdges,
    /// How they were found.
    pub steps: Vec<Step>,
    /// The distance `[m]` to the own target at the start and after each step.
    pub curve: Vec<f64>,
    /// The distance `[m]` to each target.
    pub distances: Vec<f64>,
}

/// Distances `[m]` of a row to the target trained on and, on average, to the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Average {
    /// To the target trained on.
    pub own: f64,
    /// The mean over the other targets.
    pub others: f64,
}

/// The table of the thesis: a row a training, a column a target.
#[derive(Debug, Clone, PartialEq)]
pub struct Thesis {
    /// The targets' names and lengths in frames; the first is the input motion.
    pub clips: Vec<(String, usize)>,
    /// How edges were searched for.
    pub method: LearnMethod,
    /// How edges weigh.
    pub kernel: Kernel,
    /// Before any training, the distance `[m]` to each target: without an edge between the people,
    /// and for [`LearnMethod::Prune`] with those of the target's own first frame's tetrahedra.
    pub untrained: Vec<f64>,
    /// What each target teaches, in the targets' order.
    pub trainings: Vec<Training>,
    pair: Arc<Pair>,
    people: [String; 2],
}

/// Trains the input motion's mesh on each recording and applies it to all.
///
/// - `clips`: the first is the input motion, all are targets.
/// - `settings`: `methods`, `folds` and what makes joints and frames count differently are not
///   heeded.
/// - `done`: called after each training, from any thread.
///
/// Edges are named for the hands that meet in the input motion, and change sides where a target's
/// others meet. The result does not depend on the number of threads.
///
/// # Errors
/// [`EvaluateError::NoTargets`] of fewer than two recordings; [`EvaluateError::Clip`] if one cannot
/// be aligned or solved.
pub fn thesis(
    clips: &[Arc<Demonstration>],
    settings: &EvaluateSettings,
    done: impl Fn() + Sync,
) -> Result<Thesis, EvaluateError> {
    let [input, _, ..] = clips else {
        return Err(EvaluateError::NoTargets { clips: clips.len() });
    };
    let learn = LearnSettings { hand_weight: 1.0, contact_weight: 0.0, ..settings.learn.clone() };
    let predictor = Predictor::fit(vec![input.clone()], settings.predict.clone())
        .map_err(|error| of_clip(input)(error.into()))?;
    let lessons: Vec<Lessons> = clips
        .par_iter()
        .map(|clip| {
            lesson(&predictor, clip, &settings.ignored_joints, &learn).map_err(of_clip(clip))
        })
        .collect::<Result<_, _>>()?;
    let mut trainings: Vec<Training> = clips
        .par_iter()
        .zip(&lessons)
        .map(|(clip, lessons)| {
            let training = train(lessons.clone(), &learn).map_err(of_clip(clip));
            done();
            training
        })
        .collect::<Result<_, _>>()?;
    let columns: Vec<Vec<f64>> = clips
        .par_iter()
        .zip(lessons)
        .map(|(clip, lessons)| reconstruct(lessons, &trainings).map_err(of_clip(clip)))
        .collect::<Result<_, _>>()?;
    for (row, training) in trainings.iter_mut().enumerate() {
        training.distances = columns.iter().map(|column| column[row]).collect();
    }
    let recording = |clip: &Arc<Demonstration>| clip.recording().clone();
    Ok(Thesis {
        clips: clips.iter().map(recording).map(|r| (r.name().to_owned(), r.len())).collect(),
        method: learn.method,
        kernel: settings.predict.kernel,
        untrained: trainings.iter().map(|training| training.curve[0]).collect(),
        trainings,
        pair: Arc::new(Pair::of(input.recording())),
        people: input.recording().people().each_ref().map(|person| person.name.clone()),
    })
}

fn of_clip(clip: &Demonstration) -> impl Fn(TrialError) -> EvaluateError {
    |error| EvaluateError::Clip { clip: clip.recording().name().to_owned(), error }
}

/// The input motion, to be retargeted to one target.
fn lesson(
    predictor: &Predictor,
    target: &Demonstration,
    ignored: &[String],
    learn: &LearnSettings,
) -> Result<Lessons, TrialError> {
    let ignored = UnknownJoint::find(target.robot().skeleton(), ignored)?;
    let settings = predictor.settings();
    let target = target.smoothed(settings.smoothing);
    let problem = predictor.plain_problem(&target.observation(), target.contact().hands)?;
    let named_for = predictor.demonstrations()[0].contact().hands;
    Ok(Lessons::single(&target, &problem, named_for, &ignored, settings, learn)?)
}

/// Learns from one target; its distances to the others are not known yet.
fn train(lessons: Lessons, learn: &LearnSettings) -> Result<Training, TrialError> {
    let mut search = Search::new(lessons, learn.clone())?;
    let (mut curve, mut steps) = (vec![search.initial()], Vec::new());
    while let Some(step) = search.step(|| ())? {
        // Anew, as the table has it: a step's own distance is that of a changed system.
        curve.push(search.lessons().distance()?);
        steps.push(step);
    }
    // Before it ends, `gradient` may drop small factors.
    if let Some(last) = curve.last_mut() {
        *last = search.lessons().distance()?;
    }
    Ok(Training { edges: search.edges()?, steps, curve, distances: Vec::new() })
}

/// One target's distances `[m]` with what each training found.
fn reconstruct(mut lessons: Lessons, trainings: &[Training]) -> Result<Vec<f64>, TrialError> {
    let distance = |training: &Training| -> Result<f64, TrialError> {
        lessons.set_edges(&training.edges)?;
        Ok(lessons.distance()?)
    };
    trainings.iter().map(distance).collect()
}

impl Thesis {
    /// What a training is worth: on average with its edges, and before any training over the same
    /// targets.
    ///
    /// # Panics
    /// If there is no such training.
    pub fn average(&self, training: usize) -> [Average; 2] {
        [&self.trainings[training].distances, &self.untrained].map(|distances| {
            let others = distances.iter().sum::<f64>() - distances[training];
            Average { own: distances[training], others: others / (distances.len() - 1) as f64 }
        })
    }

    /// `{"protocol","role","method","kernel","input","clips":[{"name","frames"}],
    /// "table":{TRAINING:{TARGET: d}},"curves":{TRAINING:[d]},
    /// "steps":{TRAINING:[{"edge":[JOINT, JOINT],"move"}]},
    /// "average":{TRAINING:{"own","others","untrained":{"own","others"}}}}`, distances in metres.
    ///
    /// The table's first row is `untrained`; a curve has the distance at the start and after each
    /// step; a joint is `person/joint`. A step of `gradient` moves all edges: its edge is null.
    pub fn to_json(&self, role: &str) -> Value {
        let names = || self.clips.iter().map(|(name, _)| name.clone());
        let row = |distances: &[f64]| -> Value {
            names().zip(distances.iter().map(|d| json!(d))).collect::<Map<_, _>>().into()
        };
        let each = |value: &dyn Fn(usize, &Training) -> Value| -> Map<String, Value> {
            let rows = self.trainings.iter().enumerate();
            names().zip(rows.map(|(at, training)| value(at, training))).collect()
        };
        let mut table = Map::from_iter([(UNTRAINED.to_owned(), row(&self.untrained))]);
        table.extend(each(&|_, training| row(&training.distances)));
        let steps = |training: &Training| -> Value {
            training.steps.iter().map(|step| self.step_json(step)).collect()
        };
        let average = |at: usize| {
            let [trained, untrained] = self.average(at);
            json!({
                "own": trained.own,
                "others": trained.others,
                UNTRAINED: { "own": untrained.own, "others": untrained.others },
            })
        };
        let clip = |(name, frames): &(String, usize)| json!({ "name": name, "frames": frames });
        json!({
            "protocol": "thesis",
            "role": role,
            "method": self.method.name(),
            "kernel": self.kernel.name(),
            "input": self.clips[0].0,
            "clips": self.clips.iter().map(clip).collect::<Vec<_>>(),
            "table": table,
            "curves": each(&|_, training| json!(training.curve)),
            "steps": each(&|_, training| steps(training)),
            "average": each(&|at, _| average(at)),
        })
    }

    fn step_json(&self, step: &Step) -> Value {
        let people = self.people.each_ref().map(String::as_str);
        let (edge, name) = match &step.change {
            Move::Add(edge) => (Some(edge), "add"),
            Move::Remove(edge) => (Some(edge), "remove"),
            Move::Descend(_) => (None, "descend"),
        };
        json!({ "edge": edge.map(|edge| edge.names(&self.pair, people)), "move": name })
    }
}
