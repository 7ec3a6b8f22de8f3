//! `--config` and `--set` → parameters.

use std::fs;

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
    let (yaml, source) = match &global.config {
        Some(path) => {
            let text = fs::read_to_string(path)
                .with_context(|| format!("cannot read {}", path.display()))?;
            (text, path.display().to_string())
        }
        None => (String::new(), "--set".to_owned()),
    };
    let text = |error: ConfigError| UsageError(format!("{source}: {error}"));
    let settings: Vec<_> = global.set.iter().chain(options).cloned().collect();
    Config::from_yaml(&yaml, &settings).map_err(|error| text(error).into())
}
