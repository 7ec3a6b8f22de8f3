//! Typed access to dotted keys of a scenario, collecting whatever is wrong.

use std::collections::BTreeMap;

use handover_mesh::config::Violation;
use serde_json::Value;

use crate::check::Violations;

/// Keys and values that are taken one by one; what nobody takes is unknown.
pub(super) struct Fields {
    values: BTreeMap<String, Value>,
    violations: Vec<Violation>,
    known: Vec<String>,
}

impl Fields {
    /// Nested maps → dotted keys. An empty map stays a value: it is said to be one, not taken for
    /// nothing.
    pub(super) fn of(file: &Value) -> Self {
        let mut values = BTreeMap::new();
        flatten("", file, &mut values);
        Self { values, violations: Vec::new(), known: Vec::new() }
    }

    /// Whether a key is given, or one below it.
    pub(super) fn has(&self, section: &str) -> bool {
        let below =
            |key: &String| key.strip_prefix(section).is_some_and(|rest| rest.starts_with('.'));
        self.values.contains_key(section) || self.values.keys().any(below)
    }

    /// Whether something was found wrong with a section or a key in it, or nobody took it.
    pub(super) fn is_faulty(&self, section: &str) -> bool {
        let is_within = |key: &str| {
            key.strip_prefix(section).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        self.violations.iter().any(|violation| is_within(&violation.key))
            || self.values.keys().any(|key| is_within(key))
    }

    /// The value under a key, if it is there and `parse` takes it; else remembers the bound.
    fn take<T>(
        &mut self,
        key: &str,
        parse: impl Fn(&Value) -> Option<T>,
        bound: impl FnOnce() -> String,
    ) -> Option<T> {
        self.known.push(key.to_owned());
        let value = self.values.remove(key).or_else(|| self.remove_below(key))?;
        let parsed = parse(&value);
        if parsed.is_none() {
            self.blame(key, format!("is {value}, must be {}", bound()));
        }
        parsed
    }

    /// The map that stands where a value should, if one does: nobody is to ask for what is in it.
    fn remove_below(&mut self, key: &str) -> Option<Value> {
        let mut map = serde_json::Map::new();
        self.values.retain(|given, value| {
            let name = given.strip_prefix(key).and_then(|rest| rest.strip_prefix('.'));
            if let Some(name) = name {
                map.insert(name.to_owned(), value.take());
            }
            name.is_none()
        });
        (!map.is_empty()).then_some(Value::Object(map))
    }

    /// Remembers what is wrong with a key.
    pub(super) fn blame(&mut self, key: impl Into<String>, problem: impl Into<String>) {
        self.violations.push(Violation { key: key.into(), problem: problem.into() });
    }

    /// Remembers what a configuration found out of range, below `section`.
    pub(super) fn blame_all(&mut self, section: &str, found: Result<(), Violations>) {
        for violation in found.err().iter().flat_map(Violations::all) {
            let problem = format!("is {}, must be in {}", violation.value, violation.bound);
            self.blame(format!("{section}{}", violation.key), problem);
        }
    }

    /// A number, whose range is checked with the others of its configuration.
    pub(super) fn number(&mut self, key: &str, target: &mut f64) {
        let number = self.take(key, Value::as_f64, || "a number".to_owned());
        *target = number.unwrap_or(*target);
    }

    /// A number between two bounds, both included.
    pub(super) fn float(&mut self, key: &str, target: &mut f64, low: f64, high: f64) {
        *target = self.limit(key, low, high).unwrap_or(*target);
    }

    /// A number between two bounds, both included, that may be absent.
    pub(super) fn limit(&mut self, key: &str, low: f64, high: f64) -> Option<f64> {
        let parse = |value: &Value| value.as_f64().filter(|number| (low..=high).contains(number));
        self.take(key, parse, || format!("a number from {low} to {high}"))
    }

    /// How long something lasts `[s]`, from 0 to `most`: needed wherever its section is a map.
    ///
    /// - `for_good`: whether the text `for_good` may stand for what does not end.
    pub(super) fn duration(&mut self, key: &str, most: f64, for_good: bool) -> Option<f64> {
        let section = key.rsplit_once('.').map_or("", |(section, _)| section);
        let is_map = self.has(section) && !self.values.contains_key(section);
        let alternative = if for_good { ", or for_good" } else { "" };
        let bound = format!("a number from 0 to {most}{alternative}");
        if is_map && !self.has(key) {
            self.blame(key, format!("is missing, must be {bound}"));
        }
        let parse = |value: &Value| match value.as_str() {
            Some("for_good") if for_good => Some(f64::INFINITY),
            _ => value.as_f64().filter(|number| (0.0..=most).contains(number)),
        };
        self.take(key, parse, || bound)
    }

    /// A whole number ≥ 0 that may be absent.
    pub(super) fn whole(&mut self, key: &str) -> Option<u64> {
        self.take(key, Value::as_u64, || "a whole number ≥ 0".to_owned())
    }

    /// A text that is not empty.
    pub(super) fn text(&mut self, key: &str) -> Option<String> {
        let text = |value: &Value| value.as_str().filter(|t| !t.is_empty()).map(str::to_owned);
        self.take(key, text, || "text".to_owned())
    }

    /// One of some named values.
    pub(super) fn choice<T: Copy>(&mut self, key: &str, target: &mut T, choices: &[(&str, T)]) {
        let parse = |value: &Value| named(value, choices);
        *target = self.take(key, parse, || one_of(choices)).unwrap_or(*target);
    }

    /// A list of named values that may be absent.
    pub(super) fn choices<T: Copy>(&mut self, key: &str, choices: &[(&str, T)]) -> Option<Vec<T>> {
        let parse = |value: &Value| value.as_array()?.iter().map(|v| named(v, choices)).collect();
        self.take(key, parse, || format!("a list, each {}", one_of(choices)))
    }

    /// One of some whole numbers.
    pub(super) fn rate(&mut self, key: &str, target: &mut u32, rates: &[u32]) {
        let parse = |value: &Value| {
            let rate = u32::try_from(value.as_u64()?).ok()?;
            rates.contains(&rate).then_some(rate)
        };
        let list = || rates.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
        *target = self.take(key, parse, || format!("one of {}", list())).unwrap_or(*target);
    }

    /// Every key that was asked for, whether or not it is given, in that order.
    pub(super) fn into_known(self) -> Vec<String> {
        self.known
    }

    /// All violations, those of unknown keys last; none: nothing is wrong.
    pub(super) fn finish(mut self) -> Vec<Violation> {
        // Once for each, however much is below it.
        let mut unknown = BTreeMap::new();
        for (key, value) in &self.values {
            let within = self.names(key);
            if !within.is_empty() {
                let problem = format!("is {value}, must be a map of {}", within.join(", "));
                unknown.insert(key.clone(), problem);
                continue;
            }
            let outermost = self.outermost_unknown(key);
            let (section, _) = outermost.rsplit_once('.').unwrap_or(("", outermost));
            let problem = format!("is unknown: there is only {}", self.names(section).join(", "));
            unknown.insert(outermost.to_owned(), problem);
        }
        let unknown = unknown.into_iter().map(|(key, problem)| Violation { key, problem });
        self.violations.extend(unknown);
        self.violations
    }

    /// A key, or the section around it that is unknown, if one is.
    fn outermost_unknown<'a>(&self, key: &'a str) -> &'a str {
        let ends = key.match_indices('.').map(|(at, _)| at);
        let mut sections = ends.map(|at| &key[..at]);
        sections.find(|section| self.names(section).is_empty()).unwrap_or(key)
    }

    /// What may stand in a section, in the order it was asked for.
    fn names(&self, section: &str) -> Vec<&str> {
        let below = self.known.iter().filter_map(|known| match section {
            "" => Some(known.as_str()),
            section => known.strip_prefix(section)?.strip_prefix('.'),
        });
        let mut names: Vec<&str> = below.filter_map(|name| name.split('.').next()).collect();
        names.dedup();
        names
    }
}

fn named<T: Copy>(value: &Value, choices: &[(&str, T)]) -> Option<T> {
    choices.iter().find(|(name, _)| value.as_str() == Some(name)).map(|(_, choice)| *choice)
}

fn one_of<T>(choices: &[(&str, T)]) -> String {
    let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
    format!("one of {}", names.join(", "))
}

fn flatten(prefix: &str, value: &Value, values: &mut BTreeMap<String, Value>) {
    match value {
        Value::Object(map) if !map.is_empty() => {
            for (key, value) in map {
                let key = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
                flatten(&key, value, values);
            }
        }
        value => {
            values.insert(prefix.to_owned(), value.clone());
        }
    }
}
