//! Recordings, texts and bytes → files that are whole or not there.

use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use handover_mesh::Recording;
use handover_mesh::formats::{bag, csv};

use super::search::{ends_in, is_recording};
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

/// What a recording is written as, by its target's ending.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Target {
    /// `.csv`
    Csv,
    /// `.mcap`: a bag in one file.
    Mcap,
    /// `.bag`, or a name that ends in `/`: a bag as a folder.
    Bag,
}

impl Target {
    /// `None` of an ending that says nothing.
    pub(crate) fn of(target: &Path) -> Option<Self> {
        if target.as_os_str().as_encoded_bytes().ends_with(b"/") {
            return Some(Self::Bag);
        }
        let known = [("csv", Self::Csv), ("mcap", Self::Mcap), ("bag", Self::Bag)];
        known.into_iter().find(|(ending, _)| ends_in(target, &[ending])).map(|(_, target)| target)
    }
}

/// Writes a recording as its target's ending says, whole or not at all.
pub(crate) fn write(recording: &Recording, target: &Path) -> anyhow::Result<()> {
    match Target::of(target) {
        Some(Target::Bag) => write_folder(recording, target),
        Some(Target::Mcap) => {
            let name = file_name(target)?;
            write_bytes(&bag::write(recording, &name)?.mcap, target)
        }
        _ => write_text(&csv::write(recording)?, target),
    }
}

/// A folder grows under another name, too, and no folder that is there is touched.
fn write_folder(recording: &Recording, target: &Path) -> anyhow::Result<()> {
    if target.exists() {
        bail!("{} exists, and a bag is not written over it", target.display());
    }
    let stem = target.file_stem().context("no folder name")?.to_string_lossy().into_owned();
    let file = format!("{stem}_0.mcap");
    let written = bag::write(recording, &file)?;
    let beside = target.with_file_name(format!(".{stem}.{}.tmp", std::process::id()));
    let made = fs::create_dir(&beside).with_context(|| cannot_write(target)).and_then(|()| {
        write_bytes(&written.mcap, &beside.join(&file))?;
        write_text(&written.metadata, &beside.join(bag::METADATA_FILE))?;
        fs::rename(&beside, target).with_context(|| cannot_write(target))
    });
    if made.is_err() {
        // The first error is the one to tell.
        let _ = fs::remove_dir_all(&beside);
    }
    made
}

fn file_name(target: &Path) -> anyhow::Result<String> {
    Ok(target.file_name().context("no file name")?.to_string_lossy().into_owned())
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
