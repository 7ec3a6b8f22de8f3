//! Files named on the command line → demonstrations of one role by one kind of pair.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::bail;
use handover_mesh::demonstration::{Demonstration, with_object_carried};
use handover_mesh::formats::bag;
use handover_mesh::mesh::Pair;
use handover_mesh::skeleton::joint_differences;
use handover_mesh::{Config, Person, Recording, Role};

use crate::UsageError;
use crate::args::Selection;
use crate::check::duration;
use crate::files;
use crate::output::{Output, counted};

/// Roles a robot takes where none is named, the first one that the recordings have.
const DEFAULT_ROLES: [&str; 2] = ["giver", "B"];

/// The least that may be an interaction: who comes, reaches and withdraws takes longer `[s]`, and is
/// seen more often. A shorter recording would spoil every mean that it is in.
const SHORTEST: f64 = 0.5;
const FEWEST_FRAMES: usize = 5;

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
    take(once(read, output), role, selection.any_length, config, output)
}

/// The same; of what a robot recorded live, the robot plays `role` and its partner the other one of
/// `people`.
///
/// # Errors
/// As [`load`].
pub(crate) fn load_live(
    paths: &[PathBuf],
    people: [&str; 2],
    role: &str,
    selection: &Selection,
    config: &Config,
    output: &Output,
) -> anyhow::Result<Loaded> {
    let mut read = files::load(paths, selection, output)?;
    for loaded in &mut read.recordings {
        if let Some(played) = played(&loaded.recording, people, role) {
            let path = loaded.path.display();
            output.note(&format!("{path}: recorded live, the robot is taken for the {role}"));
            loaded.recording = played;
        }
    }
    take(once(read, output), Some(role), selection.any_length, config, output)
}

/// The recording with the robot in its role; `None` if it is not of a robot and its partner.
fn played(recording: &Recording, people: [&str; 2], role: &str) -> Option<Recording> {
    let robot = recording.person(recording.role(bag::ROBOT)?);
    let partner = recording.person(recording.role(bag::PARTNER)?);
    let people = people.map(|name| {
        let played = if name == role { robot } else { partner };
        Person { name: name.to_owned(), motion: played.motion.clone() }
    });
    let (name, metadata) = (recording.name(), recording.metadata().clone());
    Recording::new(name, people, recording.object().cloned(), metadata).ok()
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
    take(once(read, output), role, selection.any_length, config, output)
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

/// A demonstration and its file.
struct Taken {
    path: PathBuf,
    demonstration: Arc<Demonstration>,
    sha256: String,
}

impl Taken {
    /// What has to be the same in all.
    fn kind(&self) -> (Role, Pair) {
        (self.demonstration.robot_role(), Pair::of(self.demonstration.recording()))
    }

    /// Why it is of another kind than most, if it is.
    fn differs(&self, (role, usual): &(Role, Pair)) -> Option<String> {
        if self.demonstration.robot_role() != *role {
            return Some("names its people in another order than most".to_owned());
        }
        let people = [Role::First, Role::Second].map(|role| {
            let person = self.demonstration.recording().person(role);
            (person.name.as_str(), &**person.motion.skeleton(), &**usual.skeleton(role))
        });
        Some(format!("other joints than in most: {}", joint_differences(people)?))
    }
}

fn take(
    read: files::Demonstrations,
    role: Option<&str>,
    any_length: bool,
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
    let mut taken: Vec<Taken> = Vec::new();
    let mut leave_out = |path: &Path, why: &str| {
        output.problem(&format!("left out: {}: {why}", path.display()));
        left_out += 1;
    };
    for files::Loaded { path, recording, sha256, .. } in recordings {
        let (frames, seconds) = (recording.len(), duration(&recording));
        // Stamps are rounded.
        let is_short = frames < FEWEST_FRAMES || seconds + 0.001 < SHORTEST;
        if is_short && !any_length {
            let frames = counted(frames, "frame");
            leave_out(
                &path,
                &format!(
                    "{frames} in {seconds:.2} s, no interaction: at least {FEWEST_FRAMES} frames in \
                 {SHORTEST} s are"
                ),
            );
            continue;
        }
        let recording = if config.object.attach {
            match with_object_carried(&recording, config.object.points) {
                Ok(with_object) => with_object,
                Err(error) => {
                    leave_out(&path, &format!("object.attach: {error}"));
                    continue;
                }
            }
        } else {
            recording
        };
        let name = format!("{}: ", recording.name());
        match Demonstration::new(Arc::new(recording), &role, &config.base_joint) {
            Ok(demonstration) => {
                taken.push(Taken { path, demonstration: Arc::new(demonstration), sha256 });
            }
            // The file is named already.
            Err(error) => {
                let why = error.to_string();
                leave_out(&path, why.strip_prefix(&name).unwrap_or(&why));
            }
        }
    }
    if let Some(usual) = most_common(taken.iter().map(Taken::kind)) {
        taken.retain(|taken| {
            let why = taken.differs(&usual);
            if let Some(why) = &why {
                leave_out(&taken.path, why);
            }
            why.is_none()
        });
    }
    if taken.is_empty() {
        bail!("no recording is left to work with");
    }
    // Names are distinct.
    let first_left_out = first_is_bad || taken[0].demonstration.recording().name() != first;
    let taken = taken.into_iter().map(|taken| (taken.demonstration, taken.sha256));
    let (demonstrations, hashes) = taken.unzip();
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
