//! A search for edges, one step after another.

use super::climb::Climb;
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

/// A search under way: every step depends on the one before it alone, so that a search that was
/// broken off goes on as if it had not been once its steps are redone.
#[derive(Debug, Clone)]
pub struct Search {
    pub(super) lessons: Lessons,
    pub(super) settings: LearnSettings,
    climb: Climb,
    initial: f64,
    evaluations: usize,
    steps: usize,
    finished: bool,
}

impl Search {
    /// Stands at the method's start.
    ///
    /// # Errors
    /// [`LearnError`] if the start cannot be solved.
    pub fn new(mut lessons: Lessons, settings: LearnSettings) -> Result<Self, LearnError> {
        let climb = Climb::start(settings.method, &lessons);
        lessons.set_factors(&climb.factors(), 1)?;
        let initial = lessons.distance()?;
        let finished = settings.method == LearnMethod::None;
        Ok(Self { lessons, settings, climb, initial, evaluations: 1, steps: 0, finished })
    }

    /// The distance `[m]` at the start.
    pub fn initial(&self) -> f64 {
        self.initial
    }

    /// How many sets of edges have been measured, over all references each.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// How many the next step will measure.
    pub fn next_evaluations(&self) -> usize {
        self.climb.moves(self.settings.method).count()
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
        if self.finished || self.steps >= self.settings.steps {
            return Ok(None);
        }
        let before = self.lessons.distance()?;
        let found = self.climb.best(self.settings.method, &self.lessons, measured)?;
        self.evaluations += self.next_evaluations();
        let better = before - self.settings.tolerance * before;
        let Some((candidate, distance)) = found.filter(|(_, distance)| *distance < better) else {
            self.finished = true;
            return Ok(None);
        };
        let change = self.toggle(candidate)?;
        Ok(Some(Step { change, before, distance }))
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
        let refuse = |reason: &str| {
            Err(LearnError::Step { step: self.steps + 1, reason: reason.to_owned() })
        };
        if !self.is_near(step.before)? {
            return refuse("the distance before it was another");
        }
        let (Move::Add(edge) | Move::Remove(edge)) = step.change;
        let Ok(candidate) = self.lessons.candidates().binary_search(&edge) else {
            return refuse("its edge joins no two joints of these people");
        };
        let adds = matches!(step.change, Move::Add(_));
        if adds == self.climb.is_on(candidate) {
            return refuse("its edge is already so");
        }
        if !self
            .climb
            .moves(self.settings.method)
            .any(|(other, on)| (other, on) == (candidate, adds))
        {
            return refuse("the method takes no such step");
        }
        self.evaluations += self.next_evaluations();
        self.toggle(candidate)?;
        if self.is_near(step.distance)? {
            return Ok(());
        }
        let reason = "it does not lead to its distance".to_owned();
        Err(LearnError::Step { step: self.steps, reason })
    }

    /// Whether the edges found so far are as near as a step says: two ways to solve one mesh agree
    /// far better than this, other recordings or parameters do not.
    fn is_near(&self, distance: f64) -> Result<bool, LearnError> {
        let here = self.lessons.distance()?;
        Ok((here - distance).abs() <= 1e-6 * here + 1e-9)
    }

    fn toggle(&mut self, candidate: usize) -> Result<Move, LearnError> {
        let on = self.climb.toggle(candidate);
        self.lessons.set_factors(&self.climb.factors(), 1)?;
        self.steps += 1;
        let edge = self.lessons.candidates()[candidate];
        Ok(if on { Move::Add(edge) } else { Move::Remove(edge) })
    }

    /// The edges found so far.
    ///
    /// # Errors
    /// [`LearnError::Edges`] if a factor is unusable.
    pub fn edges(&self) -> Result<LearnedEdges, LearnError> {
        self.lessons.learned(&self.climb.factors(), 1)
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
