//! The log of a search: a line of JSON for what is learned from, one for each step, one for the
//! end; written as things happen, so that a run that was broken off can go on.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use serde_json::{Map, Value};

use crate::{UsageError, files};

/// A log that is written to.
pub(super) struct Log {
    path: PathBuf,
    file: File,
}

/// What a log held when it was opened.
#[derive(Default)]
pub(super) struct Found {
    /// Each with its line, counted from 1.
    pub(super) steps: Vec<(usize, Value)>,
    /// The last line, where the search had ended.
    pub(super) end: Option<Value>,
}

impl Log {
    /// Refuses a log that is there, where none is to go on.
    ///
    /// # Errors
    /// [`UsageError`].
    pub(super) fn check_new(path: &Path, resume: bool) -> anyhow::Result<()> {
        if !resume && path.symlink_metadata().is_ok() {
            bail!(UsageError(format!(
                "{} exists (hint: --resume goes on from it)",
                path.display()
            )));
        }
        Ok(())
    }

    /// Begins a log with its header, or goes on with one that begins so. A line that was cut off
    /// at the end is taken away.
    ///
    /// # Errors
    /// [`UsageError`] with all differences if the log is of another run, else the first line that
    /// is none.
    pub(super) fn open(path: &Path, header: &Value, resume: bool) -> anyhow::Result<(Self, Found)> {
        let shown = path.display();
        if !resume || !path.exists() {
            let file = OpenOptions::new().write(true).create_new(true).open(path);
            let file = file.with_context(|| format!("cannot write {shown}"))?;
            let mut log = Self { path: path.into(), file };
            log.append(header)?;
            return Ok((log, Found::default()));
        }
        let bytes = files::bytes(path).map_err(|faults| {
            let faults: Vec<String> = faults.iter().map(files::Fault::text).collect();
            anyhow::anyhow!("{shown}: {}", faults.join("; "))
        })?;
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
        let lines = || bytes[..whole].split_inclusive(|byte| *byte == b'\n');
        match lines().next() {
            Some(line) => check_header(&parse(path, 1, line)?, header, path)?,
            // Only the beginning of our own header is ours to take away.
            None if header.to_string().as_bytes().starts_with(&bytes) => {}
            None => bail!(UsageError(format!(
                "{shown}, line 1: no log of learning, or one of another run"
            ))),
        }
        let mut found = Found::default();
        for (at, line) in lines().enumerate().skip(1) {
            let (number, value) = (at + 1, parse(path, at + 1, line)?);
            if found.end.is_some() {
                bail!("{shown}, line {number}: nothing follows the line that says 'finished'");
            }
            if value.get("finished").is_some() {
                found.end = Some(value);
            } else {
                found.steps.push((number, value));
            }
        }
        let file = OpenOptions::new().append(true).open(path);
        let file = file.and_then(|file| file.set_len(whole as u64).map(|()| file));
        let file = file.with_context(|| format!("cannot write {shown}"))?;
        let mut log = Self { path: path.into(), file };
        if whole == 0 {
            log.append(header)?;
        }
        Ok((log, found))
    }

    /// Writes a line, there for good when this returns.
    pub(super) fn append(&mut self, line: &Value) -> anyhow::Result<()> {
        let written = self.file.write_all(format!("{line}\n").as_bytes());
        let written = written.and_then(|()| self.file.sync_data());
        written.with_context(|| format!("cannot write {}", self.path.display()))
    }
}

fn parse(path: &Path, number: usize, line: &[u8]) -> anyhow::Result<Value> {
    serde_json::from_slice(line)
        .with_context(|| format!("{}, line {number}: no JSON", path.display()))
}

/// Whether a log's header is that of this run.
fn check_header(found: &Value, here: &Value, path: &Path) -> anyhow::Result<()> {
    let empty = Map::new();
    let object = |value: &'_ Value| value.as_object().cloned();
    let Some(found) = object(found).filter(|found| found.get("format") == here.get("format"))
    else {
        bail!(UsageError(format!("{}, line 1: no log of learning", path.display())));
    };
    let here = here.as_object().unwrap_or(&empty);
    let mut differences = Vec::new();
    for key in keys(&found, here) {
        match (found.get(&key), here.get(&key)) {
            (Some(a), Some(b)) if a == b => {}
            (Some(Value::Object(a)), Some(Value::Object(b))) => {
                let name = if key == "demonstrations" { "recording " } else { "" };
                let of = |map: &Map<String, Value>, key: &str| {
                    map.get(key).map_or("missing".to_owned(), Value::to_string)
                };
                let differing = keys(a, b).into_iter().filter(|key| a.get(key) != b.get(key));
                differences.extend(differing.map(|key| {
                    format!("{name}{key} is {} in the log, {} here", of(a, &key), of(b, &key))
                }));
            }
            (a, b) => {
                let text = |value: Option<&Value>| value.map_or("missing".into(), Value::to_string);
                differences.push(format!("{key} is {} in the log, {} here", text(a), text(b)));
            }
        }
    }
    if differences.is_empty() {
        return Ok(());
    }
    bail!(UsageError(format!("{} is of another run:\n{}", path.display(), differences.join("\n"))))
}

/// The keys of two objects, each once, in order.
fn keys(a: &Map<String, Value>, b: &Map<String, Value>) -> BTreeSet<String> {
    a.keys().chain(b.keys()).cloned().collect()
}
