//! The text that stands beside the tensors: the metadata `model`, as JSON.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::value::RawValue;
use serde_json::{Map, Value, json};

use super::{Model, Training};
use crate::demonstration::Hands;
use crate::skeleton::{Role, Side};

/// What is read; [`Model::contents`] is what is written. Both are one version of the format: what
/// one of them gains, the other has to gain, and `FORMAT_VERSION` grows.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Contents {
    pub(super) role: String,
    hands: HandsText,
    pub(super) people: [PersonText; 2],
    pub(super) demonstrations: Vec<DemonstrationText>,
    pub(super) edges: usize,
    pub(super) phases: usize,
    pub(super) training: TrainingText,
    /// Read when its length has been seen: values cost many times their text.
    pub(super) config: Box<RawValue>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HandsText {
    robot: SideText,
    partner: SideText,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum SideText {
    Left,
    Right,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PersonText {
    pub(super) name: String,
    pub(super) joints: Vec<String>,
    pub(super) bones: Vec<[usize; 2]>,
    /// How many of the joints, the last ones, ride on others; since version 2.
    #[serde(default)]
    pub(super) attached: usize,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DemonstrationText {
    pub(super) name: String,
    pub(super) frames: usize,
    pub(super) metadata: BTreeMap<String, String>,
    pub(super) sha256: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TrainingText {
    method: String,
    steps: usize,
    evaluations: usize,
    initial_distance: f64,
    final_distance: f64,
    held_out_distance: Option<f64>,
}

impl Contents {
    pub(super) fn hands(&self) -> Hands {
        let side = |text| match text {
            SideText::Left => Side::Left,
            SideText::Right => Side::Right,
        };
        Hands { robot: side(self.hands.robot), partner: side(self.hands.partner) }
    }
}

impl From<TrainingText> for Training {
    fn from(text: TrainingText) -> Self {
        let TrainingText { method, steps, evaluations, .. } = text;
        let TrainingText { initial_distance, final_distance, held_out_distance, .. } = text;
        Self { method, steps, evaluations, initial_distance, final_distance, held_out_distance }
    }
}

/// `left` or `right`.
impl Model {
    /// The parameters, all of them, as a JSON object of dotted keys.
    pub(super) fn config_json(&self) -> String {
        Value::Object(self.config_map()).to_string()
    }

    fn config_map(&self) -> Map<String, Value> {
        let sorted: BTreeMap<String, Value> = self.config().values().into_iter().collect();
        sorted.into_iter().collect()
    }

    /// The text beside the tensors; every object's keys sorted.
    pub(super) fn contents(&self) -> String {
        let hands = self.edges().hands();
        let people = [Role::First, Role::Second].map(|role| {
            let skeleton = self.pair().skeleton(role);
            let bones: Vec<[usize; 2]> =
                skeleton.bones().map(|bone| [bone.parent, bone.child].map(|j| j.index())).collect();
            let name = self.people()[role as usize];
            let mut person = json!({ "bones": bones, "joints": skeleton.names(), "name": name });
            if skeleton.attached().len() > 0 {
                person["attached"] = skeleton.attached().len().into();
            }
            person
        });
        let demonstrations = self.demonstrations().iter().zip(self.hashes());
        let demonstrations = demonstrations.map(|(demonstration, sha256)| {
            let recording = demonstration.recording();
            json!({
                "frames": recording.len(),
                "metadata": recording.metadata(),
                "name": recording.name(),
                "sha256": sha256,
            })
        });
        let training = self.training();
        let contents = json!({
            "config": self.config_map(),
            "demonstrations": demonstrations.collect::<Vec<_>>(),
            "edges": self.edges().edges().len(),
            "hands": { "partner": hands.partner.name(), "robot": hands.robot.name() },
            "people": people,
            "phases": self.edges().phases(),
            "role": self.people()[self.robot_role() as usize],
            "training": {
                "evaluations": training.evaluations,
                "final_distance": training.final_distance,
                "held_out_distance": training.held_out_distance,
                "initial_distance": training.initial_distance,
                "method": training.method,
                "steps": training.steps,
            },
        });
        contents.to_string()
    }
}
