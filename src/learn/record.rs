//! A step ⇄ JSON, by the names of people and joints: the one place that knows how one is written.
//!
//! `{"edge":["giver/right_hand","receiver/right_hand"],"move":"add","before":0.2,"distance":0.1}`,
//! distances in metres. Numbers read back to the bit.

use serde_json::{Map, Value, json};

use super::{DescentState, Move, Step};
use crate::mesh::{Edge, Pair, Vertex};
use crate::skeleton::Role;

/// Why JSON is no step.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RecordError {
    /// Something else than an object.
    #[error("a step is an object, this is {found}")]
    NotAnObject {
        /// What it is.
        found: &'static str,
    },
    /// A value is missing, or not of the kind that stands there.
    #[error("a step's '{key}' must be {expected}")]
    Value {
        /// Its key.
        key: &'static str,
        /// What must stand there.
        expected: &'static str,
    },
    /// A key that no step has.
    #[error("a step has no '{key}'")]
    Unknown {
        /// The key.
        key: String,
    },
    /// A move of no known kind.
    #[error("no step makes the move '{name}'")]
    Move {
        /// What was read.
        name: String,
    },
    /// A person without this joint, or nobody of this name.
    #[error("'{name}' is no joint of {person}")]
    Joint {
        /// What was read.
        name: String,
        /// Whose joint it must be.
        person: String,
    },
}

impl Step {
    /// The step as a JSON object.
    ///
    /// - `people`: the names of the people, in the recordings' order.
    pub fn to_json(&self, pair: &Pair, people: [&str; 2]) -> Value {
        let Self { change, before, distance } = self;
        let mut record = Map::new();
        match change {
            Move::Add(edge) => {
                record.insert("edge".to_owned(), json!(edge.names(pair, people)));
                record.insert("move".to_owned(), json!("add"));
            }
            Move::Remove(edge) => {
                record.insert("edge".to_owned(), json!(edge.names(pair, people)));
                record.insert("move".to_owned(), json!("remove"));
            }
            Move::Descend(state) => {
                record.insert("move".to_owned(), json!("descend"));
                record.insert("refit".to_owned(), json!(state.refit));
                record.insert("factors".to_owned(), json!(state.factors));
                record.insert("length".to_owned(), json!(state.length));
                record.insert("recent".to_owned(), json!(state.recent));
                record.insert("taken".to_owned(), json!(state.taken));
                record.insert("evaluations".to_owned(), json!(state.evaluations));
            }
        }
        record.insert("before".to_owned(), json!(before));
        record.insert("distance".to_owned(), json!(distance));
        Value::Object(record)
    }

    /// What [`Self::to_json`] wrote, for the same people.
    ///
    /// # Errors
    /// [`RecordError`] on the first key that is missing, unknown or holds something else.
    pub fn from_json(record: &Value, pair: &Pair, people: [&str; 2]) -> Result<Self, RecordError> {
        let Value::Object(record) = record else {
            return Err(RecordError::NotAnObject { found: kind(record) });
        };
        let mut record = Record(record.clone());
        let name = record.text("move")?;
        let change = match name.as_str() {
            "add" => Move::Add(record.edge(pair, people)?),
            "remove" => Move::Remove(record.edge(pair, people)?),
            "descend" => Move::Descend(DescentState {
                refit: record.value("refit", "true or false", Value::as_bool)?,
                factors: record.list("factors", factor)?,
                length: record.value("length", "a number", Value::as_f64)?,
                recent: record.list("recent", Value::as_f64)?,
                taken: record.value("taken", "a count", count)?,
                evaluations: record.value("evaluations", "a count", count)?,
            }),
            _ => return Err(RecordError::Move { name }),
        };
        let step =
            Self { change, before: record.metres("before")?, distance: record.metres("distance")? };
        match record.0.into_iter().next() {
            Some((key, _)) => Err(RecordError::Unknown { key }),
            None => Ok(step),
        }
    }
}

/// An object whose values are taken one by one; what nobody takes is unknown.
struct Record(Map<String, Value>);

impl Record {
    fn text(&mut self, key: &'static str) -> Result<String, RecordError> {
        match self.0.remove(key) {
            Some(Value::String(text)) => Ok(text),
            _ => Err(RecordError::Value { key, expected: "text" }),
        }
    }

    /// A length `[m]`, finite and ≥ 0.
    fn metres(&mut self, key: &'static str) -> Result<f64, RecordError> {
        let number = self.0.remove(key).and_then(|value| value.as_f64());
        let metres = number.filter(|number| number.is_finite() && *number >= 0.0);
        metres.ok_or(RecordError::Value { key, expected: "a number of metres, >= 0" })
    }

    fn value<T>(
        &mut self,
        key: &'static str,
        expected: &'static str,
        read: impl Fn(&Value) -> Option<T>,
    ) -> Result<T, RecordError> {
        let value = self.0.remove(key).as_ref().and_then(read);
        value.ok_or(RecordError::Value { key, expected })
    }

    fn list<T>(
        &mut self,
        key: &'static str,
        read: impl Fn(&Value) -> Option<T>,
    ) -> Result<Vec<T>, RecordError> {
        self.value(key, "a list of numbers", |value| value.as_array()?.iter().map(&read).collect())
    }

    fn edge(&mut self, pair: &Pair, people: [&str; 2]) -> Result<Edge, RecordError> {
        let (key, expected) = ("edge", "the names of two joints");
        let ends = self.0.remove(key);
        let ends = ends.as_ref().and_then(Value::as_array).map(Vec::as_slice);
        let Some([Value::String(first), Value::String(second)]) = ends else {
            return Err(RecordError::Value { key, expected });
        };
        let first = vertex(first, Role::First, pair, people)?;
        Ok(Edge::new(first, vertex(second, Role::Second, pair, people)?))
    }
}

fn vertex(name: &str, role: Role, pair: &Pair, people: [&str; 2]) -> Result<Vertex, RecordError> {
    let found = pair.vertices(role).find(|vertex| pair.name(*vertex, people) == name);
    let person = || people[role as usize].to_owned();
    found.ok_or_else(|| RecordError::Joint { name: name.to_owned(), person: person() })
}

fn count(value: &Value) -> Option<usize> {
    value.as_u64()?.try_into().ok()
}

/// `[place, factor]`.
fn factor(value: &Value) -> Option<(usize, f64)> {
    let [place, factor] = value.as_array()?.as_slice() else { return None };
    Some((count(place)?, factor.as_f64()?))
}

fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "true or false",
        Value::Number(_) => "a number",
        Value::String(_) => "a text",
        Value::Array(_) => "a list",
        Value::Object(_) => "an object",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::skeleton::Skeleton;

    const PEOPLE: [&str; 2] = ["giver", "receiver"];

    fn pair() -> Pair {
        Pair::new([Skeleton::nite(), Skeleton::nite()])
    }

    #[test]
    fn a_step_reads_back_to_the_bit() {
        let pair = pair();
        let (first, second) = (pair.vertices(Role::First), pair.vertices(Role::Second));
        for (a, b) in first.zip(second.skip(3).chain(pair.vertices(Role::Second))) {
            // Numbers that only their shortest exact text gives back.
            let before = 0.1 + a.index() as f64 / 3.0;
            let distance = f64::from_bits(before.to_bits() - 1);
            for change in [Move::Add(Edge::new(a, b)), Move::Remove(Edge::new(a, b))] {
                let step = Step { change, before, distance };
                let text = step.to_json(&pair, PEOPLE).to_string();
                let read: Value = serde_json::from_str(&text).unwrap();
                assert_eq!(Step::from_json(&read, &pair, PEOPLE), Ok(step), "{text}");
            }
        }
    }

    #[track_caller]
    fn check(text: &str, expected: &str) {
        let record: Value = serde_json::from_str(text).unwrap();
        let error = Step::from_json(&record, &pair(), PEOPLE).unwrap_err().to_string();
        assert_eq!(error, expected);
    }

    #[test]
    fn what_is_no_step_is_named() {
        let step = |edge: &str, name: &str, rest: &str| {
            format!(r#"{{"edge":{edge},"move":"{name}","before":0.2{rest}}}"#)
        };
        let edge = r#"["giver/head","receiver/head"]"#;
        let rest = r#","distance":0.1"#;
        check("[]", "a step is an object, this is a list");
        check("{}", "a step's 'move' must be text");
        check(&step(edge, "wave", rest), "no step makes the move 'wave'");
        check(&step("[1, 2]", "add", rest), "a step's 'edge' must be the names of two joints");
        let tail = r#"["giver/head","receiver/tail"]"#;
        check(&step(tail, "add", rest), "'receiver/tail' is no joint of receiver");
        let swapped = r#"["receiver/head","giver/head"]"#;
        check(&step(swapped, "add", rest), "'receiver/head' is no joint of giver");
        let metres = "a step's 'distance' must be a number of metres, >= 0";
        check(&step(edge, "add", ""), metres);
        check(&step(edge, "add", r#","distance":null"#), metres);
        check(&step(edge, "add", r#","distance":-1"#), metres);
        check(&step(edge, "add", r#","distance":0.1,"mood":1"#), "a step has no 'mood'");
    }
}
