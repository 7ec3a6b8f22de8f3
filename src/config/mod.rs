//! Parameters: one YAML file in ROS 2 form → checked settings, or every violation at once.
//!
//! ```yaml
//! /**:
//!   ros__parameters:
//!     retarget: {transform: none, steps: 5}
//! ```
//!
//! A key left out keeps its default; `config/handover.yaml` lists all keys with meaning, unit and
//! range. Text in, values out: opens no file.

mod describe;
mod fields;
pub mod given;
mod node;
mod online;

use std::collections::BTreeMap;

use serde_json::Value;

use crate::forecast::ForecastSettings;
use crate::learn::{LearnMethod, LearnSettings};
use crate::mesh::Kernel;
use crate::motion::{Dimensions, MotionSettings};
use crate::online::OnlineSettings;
use crate::predict::{KnownJoints, PredictSettings, ReferenceBlend};
use crate::retarget::Transform;
use crate::skeleton::Skeleton;
pub use describe::{Kind, Parameter};
use fields::Fields;
pub use node::{NodeSettings, RobotState, Source};

/// Whether what is handed over is part of the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ObjectSettings {
    /// Whether the object's points ride on the carrier's hand as further joints: see
    /// [`with_object_carried`](crate::demonstration::with_object_carried).
    pub attach: bool,
    /// How many points an object may have.
    pub points: usize,
}

impl Default for ObjectSettings {
    fn default() -> Self {
        Self { attach: false, points: 16 }
    }
}

/// All parameters, within their bounds.
///
/// ```
/// use handover_mesh::Config;
/// let yaml = "/**:\n  ros__parameters:\n    retarget: {steps: 0, speed: 3}\n";
/// let error = Config::from_yaml(yaml, &[]).unwrap_err().to_string();
/// assert!(error.contains("retarget.steps is 0, must be a whole number from 1 to 10000"));
/// assert!(error.contains("retarget.speed"), "both are reported");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// The joint by which a person's place is known, by name; a skeleton without it uses its root.
    pub base_joint: String,
    /// Whether the object, and how much of it, is part of the mesh.
    pub object: ObjectSettings,
    /// How demonstrations become predictions.
    pub predict: PredictSettings,
    /// How edges are learned.
    pub learn: LearnSettings,
    /// Where in the demonstrations a pose is, and what comes next.
    pub motion: MotionSettings,
    /// How the partner is forecast.
    pub forecast: ForecastSettings,
    /// How the online tick is done.
    pub online: OnlineSettings,
    /// Folds of an evaluation with more than twenty groups.
    pub folds: usize,
    /// Joints of the robot, by name, that no figure counts.
    pub ignored_joints: Vec<String>,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            base_joint: "torso".to_owned(),
            object: ObjectSettings::default(),
            predict: PredictSettings::default(),
            learn: LearnSettings::default(),
            motion: MotionSettings::default(),
            forecast: ForecastSettings::default(),
            online: OnlineSettings::default(),
            folds: 10,
            ignored_joints: Vec::new(),
        }
    }
}

/// One parameter that is not what it is by default.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The key, dotted.
    pub key: String,
    /// What it is.
    pub value: Value,
    /// What it would be.
    pub default: Value,
}

/// One parameter that cannot be meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// The key, dotted.
    pub key: String,
    /// What is wrong: the value and the bound.
    pub problem: String,
}

/// Everything that is wrong with some parameters.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ConfigError {
    /// The text is no YAML.
    #[error("not YAML: {0}")]
    Yaml(String),
    /// The text is not in ROS 2 parameter form.
    #[error("parameters stand under '/**:' and 'ros__parameters:' there; {0}")]
    Form(String),
    /// Keys, types or values, all of them.
    #[error("{}", lines(.0))]
    Violations(Vec<Violation>),
}

fn lines(violations: &[Violation]) -> String {
    let lines = violations.iter().map(|v| format!("{} {}", v.key, v.problem));
    lines.collect::<Vec<_>>().join("\n")
}

impl Config {
    /// Reads a parameter file's text, then `key=value` settings over it.
    ///
    /// - `yaml`: in ROS 2 parameter form; empty for the defaults.
    /// - `settings`: dotted keys and YAML values, later ones win.
    ///
    /// # Errors
    /// [`ConfigError`] with every unknown key, wrong type and value out of range.
    pub fn from_yaml(yaml: &str, settings: &[(String, String)]) -> Result<Self, ConfigError> {
        Self::default().with(yaml, settings).map(|(config, _)| config)
    }

    /// What a parameter file's text changes, in the order of `config/handover.yaml`.
    ///
    /// # Errors
    /// As [`Config::from_yaml`].
    pub fn changes(yaml: &str) -> Result<Vec<Change>, ConfigError> {
        Self::default().with(yaml, &[]).map(|(_, changes)| changes)
    }

    /// The same with a parameter file's text and `key=value` settings over it, and what they
    /// change: a [`Change::default`] is what this has.
    ///
    /// ```
    /// use handover_mesh::Config;
    /// let model = Config { folds: 3, ..Config::default() };
    /// let slower = [("safety.speed".to_owned(), "0.5".to_owned())];
    /// let (config, changes) = model.with("", &slower)?;
    /// assert_eq!((config.folds, config.online.safety.speed), (3, 0.5));
    /// assert_eq!((changes.len(), changes[0].key.as_str()), (1, "safety.speed"));
    /// # Ok::<(), handover_mesh::ConfigError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Config::from_yaml`].
    pub fn with(
        &self,
        yaml: &str,
        settings: &[(String, String)],
    ) -> Result<(Self, Vec<Change>), ConfigError> {
        let mut values = BTreeMap::new();
        if !yaml.trim().is_empty() {
            let file: Value = parse_yaml(yaml).map_err(ConfigError::Yaml)?;
            flatten("", parameters(&file)?, &mut values);
        }
        let mut violations = Vec::new();
        for (key, text) in settings {
            match parse_yaml(text) {
                Ok(value) => flatten(key, &value, &mut values),
                Err(error) => violations.push(Violation {
                    key: key.clone(),
                    problem: format!("is no YAML value: {error}"),
                }),
            }
        }
        self.checked(&NodeSettings::default(), values, violations)
            .map(|(config, _, changes)| (config, changes))
    }

    /// The same with values by their dotted keys over it, the node's among them, and what they
    /// change.
    ///
    /// # Errors
    /// [`ConfigError::Violations`] with every unknown key, wrong type and value out of range.
    pub fn with_values(
        &self,
        node: &NodeSettings,
        values: impl IntoIterator<Item = (String, Value)>,
    ) -> Result<(Self, NodeSettings, Vec<Change>), ConfigError> {
        self.checked(node, values.into_iter().collect(), Vec::new())
    }

    /// Every parameter there is, those of the node among them.
    pub fn parameters(&self, node: &NodeSettings) -> Vec<Parameter> {
        let mut fields = Fields::new(BTreeMap::new(), Vec::new());
        Self::from_fields(&mut fields, self.clone());
        node::take(&mut fields, &mut node.clone());
        let mut descriptions = describe::descriptions();
        let parameter = |(key, kind, value): (&str, Kind, Value)| Parameter {
            key: key.to_owned(),
            kind,
            value,
            description: descriptions.remove(key).unwrap_or_default(),
        };
        fields.asked().map(parameter).collect()
    }

    /// Whether a parameter belongs to the robot and its sensor as much as to a model: what was
    /// learned with another value of it holds all the same.
    pub fn is_of_the_robot(key: &str) -> bool {
        let section = key.split('.').next().unwrap_or_default();
        Self::OF_THE_ROBOT.contains(&section)
    }

    /// The sections of these parameters.
    pub const OF_THE_ROBOT: [&str; 5] = ["tick", "filter", "track", "window", "safety"];

    /// Every key with its value, dotted, in the order of `config/handover.yaml`.
    ///
    /// [`Self::from_values`] makes the same settings of them, if these are within their bounds.
    ///
    /// ```
    /// use handover_mesh::Config;
    /// let config = Config { folds: 3, ..Config::default() };
    /// assert!(config.values().contains(&("evaluate.folds".to_owned(), 3.into())));
    /// assert_eq!(Config::from_values(config.values()), Ok(config));
    /// ```
    pub fn values(&self) -> Vec<(String, Value)> {
        let mut fields = Fields::new(BTreeMap::new(), Vec::new());
        Self::from_fields(&mut fields, self.clone());
        fields.before()
    }

    /// Settings from dotted keys and values; a key left out keeps its default.
    ///
    /// # Errors
    /// [`ConfigError::Violations`] with every unknown key, wrong type and value out of range.
    pub fn from_values(
        values: impl IntoIterator<Item = (String, Value)>,
    ) -> Result<Self, ConfigError> {
        Self::default().with_values(&NodeSettings::default(), values).map(|(config, ..)| config)
    }

    /// What is not as by default, in the order of `config/handover.yaml`.
    ///
    /// # Errors
    /// As [`Self::from_values`], if a setting is out of its bounds.
    pub fn differences(&self) -> Result<Vec<Change>, ConfigError> {
        Self::default()
            .with_values(&NodeSettings::default(), self.values())
            .map(|(_, _, changes)| changes)
    }

    fn checked(
        &self,
        node: &NodeSettings,
        values: BTreeMap<String, Value>,
        violations: Vec<Violation>,
    ) -> Result<(Self, NodeSettings, Vec<Change>), ConfigError> {
        let mut fields = Fields::new(values, violations);
        let config = Self::from_fields(&mut fields, self.clone());
        let mut node = node.clone();
        node::take(&mut fields, &mut node);
        let changes = fields.finish().map_err(ConfigError::Violations)?;
        Ok((config, node, changes))
    }

    /// Every key but the node's, with its bounds: the one place that knows them.
    ///
    /// - `config`: what a key left out stays as.
    fn from_fields(fields: &mut Fields, mut config: Self) -> Self {
        let Self {
            base_joint,
            object,
            predict,
            learn,
            motion,
            forecast,
            online,
            folds,
            ignored_joints,
        } = &mut config;
        fields.text("robot.base_joint", base_joint);
        fields.flag("object.attach", &mut object.attach);
        fields.count("object.points", &mut object.points, 1, Skeleton::MAX_JOINTS);
        fields.float("observation.smoothing", &mut predict.smoothing, 0.0, 1.0);
        fields.float("alignment.pause_penalty", &mut predict.warp.pause_penalty, 0.0, 10.0);
        fields.float("alignment.slack", &mut predict.warp.slack, 0.0, 0.45);
        fields.float("alignment.distance_weight", &mut predict.distance_weight, 0.0, 100.0);
        fields.count("reference.demonstrations", &mut predict.demonstrations, 1, 1000);
        let blends = [("mean", ReferenceBlend::Mean), ("rigid", ReferenceBlend::Rigid)];
        fields.choice("reference.blend", &mut predict.blend, &blends);
        fields.float("reference.contact_fade", &mut predict.contact_fade, 0.001, 60.0);
        fields.float("mesh.time_weight", &mut predict.time_weight, 0.0, 1000.0);
        predict.kernel = kernel(fields, predict.kernel);
        let retarget = &mut predict.retarget;
        let transforms = [
            ("none", Transform::None),
            ("implicit", Transform::Implicit),
            ("local_global", Transform::LocalGlobal),
        ];
        fields.choice("retarget.transform", &mut retarget.transform, &transforms);
        let known = [("eliminated", KnownJoints::Eliminated), ("soft", KnownJoints::Soft)];
        fields.choice("retarget.known", &mut predict.known, &known);
        fields.float("retarget.laplacian_weight", &mut retarget.laplacian_weight, 1e-6, 1e6);
        fields.float("retarget.known_weight", &mut retarget.known_weight, 1e-6, 1e6);
        fields.float("retarget.bone_weight", &mut retarget.bone_weight, 0.0, 1e6);
        fields.count("retarget.steps", &mut retarget.steps, 1, 10_000);
        fields.float("retarget.tolerance", &mut retarget.tolerance, 0.0, 1.0);
        fields.float("retarget.rotation_memory", &mut retarget.rotation_memory, 1e-9, 1.0);
        let methods = LearnMethod::ALL.map(|method| (method.name(), method));
        fields.choice("learn.method", &mut learn.method, &methods);
        fields.count("learn.references", &mut learn.references, 1, 1000);
        fields.float("learn.tolerance", &mut learn.tolerance, 0.0, 1.0);
        fields.count("learn.steps", &mut learn.steps, 1, 10_000);
        fields.float("learn.hand_weight", &mut learn.hand_weight, 1e-3, 1e3);
        fields.float("learn.contact_weight", &mut learn.contact_weight, 0.0, 1e3);
        fields.float("learn.contact_fade", &mut learn.contact_fade, 0.001, 60.0);
        fields.count("learn.phases", &mut learn.phases, 1, 100);
        fields.float("learn.sparsity", &mut learn.sparsity, 0.0, 1e3);
        fields.float("learn.threshold", &mut learn.threshold, 0.0, 1.0);
        dimensions(fields, &mut motion.dimensions);
        fields.count("motion.neighbours", &mut motion.k, 1, 1000);
        fields.float("forecast.velocity_window", &mut forecast.velocity_window, 0.001, 10.0);
        fields.float("forecast.velocity_weight", &mut forecast.velocity_weight, 1e-3, 1e3);
        fields.float("forecast.smoothing", &mut forecast.smoothing, 0.0, 1.0);
        fields.float("forecast.ridge_penalty", &mut forecast.ridge_penalty, 1e-9, 1e6);
        fields.count("forecast.dimensions", &mut forecast.dimensions, 1, 1000);
        fields.count("forecast.simplex_dimensions", &mut forecast.simplex_dimensions, 2, 4);
        fields.count("forecast.neighbours", &mut forecast.neighbours, 1, 1000);
        fields.count("forecast.averaged", &mut forecast.averaged, 1, 1000);
        fields.float("forecast.joint_damping", &mut forecast.joint_damping, 1e-3, 1e3);
        fields.float("forecast.root_damping", &mut forecast.root_damping, 1e-3, 1e3);
        // The tick forecasts as evaluations do.
        online.forecast.clone_from(forecast);
        online::take(fields, online);
        fields.float("baseline.ridge_penalty", &mut predict.ridge_penalty, 1e-9, 1e6);
        fields.count("baseline.promp_bases", &mut predict.promp_bases, 2, 200);
        fields.float("baseline.promp_noise", &mut predict.promp_noise, 1e-6, 1e3);
        fields.float("baseline.attach_fade", &mut predict.attach_fade, 0.01, 60.0);
        fields.count("evaluate.folds", folds, 2, 1000);
        fields.texts("evaluate.ignored_joints", ignored_joints);
        config
    }
}

/// A number of latent dimensions; a share of the variance is nothing that a file holds.
fn dimensions(fields: &mut Fields, dimensions: &mut Dimensions) {
    let mut count = match *dimensions {
        Dimensions::Count(count) => count,
        Dimensions::Share(_) => 2,
    };
    fields.count("motion.dimensions", &mut count, 1, 1000);
    *dimensions = Dimensions::Count(count);
}

/// The kernel is a choice, and its numbers belong to one of the choices.
fn kernel(fields: &mut Fields, before: Kernel) -> Kernel {
    let numbers = |kernel| match kernel {
        Kernel::InverseDistance { scale, power, reference, minimum } => {
            Some((scale, power, reference, minimum))
        }
        Kernel::Uniform => None,
    };
    // Of a uniform kernel the numbers mean nothing, and so are as by default.
    let (mut scale, mut power, mut reference, mut minimum) = numbers(before)
        .or_else(|| numbers(PredictSettings::default().kernel))
        .unwrap_or((3.0, 2.0, 0.1, 0.05));
    let mut inverse_distance = before != Kernel::Uniform;
    let choices = [("uniform", false), ("inverse_distance", true)];
    fields.choice("mesh.kernel", &mut inverse_distance, &choices);
    fields.float("mesh.scale", &mut scale, 0.0, 1e6);
    fields.float("mesh.power", &mut power, 0.0, 16.0);
    fields.float("mesh.reference_distance", &mut reference, 1e-3, 10.0);
    fields.float("mesh.minimum_distance", &mut minimum, 1e-3, 10.0);
    if inverse_distance {
        Kernel::InverseDistance { scale, power, reference, minimum }
    } else {
        Kernel::Uniform
    }
}

fn parse_yaml(text: &str) -> Result<Value, String> {
    serde_saphyr::from_str(text).map_err(|error| error.to_string())
}

/// What stands under `/**` and `ros__parameters`.
fn parameters(file: &Value) -> Result<&Value, ConfigError> {
    let only = |value: &'_ Value, key: &str| match value {
        Value::Object(map) if map.len() == 1 && map.contains_key(key) => Ok(()),
        Value::Object(map) => Err(ConfigError::Form(format!(
            "got {}",
            map.keys().cloned().collect::<Vec<_>>().join(", ")
        ))),
        other => Err(ConfigError::Form(format!("got {other}"))),
    };
    only(file, "/**")?;
    only(&file["/**"], "ros__parameters")?;
    Ok(&file["/**"]["ros__parameters"])
}

/// Nested maps → dotted keys.
fn flatten(prefix: &str, value: &Value, values: &mut BTreeMap<String, Value>) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                let key = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
                flatten(&key, value, values);
            }
        }
        // A section whose keys are all commented out.
        Value::Null => {}
        value => {
            values.insert(prefix.to_owned(), value.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_rejected(setting: (&str, &str), expected: &str) {
        let setting = (setting.0.to_owned(), setting.1.to_owned());
        let error = Config::from_yaml("", &[setting]).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }

    #[test]
    fn every_kind_of_mistake_is_named_with_its_bound() {
        check_rejected(
            ("retarget.transform", "shear"),
            "is \"shear\", must be one of none, implicit, local_global",
        );
        check_rejected(
            ("alignment.slack", "0.5"),
            "alignment.slack is 0.5, must be a number from 0 to 0.45",
        );
        check_rejected(("retarget.steps", "2.5"), "is 2.5, must be a whole number");
        check_rejected(("retarget.steps", "[1]"), "is [1], must be a whole number");
        check_rejected(("robot.base_joint", "7"), "is 7, must be text");
        check_rejected(("evaluate.ignored_joints", "head"), "must be a list of texts");
        check_rejected(
            ("mesh.colour", "1"),
            "mesh.colour is no parameter; 'mesh' has time_weight, kernel",
        );
        check_rejected(("mesh", "1"), "mesh is no parameter");
    }

    #[test]
    fn all_violations_come_together_and_settings_win_over_the_file() {
        let yaml = "/**:\n  ros__parameters:\n    retarget: {steps: 7}\n    mesh: {scale: -1, kernel: 3}\n";
        let error = Config::from_yaml(yaml, &[("retarget.bone_weight".into(), "-2".into())]);
        let Err(ConfigError::Violations(violations)) = error else { panic!("{error:?}") };
        let keys: Vec<&str> = violations.iter().map(|v| v.key.as_str()).collect();
        assert_eq!(keys, ["mesh.kernel", "mesh.scale", "retarget.bone_weight"]);
        let settings =
            [("mesh.scale".into(), "2".into()), ("mesh.kernel".into(), "uniform".into())];
        let config = Config::from_yaml(yaml, &settings).unwrap();
        assert_eq!((config.predict.retarget.steps, config.predict.kernel), (7, Kernel::Uniform));
    }

    /// The first value that a key takes and that changes something.
    fn off_default(key: &str, default: &Value) -> Config {
        let numbers = default.as_f64().map(|n| [n / 2.0, n + 0.1]).into_iter().flatten();
        let whole = default.as_u64().map(|n| n + 1).map(Value::from);
        let words = ["uniform", "implicit", "soft", "neck", "grow", "none", "knn", "rigid"]
            .map(Value::from);
        let space = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let others = [true.into(), false.into(), vec!["head"].into(), Value::from(space)];
        let candidates = numbers
            .map(Value::from)
            .chain(whole)
            .chain(words)
            .chain(others)
            .filter(|v| v != default);
        let mut configs = candidates.filter_map(|v| Config::from_values([(key.into(), v)]).ok());
        configs.find(|config| *config != Config::default()).unwrap_or_else(|| panic!("{key}"))
    }

    #[test]
    fn what_is_written_reads_back_for_every_key() {
        assert_eq!(Config::from_values(Config::default().values()), Ok(Config::default()));
        for (key, default) in Config::default().values() {
            let config = off_default(&key, &default);
            assert_eq!(Config::from_values(config.values()), Ok(config.clone()), "{key}");
            let differences = config.differences().unwrap();
            assert_eq!((differences.len(), &differences[0].key), (1, &key));
            assert_eq!(differences[0].default, default);
        }
    }

    #[test]
    fn changes_are_told_with_the_defaults() {
        let yaml = "/**:\n  ros__parameters:\n    mesh: {kernel: uniform, scale: 30, power: 2}\n";
        let changes = Config::changes(yaml).unwrap();
        let changes = changes.iter().map(|c| format!("{} {} {}", c.key, c.value, c.default));
        let expected = ["mesh.kernel \"uniform\" \"inverse_distance\"", "mesh.power 2.0 4.0"];
        assert_eq!(changes.collect::<Vec<_>>(), expected);
    }

    #[test]
    fn another_form_of_file_is_refused() {
        for text in
            ["retarget: {steps: 5}", "/**: 3", "- 1", "/**: {parameters: {}}", "a: [", "\"\\xzz"]
        {
            assert!(Config::from_yaml(text, &[]).is_err(), "{text}");
        }
    }

    #[test]
    fn the_shipped_file_holds_every_key_with_its_default() {
        let yaml = include_str!("../../config/handover.yaml");
        assert_eq!(Config::from_yaml(yaml, &[]), Ok(Config::default()));
        let mut values = BTreeMap::new();
        flatten("", parameters(&parse_yaml(yaml).unwrap()).unwrap(), &mut values);
        let parameters = Config::default().parameters(&NodeSettings::default());
        let known: BTreeMap<String, Value> =
            parameters.into_iter().map(|parameter| (parameter.key, parameter.value)).collect();
        assert_eq!(values.keys().collect::<Vec<_>>(), known.keys().collect::<Vec<_>>());
        let changed = Config::changes(yaml).unwrap();
        assert!(changed.is_empty(), "{changed:?}");
    }

    #[test]
    fn every_parameter_is_described_with_its_bounds() {
        for parameter in Config::default().parameters(&NodeSettings::default()) {
            assert!(parameter.description.len() > 8, "{parameter:?}");
            if let Kind::Real { low, high } = parameter.kind {
                let value = parameter.value.as_f64().unwrap();
                assert!((low..=high).contains(&value), "{parameter:?}");
            }
        }
    }
}
