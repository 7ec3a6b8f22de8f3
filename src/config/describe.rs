//! What each parameter is: its kind with its bounds, from the code that takes it, and what it means,
//! from the comments of the shipped file.

use std::collections::BTreeMap;

use serde_json::Value;

/// The shipped parameter file: every key with its default and its meaning.
const SHIPPED: &str = include_str!("../../config/handover.yaml");

/// What values a parameter takes.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// Yes or no.
    Flag,
    /// A number between two bounds, both included.
    Real {
        /// The least.
        low: f64,
        /// The most.
        high: f64,
    },
    /// A whole number between two bounds, both included.
    Whole {
        /// The least.
        low: i64,
        /// The most.
        high: i64,
    },
    /// Text.
    Text,
    /// One of some words.
    Choice(Vec<&'static str>),
    /// A list of numbers.
    Reals,
    /// A list of texts.
    Texts,
}

/// A parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Its key, dotted.
    pub key: String,
    /// What values it takes.
    pub kind: Kind,
    /// What it is now.
    pub value: Value,
    /// What it means, with its unit and range, as the shipped file says; keys that stand together
    /// there have their text together.
    pub description: String,
}

/// Every key of the shipped file with its text: the comment lines above the group of keys it stands
/// in, then the comment behind it.
pub(super) fn descriptions() -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let (mut section, mut above, mut in_comment) = (String::new(), String::new(), false);
    for line in SHIPPED.lines() {
        let (indent, text) = (line.len() - line.trim_start().len(), line.trim());
        if let Some(comment) = text.strip_prefix('#') {
            if !in_comment {
                above.clear();
            }
            in_comment = true;
            append(&mut above, comment);
            continue;
        }
        in_comment = false;
        let Some((key, value)) = text.split_once(':') else { continue };
        match indent {
            4 => {
                section = key.to_owned();
                above.clear();
            }
            6 => {
                let mut description = above.clone();
                if let Some((_, behind)) = value.split_once(" #") {
                    append(&mut description, behind);
                }
                found.insert(format!("{section}.{key}"), description);
            }
            _ => {}
        }
    }
    found
}

fn append(text: &mut String, more: &str) {
    if !text.is_empty() {
        text.push(' ');
    }
    text.push_str(more.trim());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_above_and_behind_are_a_keys_text() {
        let found = descriptions();
        assert_eq!(
            found["robot.base_joint"],
            "Joint by which a person's place is known; a skeleton without it uses its root."
        );
        assert!(found["mesh.reference_distance"].ends_with("[m], 0.001 to 10"));
        assert!(found["safety.jerk"].starts_with("Not safety-rated. Speed [m/s], 0.01 to 10"));
        assert!(found.values().all(|text| text.len() > 8), "{found:?}");
    }
}
