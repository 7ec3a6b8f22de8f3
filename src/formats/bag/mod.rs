//! Bags of rosbag2 ⇄ recordings of two people: MCAP and SQLite3, without ROS.
//!
//! A recording is a topic for each person, `/{person}/skeleton`, and perhaps `/{object}/object_pose`;
//! what a robot recorded while it handed over is a recording too: the partner's skeleton,
//! transforms or markers, and where the robot was to be. docs/bags.md has the rules.
//!
//! A damaged bag gives what is whole of it and names what is lost. Where two people were sampled at
//! the same stamps, places come through to the bit; what had to be filled in, interpolated or left
//! out is counted and said.
//!
//! Opens no file: the files of a bag come as bytes, in the order in which `metadata.yaml` has them.

mod assemble;
mod collect;
mod definitions;
mod files;
mod fill;
mod folder;
mod losses;
mod mcap;
mod packed;
mod people;
mod records;
mod sqlite;
mod track;
mod write;

pub use files::{Files, FolderError};
pub use folder::{METADATA_FILE, file_names};
pub use losses::Loss;
pub use people::{PARTNER, ROBOT};
pub use write::{WriteError, Writer, Written, write};

use std::collections::BTreeMap;

use super::error::{ReadError, Reason, Violations, shortened};
use super::up::UpAxis;
use super::{Format, Place};
use crate::skeleton::Recording;
use crate::time::Stamp;
use losses::Losses;

/// More bytes never come out of the compressed files, chunks and messages of a bag.
pub const MOST_UNPACKED: u64 = 1 << 30;

/// Nor out of a file that is compressed as a whole: it is in memory at once.
const MOST_IN_A_FILE: u64 = 1 << 29;

/// How many notes are told one by one.
const MOST_NOTES: usize = 20;

/// A file of a bag.
#[derive(Debug, Clone, Copy)]
pub struct File<'a> {
    /// What losses call it.
    pub name: &'a str,
    /// What is in it; nothing if it should be there and is not.
    pub bytes: Option<&'a [u8]>,
}

/// A message as a bag has it.
#[derive(Debug, Clone, Copy)]
pub struct RawMessage<'a> {
    /// Its topic.
    pub topic: &'a str,
    /// Its type, e.g. `sensor_msgs/msg/JointState`.
    pub type_name: &'a str,
    /// When it was recorded, by the recorder's clock.
    pub time: Stamp,
    /// Its bytes, as [`crate::messages::decode`] takes them.
    pub data: &'a [u8],
}

/// What a bag is read as.
#[derive(Debug, Clone, PartialEq)]
pub struct Read {
    /// The two people.
    pub recording: Recording,
    /// MCAP or SQLite3.
    pub format: Format,
    /// What could not be read.
    pub losses: Vec<Loss>,
    /// What was filled in, interpolated or left out, in words.
    pub notes: Vec<String>,
}

/// What the files tell, one after another.
enum Event<'a> {
    /// There is such a topic.
    Topic { name: &'a str, type_name: &'a str },
    /// A message of it.
    Message { topic: &'a str, type_name: &'a str, encoding: &'a str, time: Stamp, data: &'a [u8] },
    /// What `metadata.yaml` holds, where the file has it too.
    Metadata(&'a str),
    /// What we wrote down about the recording.
    CustomData(&'a BTreeMap<&'a str, &'a str>),
}

/// Reads a recording of two people.
///
/// - `files`: in order; a bare file is a bag of one.
/// - `metadata`: the text of `metadata.yaml`, where the bag is a folder.
/// - `name`: what reports call the clip.
/// - `up`: which axis of the places points up; the recording's is always z.
///
/// # Errors
/// [`ReadError`] lists every violation, each with its message: bags that hold none or more than two
/// people, messages that are none, joints that are unknown or not tracked for long, frames that
/// nothing joins.
pub fn read(
    files: &[File<'_>],
    metadata: Option<&str>,
    name: &str,
    up: UpAxis,
) -> Result<Read, ReadError> {
    let mut collected = collect::Collected::default();
    if let Some(text) = metadata {
        collected.take(Event::Metadata(text));
    }
    let (format, losses) = walk(files, &mut |event| collected.take(event))?;
    let mut violations = Violations::default();
    let mut notes = Vec::new();
    let found = assemble::recording(name, collected, up, &mut notes, &mut violations);
    let recording = violations.or(found)?;
    if notes.len() > MOST_NOTES {
        let more = notes.len() - MOST_NOTES;
        notes.truncate(MOST_NOTES);
        notes.push(format!("... and {more} more"));
    }
    Ok(Read { recording, format, losses: losses.told(), notes })
}

/// Hands out every message that is whole, in the order in which they were written; returns what is
/// lost.
///
/// # Errors
/// [`Reason::NoBag`] if nothing is whole.
pub fn messages(
    files: &[File<'_>],
    mut each: impl FnMut(RawMessage<'_>),
) -> Result<Vec<Loss>, ReadError> {
    let (_, losses) = walk(files, &mut |event| {
        if let Event::Message { topic, type_name, time, data, .. } = event {
            each(RawMessage { topic, type_name, time, data });
        }
    })?;
    Ok(losses.told())
}

/// Whether the bytes begin as those of a bag's file do.
pub(super) fn detect(bytes: &[u8]) -> Option<Format> {
    if mcap::is_mcap(bytes) {
        return Some(Format::Mcap);
    }
    // Files that are compressed as a whole are SQLite3: MCAP has chunks for that.
    (sqlite::is_sqlite(bytes) || packed::is_zstd(bytes)).then_some(Format::Sqlite)
}

fn walk(
    files: &[File<'_>],
    each: &mut dyn FnMut(Event<'_>),
) -> Result<(Format, Losses), ReadError> {
    let (mut losses, mut format, mut messages) = (Losses::default(), None, 0_u64);
    let mut budget = MOST_UNPACKED;
    let mut counted = |event: Event<'_>| {
        messages += u64::from(matches!(event, Event::Message { .. }));
        each(event);
    };
    for file in files {
        let Some(bytes) = file.bytes else {
            losses.file(file.name, "there is no such file");
            continue;
        };
        let unpacked;
        let mut bytes = bytes;
        if packed::is_zstd(bytes) {
            let found = packed::zstd(bytes, budget.min(MOST_IN_A_FILE));
            budget = budget.saturating_sub(found.bytes.len() as u64);
            if let Some(fault) = found.fault {
                losses.file(file.name, &format!("cannot be unpacked to its end: {fault}"));
            }
            unpacked = found.bytes;
            bytes = &unpacked;
        }
        if mcap::is_mcap(bytes) {
            format.get_or_insert(Format::Mcap);
            mcap::walk(file.name, bytes, &mut budget, &mut losses, &mut counted);
        } else if sqlite::is_sqlite(bytes) {
            format.get_or_insert(Format::Sqlite);
            sqlite::walk(file.name, bytes, &mut budget, &mut losses, &mut counted);
        } else {
            losses.file(file.name, "neither MCAP nor SQLite3");
        }
    }
    match format.filter(|_| messages > 0) {
        Some(format) => Ok((format, losses)),
        None => {
            let losses = losses.told();
            let reasons = losses.iter().map(ToString::to_string).collect::<Vec<_>>();
            let reason = if losses.is_empty() {
                "there is no message in it".to_owned()
            } else {
                reasons.join("; ")
            };
            Err(ReadError::of(Place::File, Reason::NoBag { reason }))
        }
    }
}
