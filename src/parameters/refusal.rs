//! Why a parameter does not become what somebody wants it to be.

use std::fmt;

/// One parameter that stays as it is.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// There is none of this name.
    #[error("{name} is no parameter{}", hint(.siblings))]
    Unknown {
        /// The name, dotted.
        name: String,
        /// Those of the same section; of no section, the sections and names there are.
        siblings: Vec<String>,
    },
    /// Of another kind, or out of bounds.
    #[error("{name} is {value}, must be {allowed}")]
    Value {
        /// The name, dotted.
        name: String,
        /// What it should have become.
        value: String,
        /// What it may be.
        allowed: String,
    },
    /// It is taken at the start.
    #[error("{name} cannot be changed while the node runs: {reason}")]
    ReadOnly {
        /// The name, dotted.
        name: String,
        /// Why.
        reason: String,
    },
    /// Parameters are never taken away.
    #[error("{name} cannot be removed")]
    Removed {
        /// The name, dotted.
        name: String,
    },
    /// The node does not want it now.
    #[error("{0}")]
    Owner(String),
}

fn hint(siblings: &[String]) -> String {
    if siblings.is_empty() { String::new() } else { format!("; there are {}", siblings.join(", ")) }
}

/// All refusals of some parameters: at least one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusals(pub Vec<Refusal>);

impl fmt::Display for Refusals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lines: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        write!(f, "{}", lines.join("\n"))
    }
}

impl std::error::Error for Refusals {}
