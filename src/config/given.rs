//! What a running node is given (at its start, or set since) over what a model was learned with.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};

use super::{
    Change, Config, ConfigError, Kind, NodeSettings, RobotState, Source, Violation, describe,
};
use crate::geometry::Isometry;
use crate::parameters::{Parameter, ParameterTable, ParameterValue};

/// What may change at any time.
const ALWAYS: [&str; 6] = [
    "node.partner",
    "node.start_zone",
    "node.approach",
    "node.contact_distance",
    "node.markers_rate",
    "node.diagnostics_rate",
];

/// Sections of parameters that a model was learned with and that the tick reads.
const OF_THE_TICK: [&str; 7] =
    ["robot.", "object.", "observation.", "reference.", "mesh.", "retarget.", "forecast."];

/// Every parameter of the node as a graph sees it: its default, bounds and text, and whether it can
/// be set at all.
pub fn declared() -> Vec<Parameter> {
    let parameters = Config::default().parameters(&NodeSettings::default());
    parameters.into_iter().map(parameter).collect()
}

fn parameter(from: describe::Parameter) -> Parameter {
    let describe::Parameter { key, kind, value, description } = from;
    let empty = match &kind {
        Kind::Flag => ParameterValue::Bool(false),
        Kind::Real { .. } => ParameterValue::Double(0.0),
        Kind::Whole { .. } => ParameterValue::Integer(0),
        Kind::Text | Kind::Choice(_) => ParameterValue::Text(String::new()),
        Kind::Reals => ParameterValue::Doubles(Vec::new()),
        Kind::Texts => ParameterValue::Texts(Vec::new()),
    };
    let declared = Parameter::new(key.clone(), to_parameter(&value, &empty), description);
    let declared = match kind {
        Kind::Real { low, high } => declared.numbers(low, high),
        Kind::Whole { low, high } => declared.whole(low, high),
        Kind::Choice(words) => declared.one_of(words),
        Kind::Reals if key.contains("_from_") => declared.of_length(6),
        Kind::Flag | Kind::Text | Kind::Reals | Kind::Texts => declared,
    };
    match key.as_str() {
        "node.source" => declared.read_only("topics are subscribed to at the start"),
        "node.autostart" => declared.read_only("it counts at the start"),
        key if key.starts_with("node.") || Config::is_of_the_robot(key) => declared,
        _ => declared.read_only("it belongs to the model, which was learned with it"),
    }
}

/// The names of what was given: all else is the model's.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Given(BTreeSet<String>);

impl Given {
    /// - `names`: of parameters of [`declared`]; others are nobody's, and do no harm.
    pub fn new(names: impl IntoIterator<Item = String>) -> Self {
        Self(names.into_iter().collect())
    }

    /// Somebody set it, be it to what it was before.
    pub fn add(&mut self, name: &str) {
        self.0.insert(name.to_owned());
    }

    /// Whether a parameter may be set now.
    ///
    /// # Errors
    /// Why not.
    pub fn may_set(
        table: &ParameterTable,
        changes: &[(String, ParameterValue)],
        is_configured: bool,
    ) -> Result<(), String> {
        for (name, value) in changes {
            if is_configured && !ALWAYS.contains(&name.as_str()) {
                return Err(format!(
                    "{name} is read when the node is configured, which it is (hint: clean it up \
                     first)"
                ));
            }
            // The table knows the bounds of numbers, not those of lists of them.
            if name == "safety.workspace" || name.contains("_from_") {
                let alone = [(name.clone(), to_json(value))];
                Config::default()
                    .with_values(&NodeSettings::default(), alone)
                    .map_err(|error| error.to_string())?;
            }
            let numbers_nobody = table.text("node.source") == "skeleton";
            if name == "node.partner" && numbers_nobody && *value != ParameterValue::Integer(-1) {
                return Err(Self::NOBODY_IS_NUMBERED.to_owned());
            }
        }
        Ok(())
    }

    const NOBODY_IS_NUMBERED: &str =
        "node.partner is a body's number, and the topic skeleton (node.source) has none";

    /// What the node itself is told.
    ///
    /// # Errors
    /// [`ConfigError`] with all that is wrong, also what only together means nothing.
    pub fn node(&self, table: &ParameterTable) -> Result<NodeSettings, ConfigError> {
        let values = self.values(table).into_iter().filter(|(key, _)| key.starts_with("node."));
        let (_, node, _) = Config::default().with_values(&NodeSettings::default(), values)?;
        let mut violations = Vec::new();
        let mut refuse = |key: &str, problem: &str| {
            violations.push(Violation { key: key.to_owned(), problem: problem.to_owned() });
        };
        if node.partner.is_some() && node.source == Source::Skeleton {
            refuse(
                "node.partner",
                "means nothing: the topic skeleton (node.source) has no numbers",
            );
        }
        if node.sensor_frame.is_empty() && node.world_from_sensor != Isometry::identity() {
            refuse("node.world_from_sensor", "is of node.sensor_frame, which is not set");
        }
        if !node.sensor_frame.is_empty() && node.sensor_frame == node.world_frame {
            refuse("node.sensor_frame", "is node.world_frame: a sensor's frame lies in the world");
        }
        // A file may hold all defaults.
        let default = NodeSettings::default();
        if node.robot_state == RobotState::Reported {
            let problem = "means nothing to a robot that reports (node.robot_state)";
            if node.world_from_base != default.world_from_base {
                refuse("node.world_from_base", problem);
            }
            if node.base_frame != default.base_frame {
                refuse("node.base_frame", problem);
            }
        }
        if violations.is_empty() { Ok(node) } else { Err(ConfigError::Violations(violations)) }
    }

    /// The model's parameters, with those given over them that are the robot's; and those given that
    /// differ from what the model was learned with, of those that the tick reads: they count for
    /// nothing.
    ///
    /// # Errors
    /// [`ConfigError`] with all that is wrong.
    pub fn over(
        &self,
        model: &Config,
        table: &ParameterTable,
    ) -> Result<(Config, Vec<Change>), ConfigError> {
        let node = NodeSettings::default();
        let given = self.values(table).into_iter().filter(|(key, _)| !key.starts_with("node."));
        let (robots, models): (Vec<_>, Vec<_>) =
            given.partition(|(key, _)| Config::is_of_the_robot(key));
        let (_, _, mut differing) = model.with_values(&node, models)?;
        let counts = |key: &str| OF_THE_TICK.iter().any(|section| key.starts_with(section));
        differing.retain(|change| counts(&change.key));
        Ok((model.with_values(&node, robots)?.0, differing))
    }

    /// What was given, as a parameter file would have it.
    fn values(&self, table: &ParameterTable) -> BTreeMap<String, Value> {
        let known = |name: &String| Config::default().values().iter().any(|(key, _)| key == name);
        let given = self.0.iter().filter(|name| name.starts_with("node.") || known(name));
        given.filter_map(|name| Some((name.clone(), to_json(&table.get(name)?.value)))).collect()
    }
}

/// What a table has to be told so that it shows what a configuration is.
pub fn differences(config: &Config, table: &ParameterTable) -> Vec<(String, ParameterValue)> {
    let shown = config.values().into_iter().filter_map(|(name, value)| {
        let before = &table.get(&name)?.value;
        let value = to_parameter(&value, before);
        (value != *before).then_some((name, value))
    });
    shown.collect()
}

fn to_json(value: &ParameterValue) -> Value {
    match value {
        ParameterValue::NotSet => Value::Null,
        ParameterValue::Bool(value) => json!(value),
        ParameterValue::Integer(value) => json!(value),
        ParameterValue::Double(value) => json!(value),
        ParameterValue::Text(value) => json!(value),
        ParameterValue::Bytes(value) => json!(value),
        ParameterValue::Bools(value) => json!(value),
        ParameterValue::Integers(value) => json!(value),
        ParameterValue::Doubles(value) => json!(value),
        ParameterValue::Texts(value) => json!(value),
    }
}

/// A value of the kind that `like` is; `like` itself where it is of no such kind.
fn to_parameter(value: &Value, like: &ParameterValue) -> ParameterValue {
    let list = || value.as_array().into_iter().flatten();
    let text = |value: &Value| value.as_str().map(str::to_owned);
    let found = match like {
        ParameterValue::Bool(_) => value.as_bool().map(Into::into),
        ParameterValue::Integer(_) => value.as_i64().map(Into::into),
        ParameterValue::Double(_) => value.as_f64().map(Into::into),
        ParameterValue::Text(_) => text(value).map(Into::into),
        ParameterValue::Doubles(_) => {
            Some(ParameterValue::Doubles(list().filter_map(Value::as_f64).collect()))
        }
        ParameterValue::Texts(_) => Some(ParameterValue::Texts(list().filter_map(text).collect())),
        _ => None,
    };
    found.unwrap_or_else(|| like.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(values: &[(&str, ParameterValue)]) -> (ParameterTable, Given) {
        let mut table = ParameterTable::new(declared());
        let values = values.iter().map(|(name, value)| ((*name).to_owned(), value.clone()));
        let values: Vec<_> = values.collect();
        table.start(values.clone()).unwrap();
        (table, Given::new(values.into_iter().map(|(name, _)| name)))
    }

    fn model() -> Config {
        let given = [("safety.speed", json!(3.0)), ("mesh.scale", json!(7.0))];
        let given = given.map(|(key, value)| (key.to_owned(), value));
        Config::default().with_values(&NodeSettings::default(), given).unwrap().0
    }

    #[test]
    fn what_is_not_given_is_the_models() {
        let (mut shown, given) =
            table(&[("safety.jerk", 500.0.into()), ("mesh.scale", 9.0.into())]);
        let (config, differing) = given.over(&model(), &shown).unwrap();
        assert_eq!((config.online.safety.speed, config.online.safety.jerk), (3.0, 500.0));
        assert_eq!(differing.len(), 1, "mesh.scale counts for nothing");
        assert_eq!((differing[0].key.as_str(), &differing[0].value), ("mesh.scale", &json!(9.0)));
        let told = differences(&config, &shown);
        assert!(told.contains(&("safety.speed".to_owned(), 3.0.into())));
        assert!(told.contains(&("mesh.scale".to_owned(), 7.0.into())));
        shown.start(told).unwrap();
        assert_eq!(differences(&config, &shown), []);
    }

    #[test]
    fn what_is_set_to_what_it_was_is_given_too() {
        let (shown, mut given) = table(&[]);
        assert_eq!(given.over(&model(), &shown).unwrap().0.online.safety.speed, 3.0);
        given.add("safety.speed");
        assert_eq!(given.over(&model(), &shown).unwrap().0.online.safety.speed, 1.7);
    }

    #[test]
    fn what_only_together_is_wrong_is_judged_over_the_model() {
        let (shown, given) = table(&[("safety.lead", 0.3.into())]);
        let error = given.over(&model(), &shown).unwrap_err().to_string();
        assert!(error.contains("must be at least safety.lead, 0.3"), "{error}");
        let mut wide = model();
        wide.online.safety.aim = 0.5;
        assert!(given.over(&wide, &shown).is_ok());
    }

    #[test]
    fn what_would_do_nothing_is_refused() {
        let pose = vec![0.0, 0.0, 2.0, 0.0, 0.0, 0.0];
        let (shown, given) =
            table(&[("node.partner", 3.into()), ("node.world_from_sensor", pose.into())]);
        let error = given.node(&shown).unwrap_err().to_string();
        assert!(error.contains("node.partner means nothing"), "{error}");
        assert!(error.contains("node.sensor_frame, which is not set"), "{error}");
        let (shown, given) = table(&[("node.sensor_frame", "world".into())]);
        let error = given.node(&shown).unwrap_err().to_string();
        assert!(error.contains("node.sensor_frame is node.world_frame"), "{error}");
        for (name, value) in [
            ("node.base_frame", ParameterValue::from("table")),
            ("node.world_from_base", vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0].into()),
        ] {
            let (shown, given) = table(&[(name, value.clone())]);
            let error = given.node(&shown).unwrap_err().to_string();
            assert!(error.contains(&format!("{name} means nothing to a robot")), "{error}");
            let (shown, given) =
                table(&[(name, value), ("node.robot_state", "demonstrated".into())]);
            assert!(given.node(&shown).is_ok());
        }
        let (shown, given) = table(&[]);
        assert!(given.node(&shown).is_ok());
        let set = |name: &str, value: ParameterValue, is_configured| {
            Given::may_set(&shown, &[(name.to_owned(), value)], is_configured)
        };
        assert!(set("node.partner", 3.into(), false).is_err());
        assert!(set("safety.workspace", vec![1.0].into(), false).is_err());
        let far = vec![1e9, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert!(set("node.world_from_base", far.into(), false).unwrap_err().contains("1000"));
        assert!(set("safety.speed", 1.0.into(), false).is_ok());
        assert!(set("safety.speed", 1.0.into(), true).unwrap_err().contains("clean it up first"));
        assert!(set("node.start_zone", 1.0.into(), true).is_ok());
    }
}
