//! Files named on the command line → demonstrations of one role by one kind of pair.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::bail;
use handover_mesh::demonstration::Demonstration;
use handover_mesh::mesh::Pair;
use handover_mesh::{Config, Recording};

use crate::args::Selection;
use crate::files;
use crate::output::Output;

/// Roles a robot takes where none is named, the first one that the recordings have.
const DEFAULT_ROLES: [&str; 2] = ["giver", "B"];

/// Demonstrations, and how many recordings were left out (each has been named).
pub(crate) struct Loaded {
    pub(crate) demonstrations: Vec<Arc<Demonstration>>,
    pub(crate) role: String,
    pub(crate) left_out: usize,
}

/// Loads recordings and takes `role` in each; names on stderr what has to be left out.
///
/// # Errors
/// If nothing remains.
pub(crate) fn load(
    paths: &[PathBuf],
    role: Option<&str>,
    selection: &Selection,
    config: &Config,
    output: &Output,
) -> anyhow::Result<Loaded> {
    let files::Demonstrations { recordings, bad } = files::load(paths, selection, output)?;
    files::name_bad(&bad, output);
    let mut left_out = bad.len();
    let role = match role {
        Some(role) => role.to_owned(),
        None => default_role(&recordings)?,
    };
    let mut demonstrations: Vec<Arc<Demonstration>> = Vec::new();
    for recording in recordings {
        match demonstration(recording, &role, demonstrations.first(), config) {
            Ok(demonstration) => demonstrations.push(Arc::new(demonstration)),
            Err(error) => {
                output.problem(&format!("left out: {error:#}"));
                left_out += 1;
            }
        }
    }
    if demonstrations.is_empty() {
        bail!("no recording is left to work with");
    }
    Ok(Loaded { demonstrations, role, left_out })
}

/// The role in one recording, of the same kind as the first.
fn demonstration(
    recording: Recording,
    role: &str,
    first: Option<&Arc<Demonstration>>,
    config: &Config,
) -> anyhow::Result<Demonstration> {
    let demonstration = Demonstration::new(Arc::new(recording), role, &config.base_joint)?;
    if let Some(first) = first {
        let (name, other) = (demonstration.recording().name(), first.recording().name());
        if demonstration.robot_role() != first.robot_role() {
            bail!("{name}: names its people in another order than {other}");
        }
        if Pair::of(demonstration.recording()) != Pair::of(first.recording()) {
            bail!("{name}: has other joints than {other}");
        }
    }
    Ok(demonstration)
}

fn default_role(recordings: &[Recording]) -> anyhow::Result<String> {
    let has = |role: &&str| recordings.iter().any(|recording| recording.role(role).is_some());
    let Some(role) = DEFAULT_ROLES.iter().find(|role| has(role)) else {
        let names: Vec<&str> = recordings
            .first()
            .map(|recording| recording.people().iter().map(|p| p.name.as_str()).collect())
            .unwrap_or_default();
        bail!("which person is the robot? name one with --role: {}", names.join(" or "));
    };
    Ok((*role).to_owned())
}
