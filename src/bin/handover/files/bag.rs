//! Bags: folders with their metadata, and bare files.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use handover_mesh::formats::bag::{self, METADATA_FILE};
use sha2::{Digest as _, Sha256};

use super::{Fault, LARGEST, Loaded, Place, bytes, faults, hexadecimal};
use crate::args::Selection;

/// Metadata are a few kilobytes; other files of that name may be anything.
const LARGEST_METADATA: u64 = 1 << 24;

/// The files of a bag, in memory.
pub(super) struct Bag {
    /// Those that are not there are none.
    files: Vec<(String, Option<Vec<u8>>)>,
    metadata: Option<String>,
}

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

impl Bag {
    /// The files that the folder's metadata name.
    pub(super) fn open(folder: &Path) -> Result<Self, Vec<Fault>> {
        let text = metadata(folder).unwrap_or_default();
        let (mut files, mut size) = (Vec::new(), 0);
        for name in bag::file_names(&text).map_err(|error| faults(&error))? {
            let path = folder.join(&name);
            let found = if path.is_file() { Some(bytes(&path)?) } else { None };
            size += found.as_ref().map_or(0, Vec::len) as u64;
            if size > LARGEST {
                let reason = format!("larger than {} MiB", LARGEST >> 20);
                return Err(vec![Fault::of_file(reason)]);
            }
            files.push((name, found));
        }
        Ok(Self { files, metadata: Some(text) })
    }

    /// A bare file.
    pub(super) fn of_file(path: &Path, bytes: Vec<u8>) -> Self {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        Self { files: vec![(name.unwrap_or_default(), Some(bytes))], metadata: None }
    }

    /// The recording; what is lost and what was mended comes with it.
    pub(super) fn read(
        &self,
        path: &Path,
        place: &Place,
        selection: &Selection,
    ) -> Result<Loaded, Vec<Fault>> {
        let files: Vec<bag::File<'_>> = self
            .files
            .iter()
            .map(|(name, bytes)| bag::File { name, bytes: bytes.as_deref() })
            .collect();
        let read = bag::read(&files, self.metadata.as_deref(), &place.name(0), selection.up_axis());
        let bag::Read { recording, format, losses, notes } =
            read.map_err(|error| faults(&error))?;
        let mut hash = Sha256::new();
        for (_, bytes) in &self.files {
            hash.update(bytes.as_deref().unwrap_or_default());
        }
        Ok(Loaded {
            path: path.to_owned(),
            recording,
            format,
            sha256: hexadecimal(&hash.finalize()),
            losses: losses.iter().map(ToString::to_string).collect(),
            notes,
        })
    }
}
