//! Recordings → files that are whole or not there.

use std::fs;
use std::io::Write as _;
use std::path::Path;

use anyhow::Context as _;
use handover_mesh::Recording;
use handover_mesh::formats::csv;

/// Writes beside the target and renames, so that no half-written file ever bears its name.
pub(crate) fn write(recording: &Recording, target: &Path) -> anyhow::Result<()> {
    let text = csv::write(recording)?;
    let name = target.file_name().context("no file name")?.to_string_lossy();
    let beside = target.with_file_name(format!(".{name}.{}.tmp", std::process::id()));
    let written = fs::File::create(&beside)
        .and_then(|mut file| file.write_all(text.as_bytes()).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(&beside, target));
    if written.is_err() {
        // Perhaps it was never made; the first error is the one to tell.
        let _ = fs::remove_file(&beside);
    }
    written.with_context(|| format!("cannot write {}", target.display()))
}
