//! A trial's figures beside their bounds.

use std::collections::BTreeMap;

use handover_mesh::safety::HoldReason;
use serde_json::{Map, Value, json};

use super::measure::measure;
use super::{Controller, LearnError, Learnt, Stage, StageError, Trace, play};
use crate::scenario::{Figure, Scenario, Verdict};

/// What came of a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The scenario's name.
    pub name: String,
    /// What happens in it.
    pub about: String,
    /// How many ticks it took.
    pub ticks: usize,
    /// Every figure; `None`: undefined here.
    pub figures: BTreeMap<Figure, Option<f64>>,
    /// In how many ticks there was each reason to hold.
    pub holds: BTreeMap<HoldReason, usize>,
    /// The scenario's bounds, and whether they held.
    pub verdicts: Vec<Verdict>,
}

/// Why a trial could not be played.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The scenario cannot be laid out.
    #[error(transparent)]
    Stage(#[from] StageError),
    /// There is no tick for its robot.
    #[error(transparent)]
    Learn(#[from] LearnError),
}

impl Outcome {
    /// Plays a scenario with the product's tick.
    ///
    /// # Errors
    /// [`RunError`]; a scenario that was read and checked gives none.
    pub fn run(scenario: &Scenario, learnt: &Learnt) -> Result<Self, RunError> {
        let stage = Stage::new(scenario)?;
        let mut pipeline = learnt.pipeline(&stage)?;
        Ok(Self::with(scenario, learnt, &stage, &mut pipeline))
    }

    /// Plays a scenario, laid out before, with any controller.
    pub fn with(
        scenario: &Scenario,
        learnt: &Learnt,
        stage: &Stage,
        controller: &mut impl Controller,
    ) -> Self {
        let trace = play(scenario, stage, controller);
        Self::of(scenario, learnt, stage, &trace)
    }

    /// Measures a trial that was played.
    pub fn of(scenario: &Scenario, learnt: &Learnt, stage: &Stage, trace: &Trace) -> Self {
        let found = measure(stage, trace, learnt);
        let figures: BTreeMap<_, _> =
            Figure::ALL.into_iter().map(|figure| (figure, found(figure))).collect();
        let holds = trace.holds();
        let verdicts = scenario.bounds.judge(|figure| figures[&figure], &holds);
        Self {
            name: scenario.name.clone(),
            about: scenario.about.clone(),
            ticks: trace.steps.len(),
            figures,
            holds,
            verdicts,
        }
    }

    /// Whether every bound held.
    pub fn is_held(&self) -> bool {
        self.verdicts.iter().all(|verdict| verdict.is_held)
    }

    /// `{"name","about","ticks","figures":{FIGURE},"holds":{REASON:ticks},"bounds":[{"key","bound",
    /// "value","held"}],"held"}`; undefined figures are null.
    pub fn to_json(&self) -> Value {
        let figures: Map<String, Value> =
            self.figures.iter().map(|(figure, v)| (figure.key().to_owned(), json!(v))).collect();
        let holds: Map<String, Value> =
            self.holds.iter().map(|(reason, n)| (reason.name().to_owned(), json!(n))).collect();
        let bounds: Vec<Value> = self
            .verdicts
            .iter()
            .map(|v| json!({"key": v.key, "bound": v.bound, "value": v.value, "held": v.is_held}))
            .collect();
        json!({
            "name": self.name,
            "about": self.about,
            "ticks": self.ticks,
            "figures": figures,
            "holds": holds,
            "bounds": bounds,
            "held": self.is_held(),
        })
    }
}
