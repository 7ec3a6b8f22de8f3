//! A node's parameters: a table that says what each is and may be → values, or refusals by name.
//!
//! ROS 2 hands parameters over as names and loose values, at the start and while a node runs. Here
//! they meet their descriptions: the right kind of value (a whole number is a number, too), within
//! its bounds, not changed where a change would do nothing. The services that a graph asks are in
//! the node's shell; they hold one of these tables.
//!
//! Needs no ROS, and does not know what a parameter does.

mod refusal;
mod table;
mod value;

pub use refusal::{Refusal, Refusals};
pub use table::{Listed, ParameterTable};
pub use value::ParameterValue;

/// What a parameter may be, besides its kind.
#[derive(Debug, Clone, PartialEq)]
pub enum Bound {
    /// Anything.
    None,
    /// Numbers from the first to the second, both included; of a list each one.
    Numbers(f64, f64),
    /// Whole numbers from the first to the second, both included; of a list each one.
    Whole(i64, i64),
    /// One of these texts.
    OneOf(Vec<String>),
    /// A text that is not empty, or a list of such.
    Filled,
}

/// One parameter: its name, its value, and all that is said about it.
///
/// ```
/// use handover_mesh::parameters::Parameter;
/// let speed = Parameter::new("speed", 1.0, "How fast, 1 is as recorded [-]").numbers(0.01, 100.0);
/// let file = Parameter::new("file", "", "What to play").read_only("it is read at the start");
/// assert!(speed.read_only.is_none() && file.read_only.is_some());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Sections and name, dotted.
    pub name: String,
    /// What it is; its kind stays.
    pub value: ParameterValue,
    /// Meaning and unit, for people.
    pub description: String,
    /// What it may be.
    pub bound: Bound,
    /// How many a list has; any number of them where it is not said.
    pub length: Option<usize>,
    /// Why it cannot be changed while the node runs, where it cannot.
    pub read_only: Option<String>,
}

impl Parameter {
    /// A parameter that may be anything of its value's kind, and be changed.
    pub fn new(
        name: impl Into<String>,
        value: impl Into<ParameterValue>,
        description: impl Into<String>,
    ) -> Self {
        Self {
            name: name.into(),
            value: value.into(),
            description: description.into(),
            bound: Bound::None,
            length: None,
            read_only: None,
        }
    }

    /// The same, from `low` to `high`, both included.
    #[must_use]
    pub fn numbers(self, low: f64, high: f64) -> Self {
        Self { bound: Bound::Numbers(low, high), ..self }
    }

    /// The same, from `low` to `high`, both included.
    #[must_use]
    pub fn whole(self, low: i64, high: i64) -> Self {
        Self { bound: Bound::Whole(low, high), ..self }
    }

    /// The same, one of some texts.
    #[must_use]
    pub fn one_of<T: Into<String>>(self, choices: impl IntoIterator<Item = T>) -> Self {
        Self { bound: Bound::OneOf(choices.into_iter().map(Into::into).collect()), ..self }
    }

    /// The same, a text that is not empty, or a list of such.
    #[must_use]
    pub fn filled(self) -> Self {
        Self { bound: Bound::Filled, ..self }
    }

    /// The same, a list of so many.
    #[must_use]
    pub fn of_length(self, length: usize) -> Self {
        Self { length: Some(length), ..self }
    }

    /// The same, not to be changed while the node runs.
    ///
    /// - `reason`: what whoever tries is told.
    #[must_use]
    pub fn read_only(self, reason: impl Into<String>) -> Self {
        Self { read_only: Some(reason.into()), ..self }
    }

    /// What it may be, in words: `a number from 0 to 1`.
    pub fn allowed(&self) -> String {
        let kind = self.value.kind(self.length);
        match &self.bound {
            Bound::None => kind,
            Bound::Numbers(low, high) => format!("{kind} from {low} to {high}"),
            Bound::Whole(low, high) => format!("{kind} from {low} to {high}"),
            Bound::OneOf(choices) => format!("one of {}", choices.join(", ")),
            Bound::Filled => format!("{kind}, not empty"),
        }
    }

    /// A value as this parameter's, if it may have it: its kind, within its bounds.
    ///
    /// A whole number is taken for a number, a list of none for any list, and what a YAML reader
    /// made a truth value of (`y`, `off`) for the choice that it was.
    ///
    /// # Errors
    /// [`Refusal::Value`].
    pub fn accept(&self, value: &ParameterValue) -> Result<ParameterValue, Refusal> {
        let refused = || Refusal::Value {
            name: self.name.clone(),
            value: value.to_string(),
            allowed: self.allowed(),
        };
        let value = value.clone();
        let value = match (&self.bound, &value) {
            (Bound::OneOf(choices), ParameterValue::Bool(truth)) => {
                word_read_as(*truth, choices).map_or(value, ParameterValue::Text)
            }
            _ => value,
        };
        let value = value.converted(&self.value).ok_or_else(refused)?;
        let is_within = match &self.bound {
            Bound::None => value.numbers().iter().all(|number| !number.is_nan()),
            Bound::Numbers(low, high) => value.numbers().iter().all(|n| (*low..=*high).contains(n)),
            Bound::Whole(low, high) => value.whole().iter().all(|n| (*low..=*high).contains(n)),
            Bound::OneOf(choices) => value.texts().iter().all(|text| choices.contains(text)),
            Bound::Filled => value.texts().iter().all(|text| !text.is_empty()),
        };
        let has_length = self.length.is_none_or(|length| value.length() == Some(length));
        if is_within && has_length { Ok(value) } else { Err(refused()) }
    }
}

/// Which choice a YAML 1.1 reader, as ROS has one, takes for this truth value.
fn word_read_as(truth: bool, choices: &[String]) -> Option<String> {
    let words = if truth { ["y", "yes", "on", "true"] } else { ["n", "no", "off", "false"] };
    choices.iter().find(|choice| words.contains(&choice.as_str())).cloned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(parameter: &Parameter, value: impl Into<ParameterValue>, expected: Option<&str>) {
        let refusal = parameter.accept(&value.into()).err().map(|refusal| refusal.to_string());
        assert_eq!(refusal.as_deref(), expected);
    }

    #[test]
    fn a_value_is_of_its_kind_and_within_its_bounds() {
        let speed = Parameter::new("speed", 1.0, "").numbers(0.5, 2.0);
        check(&speed, 2.0, None);
        check(&speed, 1, None);
        check(&speed, 3, Some("speed is 3, must be a number from 0.5 to 2"));
        check(&speed, f64::NAN, Some("speed is NaN, must be a number from 0.5 to 2"));
        let frame = Parameter::new("frame", "world", "").filled();
        check(&frame, "", Some("frame is \"\", must be text, not empty"));
        check(&speed, "1", Some("speed is \"1\", must be a number from 0.5 to 2"));
        assert_eq!(speed.accept(&1.into()), Ok(ParameterValue::Double(1.0)));
        let seed = Parameter::new("seed", 1, "").whole(0, 9);
        check(&seed, 10, Some("seed is 10, must be a whole number from 0 to 9"));
        check(&seed, 1.0, Some("seed is 1.0, must be a whole number from 0 to 9"));
        check(&Parameter::new("any", 0.0, ""), f64::NAN, Some("any is NaN, must be a number"));
        let names = Parameter::new("names", vec![String::new()], "");
        check(&names, vec!["a".to_owned()], None);
        check(&names, Vec::<bool>::new(), None);
        check(&names, vec![1.0], Some("names is [1.0], must be a list of texts"));
        let box_of = Parameter::new("box", vec![0.0; 2], "").numbers(-1.0, 1.0).of_length(2);
        check(&box_of, vec![1_i64, 0], None);
        check(&box_of, vec![0.0], Some("box is [0.0], must be 2 numbers from -1 to 1"));
        check(&box_of, vec![0.0, 3.0], Some("box is [0.0, 3.0], must be 2 numbers from -1 to 1"));
    }

    #[test]
    fn a_choice_that_yaml_takes_for_a_truth_is_still_the_choice() {
        let up = Parameter::new("up", "z", "").one_of(["z", "y"]);
        assert_eq!(up.accept(&true.into()), Ok("y".into()));
        check(&up, false, Some("up is false, must be one of z, y"));
        check(&up, "x", Some("up is \"x\", must be one of z, y"));
    }
}
