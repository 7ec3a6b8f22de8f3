//! Typed access to flat keys, collecting whatever is wrong.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::{Change, Kind, Violation};
use crate::settings::{Number, Setting};

/// Keys and values that are taken one by one; what nobody takes is unknown.
pub(super) struct Fields {
    values: BTreeMap<String, Value>,
    violations: Vec<Violation>,
    changes: Vec<Change>,
    known: Vec<(&'static str, Kind)>,
    before: Vec<(String, Value)>,
}

impl Fields {
    pub(super) fn new(values: BTreeMap<String, Value>, violations: Vec<Violation>) -> Self {
        Self { values, violations, changes: Vec::new(), known: Vec::new(), before: Vec::new() }
    }

    /// What each target held before it was set, under its key: where no value is given, all that
    /// the targets hold.
    pub(super) fn before(self) -> Vec<(String, Value)> {
        self.before
    }

    /// Every key that was asked for, with what it takes and what it was before.
    pub(super) fn asked(self) -> impl Iterator<Item = (&'static str, Kind, Value)> {
        self.known.into_iter().zip(self.before).map(|((key, kind), (_, value))| (key, kind, value))
    }

    /// Sets `target` if the key is there and `parse` takes its value; else remembers the bound.
    pub(super) fn take<T: PartialEq>(
        &mut self,
        key: &'static str,
        kind: Kind,
        target: &mut T,
        parse: impl Fn(&Value) -> Option<T>,
        show: impl Fn(&T) -> Value,
        bound: impl FnOnce() -> String,
    ) {
        self.known.push((key, kind));
        self.before.push((key.to_owned(), show(target)));
        let Some(value) = self.values.remove(key) else { return };
        match parse(&value) {
            Some(parsed) if parsed == *target => {}
            Some(parsed) => {
                let (value, default) = (show(&parsed), show(target));
                self.changes.push(Change { key: key.to_owned(), value, default });
                *target = parsed;
            }
            None => {
                let problem = format!("is {value}, must be {}", bound());
                self.violations.push(Violation { key: key.to_owned(), problem });
            }
        }
    }

    /// Notes what is wrong with a value beside others.
    pub(super) fn refuse(&mut self, key: &str, problem: String) {
        self.violations.push(Violation { key: key.to_owned(), problem });
    }

    /// A number between two bounds, both included.
    pub(super) fn float(&mut self, key: &'static str, target: &mut f64, low: f64, high: f64) {
        let parse = |value: &Value| value.as_f64().filter(|number| (low..=high).contains(number));
        let bound = || format!("a number from {low} to {high}");
        self.take(key, Kind::Real { low, high }, target, parse, |n| json!(n), bound);
    }

    /// A whole number between two bounds, both included.
    pub(super) fn count(&mut self, key: &'static str, target: &mut usize, low: usize, high: usize) {
        let parse = |value: &Value| {
            let number = usize::try_from(value.as_u64()?).ok()?;
            (low..=high).contains(&number).then_some(number)
        };
        let bound = || format!("a whole number from {low} to {high}");
        let kind = Kind::Whole { low: low as i64, high: high as i64 };
        self.take(key, kind, target, parse, |n| json!(n), bound);
    }

    /// Numbers that have their bounds with them.
    pub(super) fn numbers<'a>(&mut self, settings: impl IntoIterator<Item = Setting<'a>>) {
        for Setting { key, number, low, high } in settings {
            match number {
                Number::Real(value) => self.float(key, value, low, high),
                Number::Count(value) => self.count(key, value, low as usize, high as usize),
            }
        }
    }

    /// A text that is not empty.
    pub(super) fn text(&mut self, key: &'static str, target: &mut String) {
        self.take(key, Kind::Text, target, text, |text| json!(text), || "text".to_owned());
    }

    /// A text that may be empty.
    pub(super) fn free_text(&mut self, key: &'static str, target: &mut String) {
        let parse = |value: &Value| value.as_str().map(str::to_owned);
        self.take(key, Kind::Text, target, parse, |text| json!(text), || "text".to_owned());
    }

    /// Yes or no.
    pub(super) fn flag(&mut self, key: &'static str, target: &mut bool) {
        let bound = || "true or false".to_owned();
        self.take(key, Kind::Flag, target, Value::as_bool, |flag| json!(flag), bound);
    }

    /// A list of texts.
    pub(super) fn texts(&mut self, key: &'static str, target: &mut Vec<String>) {
        let parse = |value: &Value| value.as_array()?.iter().map(text).collect();
        let bound = || "a list of texts".to_owned();
        self.take(key, Kind::Texts, target, parse, |texts| json!(texts), bound);
    }

    /// One of some named values.
    pub(super) fn choice<T: Copy + PartialEq>(
        &mut self,
        key: &'static str,
        target: &mut T,
        choices: &[(&'static str, T)],
    ) {
        let parse = |value: &Value| {
            choices.iter().find(|(name, _)| value.as_str() == Some(name)).map(|(_, choice)| *choice)
        };
        let show =
            |choice: &T| json!(choices.iter().find(|(_, c)| c == choice).map(|(name, _)| name));
        let names: Vec<&'static str> = choices.iter().map(|(name, _)| *name).collect();
        let bound = names.join(", ");
        let kind = Kind::Choice(names);
        self.take(key, kind, target, parse, show, || format!("one of {bound}"));
    }

    /// What differs from the defaults, or all violations, those of unknown keys last.
    pub(super) fn finish(mut self) -> Result<Vec<Change>, Vec<Violation>> {
        for key in self.values.keys() {
            let (section, _) = key.split_once('.').unwrap_or((key, ""));
            let siblings: Vec<&str> = self
                .known
                .iter()
                .filter_map(|(known, _)| known.strip_prefix(section)?.strip_prefix('.'))
                .collect();
            let problem = if siblings.is_empty() {
                let mut sections: Vec<&str> = self
                    .known
                    .iter()
                    .filter_map(|(known, _)| Some(known.split_once('.')?.0))
                    .collect();
                sections.dedup();
                format!("is no parameter; sections are {}", sections.join(", "))
            } else {
                format!("is no parameter; '{section}' has {}", siblings.join(", "))
            };
            self.violations.push(Violation { key: key.clone(), problem });
        }
        if self.violations.is_empty() { Ok(self.changes) } else { Err(self.violations) }
    }
}

fn text(value: &Value) -> Option<String> {
    value.as_str().filter(|text| !text.is_empty()).map(str::to_owned)
}
