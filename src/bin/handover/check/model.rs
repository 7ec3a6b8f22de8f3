//! Model files: what they were learned from and how, or why they are none.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use handover_mesh::Role;
use handover_mesh::config::Change;
use handover_mesh::mesh::Kernel;
use handover_mesh::model::Model;
use handover_mesh::predict::LearnedEdge;
use serde_json::{Value, json};

use super::{bad_text, bad_value, duration};
use crate::files::{self, Fault};
use crate::output::counted;

/// Enough of a hash to tell files apart by eye.
const SHORT_HASH: usize = 12;

/// A model file and what came of reading it.
pub(super) struct ModelFile {
    path: PathBuf,
    pub(super) outcome: Result<Box<Model>, Vec<Fault>>,
}

impl ModelFile {
    /// # Errors
    /// If there is no such file; a bad one is no error.
    pub(super) fn read(path: PathBuf) -> anyhow::Result<Self> {
        files::about(&path)?;
        let outcome = files::read_model(&path).map(Box::new);
        Ok(Self { path, outcome })
    }

    pub(super) fn text(&self) -> String {
        match &self.outcome {
            Ok(model) => format!("{}: {}", self.path.display(), text(model)),
            Err(faults) => bad_text(&self.path, faults),
        }
    }

    pub(super) fn json(&self) -> Value {
        match &self.outcome {
            Ok(model) => value(&self.path, model),
            Err(faults) => bad_value(&self.path, faults),
        }
    }
}

fn robot(model: &Model) -> &str {
    model.people()[model.robot_role() as usize]
}

/// What is not as by default.
fn changes(model: &Model) -> Vec<Change> {
    // A model's parameters are within their bounds: it was checked.
    model.config().differences().unwrap_or_default()
}

/// `giver/right_hand`, twice.
fn names(model: &Model, learned: &LearnedEdge) -> [String; 2] {
    learned.edge.names(model.pair(), model.people())
}

fn hands(model: &Model) -> [String; 2] {
    let hands = model.edges().hands();
    [hands.robot, hands.partner].map(|side| format!("{side:?}").to_lowercase())
}

fn kernel(model: &Model) -> String {
    match model.config().predict.kernel {
        Kernel::Uniform => "uniform".to_owned(),
        Kernel::InverseDistance { scale, power, reference, minimum } => {
            format!("{scale} * ({reference} m / max(distance, {minimum} m))^{power}")
        }
    }
}

fn text(model: &Model) -> String {
    let (edges, training) = (model.edges(), model.training());
    let [robot_hand, partner_hand] = hands(model);
    let mut lines = vec![format!(
        "model, the robot is {}, base {}; format {}, written by handover_mesh {}",
        robot(model),
        model.base_joint(),
        model.format_version(),
        model.program_version()
    )];
    for (role, name) in [Role::First, Role::Second].into_iter().zip(model.people()) {
        let names = model.pair().skeleton(role).names();
        lines.push(format!("  {name}: {} joints: {}", names.len(), names.join(" ")));
    }
    for (demonstration, hash) in model.demonstrations().iter().zip(model.hashes()) {
        let recording = demonstration.recording();
        let (frames, seconds) = (counted(recording.len(), "frame"), duration(recording));
        let (name, hash) = (recording.name(), &hash[..SHORT_HASH]);
        lines.push(format!("  {name}: {frames}, {seconds:.2} s, sha256 {hash}"));
    }
    lines.push(format!(
        "  {} between the people, factors of {}, named for the robot's {robot_hand} \
         and the partner's {partner_hand} hand",
        counted(edges.edges().len(), "edge"),
        counted(edges.phases(), "phase")
    ));
    for learned in edges.edges() {
        let factors: Vec<_> = learned.factors.iter().map(|factor| format!("{factor:.3}")).collect();
        lines.push(format!("    {}: {}", names(model, learned).join(" - "), factors.join(" ")));
    }
    lines.push(format!("  kernel {}", kernel(model)));
    let mut learned = format!(
        "  learned by {}: {}, {}, distance {:.4} m -> {:.4} m",
        training.method,
        counted(training.steps, "step"),
        counted(training.evaluations, "evaluation"),
        training.initial_distance,
        training.final_distance
    );
    if let Some(distance) = training.held_out_distance {
        // Writing to a String cannot fail.
        let _ = write!(learned, ", held out {distance:.4} m");
    }
    lines.push(learned);
    for Change { key, value, default } in changes(model) {
        lines.push(format!("  {key} is {value}, by default {default}"));
    }
    lines.join("\n") + "\n"
}

fn value(path: &Path, model: &Model) -> Value {
    let (edges, training) = (model.edges(), model.training());
    let people = [Role::First, Role::Second]
        .into_iter()
        .zip(model.people())
        .map(|(role, name)| json!({ "name": name, "joints": model.pair().skeleton(role).names() }));
    let demonstrations = model.demonstrations().iter().zip(model.hashes());
    let demonstrations = demonstrations.map(|(demonstration, hash)| {
        let recording = demonstration.recording();
        json!({
            "name": recording.name(),
            "frames": recording.len(),
            "duration_s": duration(recording),
            "metadata": recording.metadata(),
            "sha256": hash,
        })
    });
    let learned = edges.edges().iter();
    let learned =
        learned.map(|edge| json!({ "edge": names(model, edge), "factors": edge.factors }));
    let [robot_hand, partner_hand] = hands(model);
    let changes = changes(model).into_iter();
    let changes = changes.map(|c| json!({ "key": c.key, "value": c.value, "default": c.default }));
    let config: serde_json::Map<String, Value> = model.config().values().into_iter().collect();
    json!({
        "file": path.display().to_string(),
        "good": true,
        "errors": [],
        "format": "model",
        "format_version": model.format_version(),
        "program_version": model.program_version(),
        "role": robot(model),
        "base_joint": model.base_joint(),
        "people": people.collect::<Vec<_>>(),
        "demonstrations": demonstrations.collect::<Vec<_>>(),
        "hands": { "robot": robot_hand, "partner": partner_hand },
        "phases": edges.phases(),
        "edges": learned.collect::<Vec<_>>(),
        "training": {
            "method": training.method,
            "steps": training.steps,
            "evaluations": training.evaluations,
            "initial_distance_m": training.initial_distance,
            "final_distance_m": training.final_distance,
            "held_out_distance_m": training.held_out_distance,
        },
        "changes": changes.collect::<Vec<_>>(),
        "config": config,
    })
}
