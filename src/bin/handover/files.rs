//! Files and folders named on the command line → recordings, and what could not be read.
//!
//! The order is that of the arguments, and within a folder that of names, whatever the threads do.

mod acclaim;
mod bag;
mod names;
mod search;
mod upright;
mod write;

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use handover_mesh::Recording;
use handover_mesh::formats::obj::Obj;
use handover_mesh::formats::{self, FileError, Format, ReadError, amc, csv};
use handover_mesh::model::Model;
use rayon::prelude::*;
use sha2::{Digest as _, Sha256};

use crate::args::Selection;
use crate::output::Output;
use crate::progress::Progress;
use names::{Place, distinct_names};
use search::Found;
pub(crate) use search::{about, is_bag};
pub(crate) use write::{Growing, Target, check_out, check_place, write, write_bytes, write_text};

/// A recording and where it comes from.
#[derive(Debug)]
pub(crate) struct Loaded {
    /// As the arguments lead to it.
    pub(crate) path: PathBuf,
    pub(crate) recording: Recording,
    pub(crate) format: Format,
    /// Of the file's bytes, a bag's files one after another: 64 hexadecimal digits.
    pub(crate) sha256: String,
    /// What of a damaged bag could not be read.
    pub(crate) losses: Vec<String>,
    /// What was filled in, interpolated or left out.
    pub(crate) notes: Vec<String>,
}

impl Loaded {
    /// The same under another name.
    fn named(self, name: String) -> Self {
        Self { recording: self.recording.renamed(name), ..self }
    }

    /// Says what was lost of it, and what was mended.
    fn tell(&self, output: &Output) {
        let path = self.path.display();
        self.losses.iter().for_each(|loss| output.loss(&format!("{path}: {loss}")));
        self.notes.iter().for_each(|note| output.note(&format!("note: {path}: {note}")));
    }
}

/// Somebody's motion as a file holds it.
#[derive(Debug)]
pub(crate) enum Motion {
    /// Two people's joints.
    People(Loaded),
    /// One person's joint angles.
    Angles(amc::Motion),
}

/// What is wrong at one place of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Fault {
    pub(crate) place: formats::Place,
    pub(crate) reason: String,
}

/// A file and what came of reading it.
#[derive(Debug)]
pub(crate) struct ReadFile<T = Loaded> {
    /// As the arguments lead to it.
    pub(crate) path: PathBuf,
    pub(crate) outcome: Result<T, Vec<Fault>>,
}

/// A file that could not be read.
#[derive(Debug)]
pub(crate) struct BadFile {
    pub(crate) path: PathBuf,
    pub(crate) faults: Vec<Fault>,
}

/// Recordings to work with, and the files left out.
#[derive(Debug)]
pub(crate) struct Demonstrations {
    /// Each under a name of its own.
    pub(crate) recordings: Vec<Loaded>,
    pub(crate) bad: Vec<BadFile>,
    /// Whether the first of all files is one of them.
    pub(crate) first_is_bad: bool,
}

/// Reads all recordings that the arguments name, keeping the good and the bad apart.
///
/// # Errors
/// If a path does not exist or nothing was found there; a bad file is no error.
pub(crate) fn load(
    demos: &[PathBuf],
    selection: &Selection,
    output: &Output,
) -> anyhow::Result<Demonstrations> {
    let (mut recordings, mut bad) = (Vec::new(), Vec::new());
    let files = read_all(demos, selection, output)?;
    let first_is_bad = files.first().is_some_and(|file| file.outcome.is_err());
    for ReadFile { path, outcome } in files {
        match outcome {
            Ok(loaded) => recordings.push(loaded),
            Err(faults) => bad.push(BadFile { path, faults }),
        }
    }
    Ok(Demonstrations { recordings, bad, first_is_bad })
}

/// Says on stderr which files were left out and why.
pub(crate) fn name_bad(bad: &[BadFile], output: &Output) {
    for file in bad {
        for fault in &file.faults {
            output.problem(&format!("{}: {}", file.path.display(), fault.text()));
        }
    }
}

/// Reads all recordings that the arguments name, one after another as they were found, and says so
/// where people lie in them, as they do where the wrong axis is up.
///
/// # Errors
/// As [`load`].
pub(crate) fn read_all(
    arguments: &[PathBuf],
    selection: &Selection,
    output: &Output,
) -> anyhow::Result<Vec<ReadFile>> {
    let read = |path: &Path, place: &Place| parse(path, place, selection);
    let read = read_each(arguments, selection, search::RECORDINGS, output, read)?;
    let named = read.into_iter().map(|(mut file, name)| {
        file.outcome = file.outcome.map(|loaded| loaded.named(name));
        file
    });
    let named: Vec<ReadFile> = named.collect();
    named
        .iter()
        .filter_map(|file| file.outcome.as_ref().ok())
        .for_each(|loaded| loaded.tell(output));
    if let Some(note) = upright::note(&named, selection) {
        output.note(&note);
    }
    Ok(named)
}

/// Reads all files that may hold somebody's motion: recordings, and AMC with the only ASF beside
/// it. With each the name that reports call it.
///
/// # Errors
/// As [`load`].
pub(crate) fn read_motions(
    arguments: &[PathBuf],
    selection: &Selection,
    output: &Output,
) -> anyhow::Result<Vec<(ReadFile<Motion>, String)>> {
    let read = |path: &Path, place: &Place| {
        if search::ends_in(path, &["amc"]) {
            let motion = || acclaim::read(path, &bytes(path)?).map(Motion::Angles);
            is_of_class(place, None, selection).then(motion)
        } else {
            parse(path, place, selection).map(|read| read.map(Motion::People))
        }
    };
    // A skeleton is no motion, and is read with those beside it.
    let motions = arguments.iter().filter(|path| !search::ends_in(path, &["asf"]));
    let motions: Vec<PathBuf> = motions.cloned().collect();
    if motions.is_empty() {
        anyhow::bail!("no motion: a skeleton (.asf) is read with the .amc beside it");
    }
    let read = read_each(&motions, selection, search::MOTIONS, output, read)?;
    for (file, _) in &read {
        if let Ok(Motion::People(loaded)) = &file.outcome {
            loaded.tell(output);
        }
    }
    Ok(read)
}

/// Reads files of some endings, each under a name of its own.
fn read_each<T: Send>(
    arguments: &[PathBuf],
    selection: &Selection,
    endings: &[&str],
    output: &Output,
    read: impl Fn(&Path, &Place) -> Option<Result<T, Vec<Fault>>> + Sync,
) -> anyhow::Result<Vec<(ReadFile<T>, String)>> {
    let found = search::find(arguments, selection, endings)?;
    let progress = Progress::new(output, "reading", found.len());
    let read: Vec<Option<(Place, ReadFile<T>)>> = found
        .into_par_iter()
        .map(|found| {
            let read = read_one(found, &read);
            progress.step();
            read
        })
        .collect();
    drop(progress);
    let (places, files): (Vec<Place>, Vec<ReadFile<T>>) = read.into_iter().flatten().unzip();
    if files.is_empty() {
        let folders: Vec<_> = arguments.iter().map(|path| path.display().to_string()).collect();
        anyhow::bail!(
            "no recording ({}) in {} is of the class asked for",
            search::listed(endings),
            folders.join(", ")
        );
    }
    Ok(files.into_iter().zip(distinct_names(places)).collect())
}

/// `None` if the file is not of the class asked for.
fn read_one<T>(
    found: Found,
    read: impl Fn(&Path, &Place) -> Option<Result<T, Vec<Fault>>>,
) -> Option<(Place, ReadFile<T>)> {
    let Found { path, fault } = found;
    let place = Place::of(&path);
    let outcome = match fault {
        Some(fault) => Err(vec![fault]),
        None => read(&path, &place)?,
    };
    Some((place, ReadFile { path, outcome }))
}

/// A recording, of whatever format; `None` if it is not of the class asked for.
fn parse(path: &Path, place: &Place, selection: &Selection) -> Option<Result<Loaded, Vec<Fault>>> {
    if path.is_dir() {
        let bag = bag::open(path).and_then(|files| bag::read(&files, path, place, selection));
        return of_class(bag, place, selection);
    }
    let bytes = match bytes(path) {
        Ok(bytes) => bytes,
        Err(faults) => return Some(Err(faults)),
    };
    let format = formats::detect(&bytes);
    if let Ok(Format::Mcap | Format::Sqlite) = format {
        let bag = bag::read(&bag::of_file(path, bytes), path, place, selection);
        return of_class(bag, place, selection);
    }
    if !is_of_class(place, Some(&csv::metadata(&bytes)), selection) {
        return None;
    }
    let read = || {
        let format = format?;
        let recording = formats::read(&bytes, &place.name(0), selection.up_axis())?;
        Ok((format, recording.with_metadata(place.metadata())))
    };
    Some(read().map_err(|error| faults(&error)).map(|(format, recording)| Loaded {
        path: path.to_owned(),
        recording,
        format,
        sha256: hexadecimal(&Sha256::digest(&bytes)),
        losses: Vec::new(),
        notes: Vec::new(),
    }))
}

/// What was read, unless it is of another class than the one asked for; a bag says so inside.
fn of_class(
    read: Result<Loaded, Vec<Fault>>,
    place: &Place,
    selection: &Selection,
) -> Option<Result<Loaded, Vec<Fault>>> {
    let metadata = read.as_ref().ok().map(|loaded| loaded.recording.metadata());
    is_of_class(place, metadata, selection).then_some(read)
}

/// Whether the class, by the folders or by what is known of the clip, is the one asked for.
fn is_of_class(
    place: &Place,
    metadata: Option<&BTreeMap<String, String>>,
    selection: &Selection,
) -> bool {
    let class = place.class().or_else(|| Some(metadata?.get("class")?.as_str()));
    selection.class.is_none() || class == selection.class.as_deref()
}

/// A hash as text.
fn hexadecimal(hash: &[u8]) -> String {
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Whether a file's ending says that it holds a model.
pub(crate) fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("safetensors"))
}

/// A model file.
///
/// # Errors
/// If it cannot be read, is larger than any, or holds no model: all that is wrong, one fault each.
pub(crate) fn read_model(path: &Path) -> Result<Model, Vec<Fault>> {
    Model::from_bytes(&bytes(path)?).map_err(|error| {
        let lines = error.to_string();
        lines.lines().map(|line| Fault::of_file(line.to_owned())).collect()
    })
}

/// A shape (OBJ).
///
/// # Errors
/// If it cannot be read, is larger than any file of ours, or holds no shape: all that is wrong.
pub(crate) fn read_obj(path: &Path) -> Result<Obj, Vec<Fault>> {
    Obj::read(&bytes(path)?).map_err(|error| faults(&error))
}

/// A file's text.
///
/// # Errors
/// If it cannot be read, is larger than any file of ours, or is not UTF-8.
pub(crate) fn text(path: &Path) -> Result<String, Vec<Fault>> {
    let not_text = |_| vec![Fault::of_file("not UTF-8".to_owned())];
    String::from_utf8(bytes(path)?).map_err(not_text)
}

/// A file's bytes.
///
/// # Errors
/// If it cannot be read, or is larger than any file of ours.
pub(crate) fn bytes(path: &Path) -> Result<Vec<u8>, Vec<Fault>> {
    let file = File::open(path).map_err(FileError::Unreadable);
    file.and_then(formats::bytes).map_err(|error| vec![Fault::of_file(error.to_string())])
}

fn faults(error: &ReadError) -> Vec<Fault> {
    let each = error.violations().iter();
    let mut faults: Vec<Fault> = each
        .map(|violation| Fault {
            place: violation.place.clone(),
            reason: violation.reason.to_string(),
        })
        .collect();
    if error.more() > 0 {
        faults.push(Fault::of_file(format!("... and {} more", error.more())));
    }
    faults
}

impl Fault {
    /// Of the whole file.
    pub(crate) fn of_file(reason: String) -> Self {
        Self { place: formats::Place::File, reason }
    }

    /// `line 3: reason`, `message 17 of /giver/skeleton: reason`.
    pub(crate) fn text(&self) -> String {
        match self.place {
            formats::Place::File => self.reason.clone(),
            _ => format!("{}: {}", self.place, self.reason),
        }
    }

    /// `{"line", "message", "topic", "reason"}`; null what does not say where it is.
    pub(crate) fn json(&self) -> serde_json::Value {
        let (line, message, topic) = match &self.place {
            formats::Place::File => (None, None, None),
            formats::Place::Line(line) => (Some(line), None, None),
            formats::Place::Message { topic, number } => (None, Some(number), Some(topic)),
        };
        serde_json::json!({
            "line": line,
            "message": message,
            "topic": topic,
            "reason": self.reason,
        })
    }
}
