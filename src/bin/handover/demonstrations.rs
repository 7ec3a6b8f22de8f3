//! Files named on the command line → demonstrations of one role by one kind of pair.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::bail;
use handover_mesh::demonstration::Demonstration;
use handover_mesh::mesh::Pair;
use handover_mesh::{Config, Recording};

use crate::UsageError;
use crate::args::Selection;
use crate::files;
use crate::output::Output;

/// Roles a robot takes where none is named, the first one that the recordings have.
const DEFAULT_ROLES: [&str; 2] = ["giver", "B"];

/// Demonstrations, and how many recordings were left out (each has been named).
pub(crate) struct Loaded {
    pub(crate) demonstrations: Vec<Arc<Demonstration>>,
    /// SHA-256 of the file of each demonstration: 64 hexadecimal digits.
    pub(crate) hashes: Vec<String>,
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
    let read = files::load(paths, selection, output)?;
    take(once(read, output), role, config, output)
}

/// The same in an order that is not that of the arguments: by name.
///
/// # Errors
/// As [`load`].
pub(crate) fn load_sorted(
    paths: &[PathBuf],
    role: Option<&str>,
    selection: &Selection,
    config: &Config,
    output: &Output,
) -> anyhow::Result<Loaded> {
    let mut read = files::load(paths, selection, output)?;
    let order =
        |loaded: &files::Loaded| (loaded.recording.name().to_owned(), loaded.sha256.clone());
    read.recordings.sort_by_cached_key(order);
    take(once(read, output), role, config, output)
}

/// Of recordings that hold the same only the first, as one must not learn from itself: that is no
/// loss.
fn once(read: files::Demonstrations, output: &Output) -> files::Demonstrations {
    let mut once: Vec<files::Loaded> = Vec::new();
    for loaded in read.recordings {
        let same = |known: &&files::Loaded| {
            known.sha256 == loaded.sha256 || known.recording.people() == loaded.recording.people()
        };
        if let Some(known) = once.iter().find(same) {
            let (name, known) = (loaded.recording.name(), known.recording.name());
            output.note(&format!("left out: {name} holds the same as {known}"));
        } else {
            once.push(loaded);
        }
    }
    files::Demonstrations { recordings: once, ..read }
}

fn take(
    read: files::Demonstrations,
    role: Option<&str>,
    config: &Config,
    output: &Output,
) -> anyhow::Result<Loaded> {
    let files::Demonstrations { recordings, bad, first_is_bad } = read;
    files::name_bad(&bad, output);
    let mut left_out = bad.len();
    if recordings.is_empty() {
        bail!("no recording is left to work with");
    }
    let role = match role {
        Some(role) => role.to_owned(),
        None => default_role(recordings.iter().map(|loaded| &loaded.recording))?,
    };
    let first = recordings[0].recording.name().to_owned();
    let mut taken: Vec<(Arc<Demonstration>, String)> = Vec::new();
    let mut leave_out = |why: String| {
        output.problem(&format!("left out: {why}"));
        left_out += 1;
    };
    for files::Loaded { recording, sha256, .. } in recordings {
        match Demonstration::new(Arc::new(recording), &role, &config.base_joint) {
            Ok(demonstration) => taken.push((Arc::new(demonstration), sha256)),
            Err(error) => leave_out(error.to_string()),
        }
    }
    let kind = |d: &Demonstration| (d.robot_role(), Pair::of(d.recording()));
    if let Some(usual) = most_common(taken.iter().map(|(d, _)| kind(d))) {
        taken.retain(|(demonstration, _)| {
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
    if taken.is_empty() {
        bail!("no recording is left to work with");
    }
    // Names are distinct.
    let first_left_out = first_is_bad || taken[0].0.recording().name() != first;
    let (demonstrations, hashes) = taken.into_iter().unzip();
    Ok(Loaded { demonstrations, hashes, role, left_out, first_left_out })
}

/// Who never learns from whom: recordings of one scene, and those that have a metadata key's value
/// in common. Returns each one's group, named by the first of its values.
///
/// # Errors
/// [`UsageError`] if a recording lacks the key.
pub(crate) fn groups(
    demonstrations: &[Arc<Demonstration>],
    key: Option<&str>,
) -> anyhow::Result<Vec<String>> {
    let scene = |d: &Arc<Demonstration>| d.recording().scene().to_owned();
    let value = |demonstration: &Arc<Demonstration>| {
        let recording = demonstration.recording();
        let Some(key) = key else { return Ok(recording.scene().to_owned()) };
        let Some(group) = recording.metadata().get(key) else {
            bail!(UsageError(format!(
                "{}: no metadata '{key}' to group by (hint: a CSV says it in a line '# {key}=…' \
                 above its header)",
                recording.name()
            )));
        };
        Ok(group.clone())
    };
    let mut groups: Vec<String> =
        demonstrations.iter().map(value).collect::<anyhow::Result<_>>()?;
    // A scene that several groups show makes one of them.
    let mut of_scene: BTreeMap<String, String> = BTreeMap::new();
    for at in 0..groups.len() {
        let here = groups[at].clone();
        let first = of_scene.entry(scene(&demonstrations[at])).or_insert_with(|| here.clone());
        if *first != here {
            let one = first.clone();
            groups.iter_mut().filter(|group| **group == here).for_each(|g| g.clone_from(&one));
            of_scene.values_mut().filter(|group| **group == here).for_each(|g| g.clone_from(&one));
        }
    }
    Ok(groups)
}

/// The value that occurs most often, the first of equals; `None` of nothing.
pub(crate) fn most_common<T: PartialEq>(values: impl Iterator<Item = T>) -> Option<T> {
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

/// The role a robot takes where none is named.
///
/// # Errors
/// If no recording has it.
pub(crate) fn default_role<'a>(
    recordings: impl Iterator<Item = &'a Recording> + Clone,
) -> anyhow::Result<String> {
    let has = |role: &&str| recordings.clone().any(|recording| recording.role(role).is_some());
    let Some(role) = DEFAULT_ROLES.iter().find(|role| has(role)) else {
        let people = recordings.clone().next().map(Recording::people);
        let names: Vec<&str> = people.into_iter().flatten().map(|p| p.name.as_str()).collect();
        bail!("which person is the robot? name one with --role: {}", names.join(" or "));
    };
    Ok((*role).to_owned())
}
