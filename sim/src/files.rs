//! The folder a set is written to: whole files only, and nobody else's overwritten.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

/// The parts of a set that hold a file for each clip.
const PARTS: [&str; 2] = ["measured", "truth"];

/// A folder that is ours to write to.
pub(crate) struct OutputFolder {
    path: PathBuf,
}

impl OutputFolder {
    /// Makes the folder and its parts.
    ///
    /// One that is not empty is refused, unless `force`: then its manifest and the clips of an
    /// earlier set are removed first (so that no mix of two sets can result), all else is kept.
    pub(crate) fn prepare(path: &Path, force: bool) -> Result<Self> {
        let at = || path.display().to_string();
        if path.exists() {
            let empty = fs::read_dir(path).with_context(at)?.next().is_none();
            if !empty && !force {
                bail!("{} is not empty; hint: --force writes into it all the same", at());
            }
            remove_earlier_set(path).with_context(at)?;
        }
        for part in PARTS {
            fs::create_dir_all(path.join(part)).with_context(at)?;
        }
        Ok(Self { path: path.to_owned() })
    }

    /// Writes a file under a temporary name, then gives it its own: readers see all or nothing.
    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        let path = self.path.join(name);
        let unfinished = path.with_extension("unfinished");
        fs::write(&unfinished, bytes)
            .and_then(|()| fs::rename(&unfinished, &path))
            .with_context(|| path.display().to_string())
    }
}

fn remove_earlier_set(path: &Path) -> Result<()> {
    let manifest = path.join("manifest.json");
    if manifest.exists() {
        fs::remove_file(manifest)?;
    }
    for part in PARTS.map(|part| path.join(part)).iter().filter(|part| part.is_dir()) {
        for entry in fs::read_dir(part)? {
            let file = entry?.path();
            if is_clip(&file) {
                fs::remove_file(file)?;
            }
        }
    }
    Ok(())
}

/// Whether a file has a name that we give: `handover_` and digits.
fn is_clip(file: &Path) -> bool {
    let stem = file.file_stem().and_then(|stem| stem.to_str());
    let digits = stem.and_then(|stem| stem.strip_prefix("handover_"));
    let ours = ["csv", "unfinished"].map(Some);
    digits.is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()))
        && ours.contains(&file.extension().and_then(|ending| ending.to_str()))
}
