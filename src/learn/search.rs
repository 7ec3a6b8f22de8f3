//! A search for edges, one step after another.

use super::climb::Climb;
use super::descent::{Descent, DescentState};
use super::{LearnError, LearnMethod, LearnSettings, Lessons};
use crate::mesh::Edge;
use crate::predict::{LearnedEdges, Predictor};
use crate::skeleton::JointId;

/// What a step does.
#[derive(Debug, Clone, PartialEq)]
pub enum Move {
    /// An edge is added.
    Add(Edge),
    /// An edge is taken away.
    Remove(Edge),
    /// All weights move down the gradient, to where the descent is then.
    Descend(DescentState),
}

/// One step of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// What it does.
    pub change: Move,
    /// The distance `[m]` before.
    pub before: f64,
    /// The distance `[m]` after.
    pub distance: f64,
}

/// How the method looks for its next step.
#[derive(Debug, Clone)]
enum Strategy {
    Climb(Climb),
    Descent(Descent),
}

impl Strategy {
    fn factors(&self) -> Vec<f64> {
        match self {
            Self::Climb(climb) => climb.factors(),
            Self::Descent(descent) => descent.factors(),
        }
    }
}

/// A search under way: every step depends on the one before it alone, so that a search that was
/// broken off goes on as if it had not been once its steps are redone.
#[derive(Debug, Clone)]
pub struct Search {
    pub(super) lessons: Lessons,
    pub(super) settings: LearnSettings,
    strategy: Strategy,
    initial: f64,
    evaluations: usize,
    steps: usize,
    finished: bool,
}

impl Search {
    /// Stands at the method's start.
    ///
    /// # Errors
    /// [`LearnError`] if the start cannot be solved; [`LearnError::NoDerivative`] if the method is
    /// `gradient` and the transform `local_global`.
    pub fn new(mut lessons: Lessons, settings: LearnSettings) -> Result<Self, LearnError> {
        let strategy = match settings.method {
            LearnMethod::Gradient => {
                for lesson in lessons.lessons() {
                    lesson.prepared.check_slopes()?;
                }
                Strategy::Descent(Descent::start(&mut lessons, &settings)?)
            }
            method => Strategy::Climb(Climb::start(method, &lessons)),
        };
        let finished = settings.method == LearnMethod::None;
        let mut search =
            Self { lessons, settings, strategy, initial: 0.0, evaluations: 1, steps: 0, finished };
        search.set_factors()?;
        search.initial = search.lessons.distance()?;
        Ok(search)
    }

    fn phases(&self) -> usize {
        match self.strategy {
            Strategy::Climb(_) => 1,
            Strategy::Descent(_) => self.settings.phases,
        }
    }

    fn set_factors(&mut self) -> Result<(), LearnError> {
        self.lessons.set_factors(&self.strategy.factors(), self.phases())
    }

    /// The distance `[m]` at the start.
    pub fn initial(&self) -> f64 {
        self.initial
    }

    /// How many sets of edges have been measured, over all references each.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// How many the next step will measure, about.
    pub fn next_evaluations(&self) -> usize {
        match &self.strategy {
            Strategy::Climb(climb) => climb.moves(self.settings.method).count(),
            // More where a step goes too far at first.
            Strategy::Descent(_) => 1,
        }
    }

    /// How it searches.
    pub fn settings(&self) -> &LearnSettings {
        &self.settings
    }

    /// The lessons, with the edges found so far.
    pub fn lessons(&self) -> &Lessons {
        &self.lessons
    }

    /// Takes the best step; `None` if there is none, or the bound is reached.
    ///
    /// - `measured`: called after each set of edges measured, from any thread.
    ///
    /// The result does not depend on the number of threads.
    ///
    /// # Errors
    /// [`LearnError`] if a mesh cannot be solved.
    pub fn step(&mut self, measured: impl Fn() + Sync) -> Result<Option<Step>, LearnError> {
        if self.finished {
            return Ok(None);
        }
        let before = self.lessons.distance()?;
        let change = match &mut self.strategy {
            Strategy::Climb(climb) => {
                let better = before - self.settings.tolerance * before;
                let at_bound = self.steps >= self.settings.steps;
                let found = if at_bound {
                    None
                } else {
                    self.evaluations += climb.moves(self.settings.method).count();
                    climb.best(self.settings.method, &self.lessons, measured)?
                };
                let found = found.filter(|(_, distance)| *distance < better);
                found.map(|(candidate, _)| climb.toggle(candidate, self.lessons.candidates()))
            }
            Strategy::Descent(descent) => {
                let (evaluations, taken) =
                    descent.step(&mut self.lessons, &self.settings, &measured)?;
                self.evaluations += evaluations;
                taken.then(|| Move::Descend(descent.state(self.evaluations)))
            }
        };
        self.set_factors()?;
        let Some(change) = change else {
            self.finished = true;
            return Ok(None);
        };
        self.steps += 1;
        Ok(Some(Step { change, before, distance: self.lessons.distance()? }))
    }

    /// Takes all steps that are left.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn run(&mut self) -> Result<(), LearnError> {
        while self.step(|| ())?.is_some() {}
        Ok(())
    }

    /// Takes a step that was found before.
    ///
    /// # Errors
    /// [`LearnError::Step`] if no search of this kind could have found it here.
    pub fn redo(&mut self, step: &Step) -> Result<(), LearnError> {
        let number = self.steps + 1;
        let refuse =
            |reason: &str| Err(LearnError::Step { step: number, reason: reason.to_owned() });
        if !self.is_near(step.before)? {
            return refuse("the distance before it was another");
        }
        let redone = match (&mut self.strategy, &step.change) {
            (Strategy::Climb(climb), Move::Add(edge) | Move::Remove(edge)) => {
                let adds = matches!(step.change, Move::Add(_));
                let candidates = self.lessons.candidates();
                let candidate = candidates.binary_search(edge).ok();
                let moves: Vec<_> = climb.moves(self.settings.method).collect();
                let found = candidate.filter(|candidate| moves.contains(&(*candidate, adds)));
                self.evaluations += moves.len();
                found.map(|candidate| climb.toggle(candidate, candidates)).is_some()
            }
            (Strategy::Descent(descent), Move::Descend(state)) => {
                self.evaluations = state.evaluations;
                descent.resume(state).is_some()
            }
            _ => false,
        };
        if !redone {
            return refuse("the method takes no such step here");
        }
        self.set_factors()?;
        self.steps += 1;
        if self.is_near(step.distance)? {
            return Ok(());
        }
        refuse("it does not lead to its distance")
    }

    /// Whether the edges found so far are as near as a step says: two ways to solve one mesh agree
    /// far better than this, other recordings or parameters do not.
    fn is_near(&self, distance: f64) -> Result<bool, LearnError> {
        let here = self.lessons.distance()?;
        Ok((here - distance).abs() <= 1e-6 * here + 1e-9)
    }

    /// The edges found so far.
    ///
    /// # Errors
    /// [`LearnError::Edges`] if a factor is unusable.
    pub fn edges(&self) -> Result<LearnedEdges, LearnError> {
        self.lessons.learned(&self.strategy.factors(), self.phases())
    }
}

/// The edges that a predictor's demonstrations need: [`Lessons::of`] them, searched to the end.
///
/// - `groups`: one per demonstration; none learns from its own group.
/// - `ignored`: the robot's joints that do not count.
///
/// # Errors
/// [`LearnError`] if there is nothing to learn from, or a mesh cannot be solved.
/// # Panics
/// If there is not one group per demonstration.
pub fn learn(
    predictor: &Predictor,
    groups: &[String],
    ignored: &[JointId],
    settings: &LearnSettings,
) -> Result<LearnedEdges, LearnError> {
    let lessons = Lessons::of(predictor, groups, ignored, settings)?;
    let mut search = Search::new(lessons, settings.clone())?;
    search.run()?;
    search.edges()
}
