//! All parameters of a node: read, listed, and changed by whoever may.

use super::{Parameter, ParameterValue, Refusal, Refusals};

/// Names and sections of parameters.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Listed {
    /// Of parameters, dotted.
    pub names: Vec<String>,
    /// The sections that these stand in, dotted.
    pub prefixes: Vec<String>,
}

/// A node's parameters, in the order they were declared; each value is one its parameter may have.
///
/// ```
/// use handover_mesh::parameters::{Parameter, ParameterTable};
/// let speed = Parameter::new("speed", 1.0, "How fast [-]").numbers(0.01, 100.0);
/// let mut table = ParameterTable::new(vec![speed]);
/// table.start([("speed".to_owned(), 2.into())])?;
/// assert_eq!(table.number("speed"), 2.0);
/// let refused = table.set(&[("speed".to_owned(), 0.0.into())], |_, _| Ok(())).unwrap_err();
/// assert_eq!(refused.to_string(), "speed is 0.0, must be a number from 0.01 to 100");
/// # Ok::<(), handover_mesh::parameters::Refusals>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterTable {
    parameters: Vec<Parameter>,
}

impl ParameterTable {
    /// A table.
    ///
    /// # Panics
    /// If two have one name, or one may not be what it is.
    pub fn new(parameters: Vec<Parameter>) -> Self {
        for (at, parameter) in parameters.iter().enumerate() {
            let name = &parameter.name;
            let is_new = parameters[..at].iter().all(|other| other.name != *name);
            assert!(is_new, "two parameters are called {name}");
            let accepted = parameter.accept(&parameter.value);
            assert!(accepted.as_ref() == Ok(&parameter.value), "{accepted:?}");
        }
        Self { parameters }
    }

    /// All of them.
    pub fn all(&self) -> &[Parameter] {
        &self.parameters
    }

    /// One of them.
    pub fn get(&self, name: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// A parameter's value.
    ///
    /// # Panics
    /// If there is none of this name.
    pub fn value(&self, name: &str) -> &ParameterValue {
        match self.get(name) {
            Some(parameter) => &parameter.value,
            None => panic!("no parameter is called {name}"),
        }
    }

    /// The number that a parameter is.
    ///
    /// # Panics
    /// If there is none of this name, or it is no number.
    pub fn number(&self, name: &str) -> f64 {
        self.value(name).numbers()[0]
    }

    /// The whole number that a parameter is.
    ///
    /// # Panics
    /// If there is none of this name, or it is no whole number.
    pub fn whole(&self, name: &str) -> i64 {
        self.value(name).whole()[0]
    }

    /// The text that a parameter is.
    ///
    /// # Panics
    /// If there is none of this name, or it is no text.
    pub fn text(&self, name: &str) -> &str {
        &self.value(name).texts()[0]
    }

    /// Whether a parameter is true.
    ///
    /// # Panics
    /// If there is none of this name.
    pub fn is_true(&self, name: &str) -> bool {
        self.value(name).is_true()
    }

    /// Takes what a node is started with, read-only ones too.
    ///
    /// # Errors
    /// [`Refusals`] names every unknown name and every value that may not be; then all stays.
    pub fn start(
        &mut self,
        given: impl IntoIterator<Item = (String, ParameterValue)>,
    ) -> Result<(), Refusals> {
        let accept = |(name, value): (String, ParameterValue)| {
            let value = self.known(&name)?.accept(&value)?;
            Ok((name, value))
        };
        let (mut accepted, mut refusals) = (Vec::new(), Vec::new());
        for given in given {
            match accept(given) {
                Ok(given) => accepted.push(given),
                Err(refusal) => refusals.push(refusal),
            }
        }
        if !refusals.is_empty() {
            return Err(Refusals(refusals));
        }
        self.take(&accepted);
        Ok(())
    }

    /// Changes some parameters together, or none of them.
    ///
    /// - `may_set`: asked at last, with the table as it is and the values as they will be; what it says
    ///   is the reason.
    ///
    /// Returns what has changed, without what was so before.
    ///
    /// # Errors
    /// The first [`Refusal`].
    pub fn set(
        &mut self,
        changes: &[(String, ParameterValue)],
        may_set: impl FnOnce(&Self, &[(String, ParameterValue)]) -> Result<(), String>,
    ) -> Result<Vec<(String, ParameterValue)>, Refusal> {
        let accept = |(name, value): &(String, ParameterValue)| {
            let parameter = self.known(name)?;
            if let Some(reason) = parameter.read_only.clone() {
                return Err(Refusal::ReadOnly { name: name.clone(), reason });
            }
            if *value == ParameterValue::NotSet {
                return Err(Refusal::Removed { name: name.clone() });
            }
            Ok((name.clone(), parameter.accept(value)?))
        };
        let mut accepted: Vec<_> = changes.iter().map(accept).collect::<Result<_, _>>()?;
        accepted.retain(|(name, value)| self.value(name) != value);
        if !accepted.is_empty() {
            may_set(self, &accepted).map_err(Refusal::Owner)?;
        }
        self.take(&accepted);
        Ok(accepted)
    }

    /// The parameters in some sections.
    ///
    /// - `prefixes`: sections or whole names; empty for all.
    /// - `depth`: how many levels below them, 0 for all.
    pub fn list(&self, prefixes: &[String], depth: u64) -> Listed {
        let is_near = |below: &str| depth == 0 || (below.matches('.').count() as u64) < depth;
        let is_below = |name: &str, prefix: &String| {
            let below = name.strip_prefix(prefix.as_str());
            let below = below.and_then(|rest| rest.strip_prefix('.'));
            name == prefix || below.is_some_and(is_near)
        };
        let mut listed = Listed::default();
        for name in self.parameters.iter().map(|parameter| parameter.name.as_str()) {
            let wanted = if prefixes.is_empty() {
                is_near(name)
            } else {
                prefixes.iter().any(|prefix| is_below(name, prefix))
            };
            if !wanted {
                continue;
            }
            listed.names.push(name.to_owned());
            if let Some((section, _)) = name.rsplit_once('.') {
                let section = section.to_owned();
                if !listed.prefixes.contains(&section) {
                    listed.prefixes.push(section);
                }
            }
        }
        listed
    }

    fn known(&self, name: &str) -> Result<&Parameter, Refusal> {
        self.get(name).ok_or_else(|| {
            let name = name.to_owned();
            Refusal::Unknown { siblings: self.siblings(&name), name }
        })
    }

    /// What somebody who mistyped a name may have meant.
    fn siblings(&self, name: &str) -> Vec<String> {
        let section = name.rsplit_once('.').map(|(section, _)| section.to_owned());
        let siblings = self.list(section.as_slice(), 1).names;
        if section.is_some() && !siblings.is_empty() {
            return siblings;
        }
        let mut names: Vec<String> = Vec::new();
        for Parameter { name, .. } in &self.parameters {
            let name =
                name.split_once('.').map_or(name.clone(), |(section, _)| format!("{section}.*"));
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    fn take(&mut self, accepted: &[(String, ParameterValue)]) {
        for (name, value) in accepted {
            let parameter = self.parameters.iter_mut().find(|parameter| parameter.name == *name);
            if let Some(parameter) = parameter {
                parameter.value = value.clone();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> ParameterTable {
        ParameterTable::new(vec![
            Parameter::new("speed", 1.0, "").numbers(0.1, 10.0),
            Parameter::new("loop", false, ""),
            Parameter::new("sensor.rate", 30.0, "").read_only("the sensor is made at the start"),
            Parameter::new("sensor.noise.depth", 0.0, ""),
        ])
    }

    fn given(values: &[(&str, ParameterValue)]) -> Vec<(String, ParameterValue)> {
        values.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect()
    }

    #[test]
    fn all_that_is_wrong_at_the_start_is_named_and_nothing_is_taken() {
        let mut table = table();
        let wrong = given(&[
            ("speed", 11.into()),
            ("loop", true.into()),
            ("sensor.colour", 1.into()),
            ("sped", 1.into()),
        ]);
        let expected = "speed is 11, must be a number from 0.1 to 10\n\
            sensor.colour is no parameter; there are sensor.rate\n\
            sped is no parameter; there are speed, loop, sensor.*";
        assert_eq!(table.start(wrong).unwrap_err().to_string(), expected);
        assert!(!table.is_true("loop"));
        table.start(given(&[("sensor.rate", 15.into()), ("loop", true.into())])).unwrap();
        assert!(table.is_true("loop") && table.number("sensor.rate") == 15.0);
    }

    #[test]
    fn changes_come_together_or_not_at_all() {
        let mut table = table();
        let read_only = given(&[("loop", true.into()), ("sensor.rate", 15.0.into())]);
        let refusal = table.set(&read_only, |_, _| Ok(())).unwrap_err().to_string();
        let expected = "sensor.rate cannot be changed while the node runs: the sensor is made at \
            the start";
        assert_eq!((refusal.as_str(), table.is_true("loop")), (expected, false));
        let both = given(&[("loop", true.into()), ("speed", 2.into())]);
        let refusal = table.set(&both, |_, _| Err("not while active".to_owned())).unwrap_err();
        assert_eq!(
            (refusal.to_string().as_str(), table.number("speed")),
            ("not while active", 1.0)
        );
        let changed = given(&[("loop", true.into()), ("speed", 2.0.into())]);
        let asked = |_: &_, asked: &[(String, ParameterValue)]| {
            assert_eq!(asked, changed);
            Ok(())
        };
        assert_eq!(table.set(&both, asked), Ok(changed.clone()));
        let nobody = |_: &_, _: &[_]| panic!("nothing changes");
        assert_eq!(table.set(&both, nobody), Ok(Vec::new()));
        let removed = given(&[("speed", ParameterValue::NotSet)]);
        let refusal = table.set(&removed, |_, _| Ok(())).unwrap_err();
        assert_eq!(refusal.to_string(), "speed cannot be removed");
    }

    #[test]
    fn lists_go_by_prefix_and_depth() {
        let check = |prefixes: &[&str], depth, names: &[&str], sections: &[&str]| {
            let prefixes: Vec<String> = prefixes.iter().map(|p| (*p).to_owned()).collect();
            let listed = table().list(&prefixes, depth);
            assert_eq!((listed.names, listed.prefixes), (owned(names), owned(sections)));
        };
        fn owned(names: &[&str]) -> Vec<String> {
            names.iter().map(|name| (*name).to_owned()).collect()
        }
        let all = ["speed", "loop", "sensor.rate", "sensor.noise.depth"];
        check(&[], 0, &all, &["sensor", "sensor.noise"]);
        check(&[], 1, &["speed", "loop"], &[]);
        check(&[], 2, &["speed", "loop", "sensor.rate"], &["sensor"]);
        check(&["sensor"], 1, &["sensor.rate"], &["sensor"]);
        check(&["sensor", "loop"], 0, &all[1..], &["sensor", "sensor.noise"]);
        check(&["sen", "lo"], 0, &[], &[]);
    }

    #[test]
    #[should_panic(expected = "two parameters are called a")]
    fn a_name_is_declared_once() {
        let _ = ParameterTable::new(vec![Parameter::new("a", 1, ""), Parameter::new("a", 1, "")]);
    }
}
