//! Recordings, texts and bytes → files that are whole or not there.

use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use handover_mesh::Recording;
use handover_mesh::formats::csv;

use super::search::is_recording;
use crate::UsageError;

/// Refuses, before any work is done, an output that cannot be meant: another ending, a folder that
/// is not there, or one of the inputs.
///
/// # Errors
/// [`UsageError`].
pub(crate) fn check_out(
    out: Option<&Path>,
    ending: &str,
    inputs: &[PathBuf],
) -> anyhow::Result<()> {
    let Some(out) = out else { return Ok(()) };
    let shown = out.display();
    if out.extension().is_none_or(|found| !found.eq_ignore_ascii_case(ending)) {
        bail!(UsageError(format!("{shown}: what is written here ends in .{ending}")));
    }
    check_place(out, inputs)
}

/// The same of an output that may end in anything.
///
/// # Errors
/// [`UsageError`].
pub(crate) fn check_place(out: &Path, inputs: &[PathBuf]) -> anyhow::Result<()> {
    let shown = out.display();
    // A bare file name's parent is the empty path: this folder.
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        bail!(UsageError(format!("{shown}: no folder {}", folder.display())));
    }
    // What does not exist yet overwrites nothing.
    let Ok(existing) = out.canonicalize() else { return Ok(()) };
    let mut inputs = inputs.iter().filter_map(|input| input.canonicalize().ok());
    // Of a folder only recordings are read.
    let below = |input: &Path| is_recording(&existing) && existing.starts_with(input);
    if inputs.any(|input| existing == input || below(&input)) {
        bail!(UsageError(format!("{shown} is an input and would be overwritten")));
    }
    Ok(())
}

/// Writes a recording as CSV.
pub(crate) fn write(recording: &Recording, target: &Path) -> anyhow::Result<()> {
    write_text(&csv::write(recording)?, target)
}

/// Writes a text, whole or not at all.
pub(crate) fn write_text(text: &str, target: &Path) -> anyhow::Result<()> {
    write_bytes(text.as_bytes(), target)
}

/// Writes the bytes, whole or not at all.
pub(crate) fn write_bytes(bytes: &[u8], target: &Path) -> anyhow::Result<()> {
    let mut file = Growing::new(target)?;
    file.write(bytes)?;
    file.finish()
}

/// A file that grows beside its target and is renamed once it is whole, so that no half-written
/// file ever bears its name. Dropped before that, it is gone.
pub(crate) struct Growing {
    target: PathBuf,
    beside: PathBuf,
    file: BufWriter<File>,
}

impl Growing {
    pub(crate) fn new(target: &Path) -> anyhow::Result<Self> {
        let name = target.file_name().context("no file name")?.to_string_lossy();
        let beside = target.with_file_name(format!(".{name}.{}.tmp", std::process::id()));
        let file = File::create(&beside).with_context(|| cannot_write(target))?;
        Ok(Self { target: target.into(), beside, file: BufWriter::new(file) })
    }

    /// Adds to what is there.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
        self.file.write_all(bytes).with_context(|| cannot_write(&self.target))
    }

    /// All of it is there: from now on under its name.
    pub(crate) fn finish(mut self) -> anyhow::Result<()> {
        let whole = self.file.flush().and_then(|()| self.file.get_ref().sync_all());
        let renamed = whole.and_then(|()| fs::rename(&self.beside, &self.target));
        renamed.with_context(|| cannot_write(&self.target))
    }
}

impl Drop for Growing {
    fn drop(&mut self) {
        // Once renamed it is not there any more; else the first error is the one to tell.
        let _ = fs::remove_file(&self.beside);
    }
}

fn cannot_write(target: &Path) -> String {
    format!("cannot write {}", target.display())
}
