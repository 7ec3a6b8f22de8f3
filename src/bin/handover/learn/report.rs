//! What was learned, as text and as JSON.

use std::fmt::Write as _;
use std::path::Path;

use handover_mesh::learn::{Search, Step};
use handover_mesh::model::{Model, Training};
use serde_json::{Value, json};

use crate::output::counted;

/// A search that has ended.
pub(super) struct Report<'a> {
    pub(super) path: &'a Path,
    pub(super) model: &'a Model,
    pub(super) search: &'a Search,
    pub(super) steps: &'a [Step],
    /// The distance of the references held out, before the first step `[m]`.
    pub(super) held_out_initial: Option<f64>,
    pub(super) seconds: f64,
}

impl Report<'_> {
    fn records(&self) -> Vec<Value> {
        let (pair, people) = (self.model.pair(), self.model.people());
        self.steps.iter().map(|step| step.to_json(pair, people)).collect()
    }

    fn kernel(&self) -> Value {
        let values = self.model.config().values();
        values.into_iter().find(|(key, _)| key == "mesh.kernel").map_or(Value::Null, |(_, v)| v)
    }

    pub(super) fn text(&self) -> String {
        let Training { method, evaluations, initial_distance, final_distance, .. } =
            self.model.training();
        let evaluations = counted(*evaluations, "evaluation");
        let mut text = String::new();
        // Writing to a String cannot fail.
        if self.steps.is_empty() {
            text += "no step taken\n";
        } else {
            let _ = writeln!(text, "{:>4}  {:<8}{:<44}{:>12}", "step", "move", "edge", "distance");
            let _ = writeln!(text, "{:>4}  {:<8}{:<44}{:>12}", "", "", "", "m");
        }
        for (number, (step, record)) in self.steps.iter().zip(self.records()).enumerate() {
            let ends = record["edge"].as_array().into_iter().flatten().filter_map(Value::as_str);
            let edge = ends.collect::<Vec<_>>().join(" - ");
            let name = record["move"].as_str().unwrap_or("");
            let (number, distance) = (number + 1, step.distance);
            let _ = writeln!(text, "{number:>4}  {name:<8}{edge:<44}{distance:>12.4}");
        }
        let lessons = self.search.lessons();
        let _ = write!(text, "\n{:14}{:>12}{:>12}{:>12}\n", "", "references", "before", "after");
        let _ = writeln!(text, "{:14}{:>12}{:>12}{:>12}", "", "", "m", "m");
        let mut row = |name: &str, count: usize, before: Option<f64>, after: Option<f64>| {
            let metres = |value: Option<f64>| value.map_or("-".into(), |v| format!("{v:.4}"));
            let (before, after) = (metres(before), metres(after));
            let _ = writeln!(text, "{name:14}{count:>12}{before:>12}{after:>12}");
        };
        let held_out = self.model.training().held_out_distance;
        row(
            "learned from",
            lessons.lessons().len(),
            Some(*initial_distance),
            Some(*final_distance),
        );
        row("held out", lessons.held_out().len(), self.held_out_initial, held_out);
        let _ = write!(
            text,
            "\n{method}: {} of {}, {}, {:.1} s\n",
            counted(self.model.edges().edges().len(), "edge"),
            counted(lessons.candidates().len(), "candidate"),
            evaluations,
            self.seconds
        );
        text
    }

    pub(super) fn json(&self) -> Value {
        let Training { method, evaluations, initial_distance, final_distance, .. } =
            self.model.training();
        let (pair, people) = (self.model.pair(), self.model.people());
        let edges = self.model.edges().edges().iter().map(
            |learned| json!({ "edge": learned.edge.names(pair, people), "factors": learned.factors }),
        );
        let lessons = self.search.lessons();
        let (references, held_out) = super::references(lessons);
        json!({
            "method": method,
            "candidates": lessons.candidates().len(),
            "evaluations": evaluations,
            "seconds": self.seconds,
            "initial": initial_distance,
            "final": final_distance,
            "steps": self.records(),
            "held_out": self.model.training().held_out_distance,
            "held_out_initial": self.held_out_initial,
            "role": people[self.model.robot_role() as usize],
            "kernel": self.kernel(),
            "demonstrations": self.model.demonstrations().len(),
            "references": references,
            "held_out_references": held_out,
            "edges": edges.collect::<Vec<_>>(),
            "model": self.path.display().to_string(),
        })
    }
}
