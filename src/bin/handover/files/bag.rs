//! Bags: folders with their metadata, and bare files.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read as _};
use std::path::Path;

use handover_mesh::formats::bag::{Files, FolderError, METADATA_FILE, Read};
use sha2::{Digest as _, Sha256};

use super::{Fault, Loaded, Place, faults, hexadecimal};
use crate::args::Selection;

/// Metadata are a few kilobytes; other files of that name may be anything.
const LARGEST_METADATA: u64 = 1 << 24;

/// Whether a folder is a bag: rosbag2's metadata lie in it.
pub(super) fn is_bag(folder: &Path) -> bool {
    metadata(folder).is_some_and(|text| text.contains("rosbag2_bagfile_information"))
}

fn metadata(folder: &Path) -> Option<String> {
    let mut text = String::new();
    let file = File::open(folder.join(METADATA_FILE)).ok()?;
    file.take(LARGEST_METADATA).read_to_string(&mut text).ok()?;
    Some(text)
}

/// The files that the folder's metadata name.
pub(super) fn open(folder: &Path) -> Result<Files, Vec<Fault>> {
    let text = metadata(folder).unwrap_or_default();
    Files::of_folder(text, |name| open_plain(&folder.join(name))).map_err(|error| match error {
        FolderError::Metadata(error) => faults(&error),
        other => vec![Fault::of_file(other.to_string())],
    })
}

/// Who opens a pipe waits for whoever writes into it.
fn open_plain(path: &Path) -> io::Result<File> {
    if fs::metadata(path)?.is_file() { File::open(path) } else { Err(ErrorKind::NotFound.into()) }
}

/// A bare file.
pub(super) fn of_file(path: &Path, bytes: Vec<u8>) -> Files {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
    Files::of_file(name.unwrap_or_default(), bytes)
}

/// The recording; what is lost and what was mended comes with it.
pub(super) fn read(
    files: &Files,
    path: &Path,
    place: &Place,
    selection: &Selection,
) -> Result<Loaded, Vec<Fault>> {
    let read = files.read(&place.name(0), selection.up_axis());
    let Read { recording, format, losses, notes } = read.map_err(|error| faults(&error))?;
    let mut hash = Sha256::new();
    files.bytes().for_each(|bytes| hash.update(bytes));
    Ok(Loaded {
        path: path.to_owned(),
        recording,
        format,
        sha256: hexadecimal(&hash.finalize()),
        losses: losses.iter().map(ToString::to_string).collect(),
        notes,
    })
}
