//! CSV → a [`Recording`]: rows, then frames, then people.

use super::super::error::{ReadError, Reason, Violations};
use super::super::up::UpAxis;
use super::rows::Table;
use super::{assemble, metadata};
use crate::skeleton::Recording;

/// Reads a CSV of two people and perhaps an object.
///
/// - `name`: what reports call the clip.
/// - `up`: which axis of the file points up; the recording's is always z.
///
/// # Errors
/// [`ReadError`] lists every violation: columns, numbers, names, frames and times that do not
/// rise, joints and people missing or too many, mixed rates.
pub fn read(bytes: &[u8], name: &str, up: UpAxis) -> Result<Recording, ReadError> {
    let mut violations = Violations::default();
    let table = Table::read(bytes, up, &mut violations);
    if table.frames.is_empty() && violations.none() {
        violations
            .add(1, if bytes.trim_ascii().is_empty() { Reason::Empty } else { Reason::NoFrames });
    }
    let recording = assemble::recording(name, &table, metadata(bytes), &mut violations);
    violations.or(recording)
}
