//! `--config` and `--set` → parameters.

use std::fs;
use std::path::Path;

use anyhow::Context as _;
use handover_mesh::{Config, ConfigError};

use crate::UsageError;
use crate::args::Global;

/// Reads the parameter file, if one is named, the settings over it, and over these the options
/// that stand for a parameter.
///
/// # Errors
/// [`UsageError`] with every violation, or that the file cannot be read.
pub(crate) fn load(global: &Global, options: &[(String, String)]) -> anyhow::Result<Config> {
    let settings: Vec<_> = global.set.iter().chain(options).cloned().collect();
    let (yaml, source) = file(global)?;
    Config::from_yaml(&yaml, &settings).map_err(|error| violation(&source, &error))
}

/// A model's parameters, with those given over them. Given may be anything that the model has the
/// same, and of those of the robot whatever the robot is to do.
///
/// # Errors
/// [`UsageError`] with every violation, or every key that is not the robot's.
pub(crate) fn over(model: &Config, path: &Path, global: &Global) -> anyhow::Result<Config> {
    let (yaml, source) = file(global)?;
    let given = model.with(&yaml, &global.set);
    let (config, changes) = given.map_err(|error| violation(&source, &error))?;
    let others = changes.iter().filter(|change| !Config::is_of_the_robot(&change.key));
    let others: Vec<String> = others
        .map(|other| format!("{} is {}, not {}", other.key, other.default, other.value))
        .collect();
    if others.is_empty() {
        return Ok(config);
    }
    Err(UsageError(format!(
        "{}: a model has its own parameters, there {}; --config and --set go with it for {} only",
        path.display(),
        others.join(", "),
        Config::OF_THE_ROBOT.join(", "),
    ))
    .into())
}

/// The parameter file's text, or none, and what is to blame for it.
fn file(global: &Global) -> anyhow::Result<(String, String)> {
    let Some(path) = &global.config else { return Ok((String::new(), "--set".to_owned())) };
    let shown = path.display();
    let text = fs::read_to_string(path).with_context(|| format!("cannot read {shown}"))?;
    Ok((text, shown.to_string()))
}

fn violation(source: &str, error: &ConfigError) -> anyhow::Error {
    UsageError(format!("{source}: {error}")).into()
}
