//! Arguments → files, in a fixed order.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};

use super::{Fault, bag};
use crate::args::Selection;

/// Endings of files that may be recordings.
pub(super) const RECORDINGS: &[&str] = &["csv", "txt", "mcap", "db3", "zstd"];
/// Endings of files that may hold somebody's motion: recordings, and one person's joint angles.
pub(super) const MOTIONS: &[&str] = &["csv", "txt", "mcap", "db3", "zstd", "amc"];
/// No tree of recordings is as deep.
const DEEPEST: usize = 64;

/// A file to read, or a place that could not be looked at.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) path: PathBuf,
    pub(super) fault: Option<Fault>,
}

/// The files that the arguments name, and those in the folders they name; each once.
///
/// - `endings`: of the files that a folder is searched for.
pub(super) fn find(
    arguments: &[PathBuf],
    selection: &Selection,
    endings: &[&str],
) -> anyhow::Result<Vec<Found>> {
    let mut found = Vec::new();
    for argument in arguments {
        let about = about(argument)?;
        let mut here = Vec::new();
        if about.is_dir() && !bag::is_bag(argument) {
            search(argument, 0, endings, &mut here);
            here.retain(|file| matches(file, argument, selection));
            if here.is_empty() {
                let which = if selection.filter.is_some() { " matches the filter" } else { "" };
                bail!("{}: no recording ({}){which}", argument.display(), listed(endings));
            }
        } else {
            here.push(Found { path: argument.clone(), fault: None });
        }
        found.append(&mut here);
    }
    let place = |path: &Path| fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let except = selection.except.as_deref().map(place);
    // Of several paths to one file the least names it, whichever comes first.
    let spelled = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut least: BTreeMap<PathBuf, PathBuf> = BTreeMap::new();
    for file in &found {
        let spelled = spelled(&file.path);
        let known = least.entry(place(&file.path)).or_insert_with(|| spelled.clone());
        *known = spelled.min(known.clone());
    }
    let mut seen = BTreeSet::new();
    // The same demonstration twice would be its own neighbour in a cross-validation.
    found.retain(|file| {
        let place = place(&file.path);
        let is_least = least.get(&place).is_none_or(|least| *least == spelled(&file.path));
        except.as_ref() != Some(&place) && is_least && seen.insert(place)
    });
    if let Some(except) = selection.except.as_deref().filter(|_| found.is_empty()) {
        bail!("a recording does not learn from itself, and there is none but {}", except.display());
    }
    Ok(found)
}

/// What kind of thing the path names.
pub(crate) fn about(path: &Path) -> anyhow::Result<fs::Metadata> {
    fs::metadata(path).or_else(|error| match error.kind() {
        io::ErrorKind::NotFound => bail!("{}: no such file or folder", path.display()),
        _ => Err(error).with_context(|| format!("cannot open {}", path.display())),
    })
}

fn matches(file: &Found, folder: &Path, selection: &Selection) -> bool {
    let relative = file.path.strip_prefix(folder).unwrap_or(&file.path);
    let filter = selection.filter.as_ref();
    // A folder that cannot be opened hides files that might have matched.
    file.fault.is_some() || filter.is_none_or(|pattern| pattern.matches_path(relative))
}

/// Adds the folder's files in name order. Hidden ones are none of ours, linked folders may circle.
fn search(folder: &Path, depth: usize, endings: &[&str], found: &mut Vec<Found>) {
    let mut fail = |path: &Path, reason: String| {
        found.push(Found { path: path.into(), fault: Some(Fault::of_file(reason)) });
    };
    if depth > DEEPEST {
        return fail(folder, format!("more than {DEEPEST} folders deep"));
    }
    let entries = fs::read_dir(folder).and_then(|entries| entries.collect::<Result<Vec<_>, _>>());
    let mut entries = match entries {
        Ok(entries) => entries,
        Err(error) => return fail(folder, format!("cannot be searched: {error}")),
    };
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let path = entry.path();
        if entry.file_name().as_encoded_bytes().starts_with(b".") {
            continue;
        }
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            if bag::is_bag(&path) {
                // One recording, whatever files it is in.
                found.push(Found { path, fault: None });
                continue;
            }
            search(&path, depth + 1, endings, found);
        } else if ends_in(&path, endings) && fs::metadata(&path).is_ok_and(|about| about.is_file())
        {
            found.push(Found { path, fault: None });
        }
    }
}

/// Whether a folder is no folder of recordings but one recording.
pub(crate) fn is_bag(folder: &Path) -> bool {
    bag::is_bag(folder)
}

/// Whether a file's ending says that it may be a recording.
pub(super) fn is_recording(path: &Path) -> bool {
    ends_in(path, RECORDINGS)
}

/// Whether a file's ending is one of these.
pub(crate) fn ends_in(path: &Path, endings: &[&str]) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| endings.iter().any(|known| known.eq_ignore_ascii_case(ending)))
}

/// `.csv, .txt`.
pub(super) fn listed(endings: &[&str]) -> String {
    endings.iter().map(|ending| format!(".{ending}")).collect::<Vec<_>>().join(", ")
}
