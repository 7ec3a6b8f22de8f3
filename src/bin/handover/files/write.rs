//! Recordings and texts → files that are whole or not there.

use std::fs;
use std::io::Write as _;
use std::path::Path;

use anyhow::{Context as _, bail};
use handover_mesh::Recording;
use handover_mesh::formats::csv;

use crate::UsageError;

/// Refuses a file to write whose ending does not say what it will hold.
///
/// # Errors
/// [`UsageError`].
pub(crate) fn check_ending(out: Option<&Path>, ending: &str) -> anyhow::Result<()> {
    let other = |out: &&Path| out.extension().is_none_or(|found| found != ending);
    if let Some(out) = out.filter(other) {
        bail!(UsageError(format!("{}: what is written here ends in .{ending}", out.display())));
    }
    Ok(())
}

/// Writes a recording as CSV.
pub(crate) fn write(recording: &Recording, target: &Path) -> anyhow::Result<()> {
    write_text(&csv::write(recording)?, target)
}

/// Writes beside the target and renames, so that no half-written file ever bears its name.
pub(crate) fn write_text(text: &str, target: &Path) -> anyhow::Result<()> {
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
