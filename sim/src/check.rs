//! Parameters out of range, all of them together.

use std::fmt;
use std::ops::RangeInclusive;

/// One parameter out of its range.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// The parameter: its field's name, with dots for nested ones.
    pub key: String,
    /// What was given.
    pub value: f64,
    /// The range it should lie in, ends included, and its unit.
    pub bound: String,
}

/// Every parameter out of its range: at least one.
#[derive(Debug, Clone, PartialEq)]
pub struct Violations(Vec<Violation>);

impl Violations {
    /// All of them, in the order of the parameters.
    pub fn all(&self) -> &[Violation] {
        &self.0
    }
}

impl fmt::Display for Violations {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, Violation { key, value, bound }) in self.0.iter().enumerate() {
            let separator = if at == 0 { "" } else { "; " };
            write!(f, "{separator}{key} is {value}, must be in {bound}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Violations {}

/// Collects violations while a configuration is gone through.
#[derive(Default)]
pub(crate) struct Check(Vec<Violation>);

impl Check {
    /// Notes `value` if it is not in `range` (NaN is in none).
    pub(crate) fn range(
        &mut self,
        key: impl Into<String>,
        value: f64,
        range: RangeInclusive<f64>,
        unit: &str,
    ) {
        if !range.contains(&value) {
            let bound = format!("[{}, {}] {unit}", range.start(), range.end());
            self.0.push(Violation { key: key.into(), value, bound: bound.trim_end().into() });
        }
    }

    /// What was noted.
    pub(crate) fn finish(self) -> Result<(), Violations> {
        if self.0.is_empty() { Ok(()) } else { Err(Violations(self.0)) }
    }
}
