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
    /// Whether the very first recording is one of those left out.
    pub(crate) first_left_out: bool,
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
    let files::Demonstrations { recordings, bad, first_is_bad } =
        files::load(paths, selection, output)?;
    files::name_bad(&bad, output);
    let mut left_out = bad.len();
    if recordings.is_empty() {
        bail!("no recording is left to work with");
    }
    let role = match role {
        Some(role) => role.to_owned(),
        None => default_role(&recordings)?,
    };
    let first = recordings[0].name().to_owned();
    let mut demonstrations: Vec<Arc<Demonstration>> = Vec::new();
    let mut leave_out = |why: String| {
        output.problem(&format!("left out: {why}"));
        left_out += 1;
    };
    for recording in recordings {
        match Demonstration::new(Arc::new(recording), &role, &config.base_joint) {
            Ok(demonstration) => demonstrations.push(Arc::new(demonstration)),
            Err(error) => leave_out(error.to_string()),
        }
    }
    let kind = |d: &Demonstration| (d.robot_role(), Pair::of(d.recording()));
    if let Some(usual) = most_common(demonstrations.iter().map(|d| kind(d))) {
        demonstrations.retain(|demonstration| {
            let same = kind(demonstration) == usual;
            if !same {
                let name = demonstration.recording().name();
                leave_out(format!(
                    "{name}: has other joints, or people in another order, than most"
                ));
            }
            same
        });
    }
    if demonstrations.is_empty() {
        bail!("no recording is left to work with");
    }
    // Names are distinct.
    let first_left_out = first_is_bad || demonstrations[0].recording().name() != first;
    Ok(Loaded { demonstrations, role, left_out, first_left_out })
}

/// The value that occurs most often, the first of equals; `None` of nothing.
fn most_common<T: PartialEq>(values: impl Iterator<Item = T>) -> Option<T> {
    let mut counts: Vec<(T, usize)> = Vec::new();
    for value in values {
        match counts.iter_mut().find(|(known, _)| *known == value) {
            Some((_, count)) => *count += 1,
            None => counts.push((value, 1)),
        }
    }
    // `max_by_key` would take the last of equals.
    counts
        .into_iter()
        .reduce(|best, next| if next.1 > best.1 { next } else { best })
        .map(|(v, _)| v)
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
