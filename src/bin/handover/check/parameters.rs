//! Parameter files: what differs from the defaults, or all that is wrong.

use std::path::{Path, PathBuf};

use handover_mesh::config::{Change, Config, ConfigError};
use serde_json::{Value, json};

use super::{bad_text, bad_value};
use crate::files::{self, Fault};

/// A parameter file and what came of reading it.
pub(super) struct ParameterFile {
    path: PathBuf,
    pub(super) outcome: Result<Vec<Change>, Vec<Fault>>,
}

/// Whether a file's ending says that it holds parameters.
pub(super) fn is_named_so(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "yaml" || ending == "yml")
}

impl ParameterFile {
    /// # Errors
    /// If there is no such file; a bad one is no error.
    pub(super) fn read(path: PathBuf) -> anyhow::Result<Self> {
        files::about(&path)?;
        let changes = |text: String| Config::changes(&text).map_err(faults);
        let outcome = files::text(&path).and_then(changes);
        Ok(Self { path, outcome })
    }

    pub(super) fn text(&self) -> String {
        let changes = match &self.outcome {
            Ok(changes) => changes,
            Err(faults) => return bad_text(&self.path, faults),
        };
        let lines = changes.iter().map(|change| {
            format!("  {} is {}, by default {}\n", change.key, change.value, change.default)
        });
        let count = match changes.len() {
            0 => "all as by default".to_owned(),
            count => format!("{count} not as by default"),
        };
        format!("{}: parameters, {count}\n{}", self.path.display(), lines.collect::<String>())
    }

    pub(super) fn json(&self) -> Value {
        let changes = match &self.outcome {
            Ok(changes) => changes,
            Err(faults) => return bad_value(&self.path, faults),
        };
        let changes = changes.iter().map(
            |change| json!({ "key": change.key, "value": change.value, "default": change.default }),
        );
        json!({
            "file": self.path.display().to_string(),
            "good": true,
            "errors": [],
            "format": "parameters",
            "changes": changes.collect::<Vec<_>>(),
        })
    }
}

fn faults(error: ConfigError) -> Vec<Fault> {
    match error {
        ConfigError::Violations(all) => {
            all.into_iter().map(|v| Fault::of_file(format!("{} {}", v.key, v.problem))).collect()
        }
        other => vec![Fault::of_file(other.to_string())],
    }
}
