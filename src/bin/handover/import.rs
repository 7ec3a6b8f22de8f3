//! `handover import`: recordings of any known format → CSV or bags.

mod object;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use handover_mesh::Config;
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::args::Import;
use crate::files::{self, BadFile, Fault, Target};
use crate::output::Output;
use crate::progress::Progress;
use crate::{Outcome, UsageError};
use object::ObjectMesh;

/// Endings that name one recording, so no folder of them.
const ENDINGS: [&str; 6] = ["csv", "txt", "mcap", "db3", "bag", "json"];

/// Reads, writes and says what was left out.
pub(crate) fn run(import: &Import, config: &Config, output: &Output) -> anyhow::Result<Outcome> {
    let (source, out) = (&import.source, &import.out);
    let is_folder = files::about(source)?.is_dir() && !files::is_bag(source);
    if out.canonicalize().is_ok_and(|out| source.canonicalize().is_ok_and(|s| s == out)) {
        bail!(UsageError(format!("{} is the input and would be overwritten", out.display())));
    }
    if is_folder {
        check_folder(out)?
    } else {
        check_file(out)?
    }
    let mesh = match &import.object_mesh {
        None => None,
        Some(_) if !is_folder && Target::of(out) != Some(Target::Csv) => {
            bail!(UsageError(format!(
                "{}: a bag holds one point of an object, and --object-mesh gives it several (hint: a \
             name ending in .csv)",
                out.display()
            )))
        }
        Some(path) => {
            let mesh = ObjectMesh::read(path, import.object_scale, config.object.points, output)?;
            let Some(mesh) = mesh else { return Ok(Outcome::Failed) };
            Some(mesh)
        }
    };
    let mut read = files::load(std::slice::from_ref(source), &import.selection, output)?;
    let mut bad = read.bad;
    if let Some(mesh) = mesh {
        read.recordings.retain_mut(|loaded| match mesh.around_object(&loaded.recording) {
            Ok(recording) => {
                loaded.recording = recording;
                true
            }
            Err(why) => {
                let faults = vec![Fault::of_file(format!("--object-mesh: {why}"))];
                bad.push(BadFile { path: loaded.path.clone(), faults });
                false
            }
        });
    }
    let damaged = read.recordings.iter().filter(|loaded| !loaded.losses.is_empty());
    let lost: Vec<_> = damaged
        .map(|l| json!({ "file": l.path.display().to_string(), "losses": l.losses }))
        .collect();
    let targets = if is_folder {
        fs::create_dir_all(out).with_context(|| format!("cannot make {}", out.display()))?;
        folder_targets(out, read.recordings.iter().map(|loaded| loaded.recording.name()))
    } else {
        vec![out.clone()]
    };
    let progress = Progress::new(output, "writing", targets.len());
    let wrote: Vec<Result<PathBuf, BadFile>> = read
        .recordings
        .into_par_iter()
        .zip(targets)
        .map(|(loaded, target)| {
            let wrote = files::write(&loaded.recording, &target);
            progress.step();
            wrote.map(|()| target.clone()).map_err(|error| BadFile {
                path: target,
                faults: vec![Fault::of_file(format!("{error:#}"))],
            })
        })
        .collect();
    drop(progress);
    let mut written = Vec::new();
    for wrote in wrote {
        match wrote {
            Ok(path) => written.push(path),
            Err(file) => bad.push(file),
        }
    }
    report(&written, &bad, &lost, output)
}

fn report(
    written: &[PathBuf],
    bad: &[BadFile],
    lost: &[Value],
    output: &Output,
) -> anyhow::Result<Outcome> {
    output.result(
        || written.iter().map(|path| format!("{}\n", path.display())).collect(),
        || {
            let failed = bad.iter().map(|file| {
                let errors: Vec<_> = file.faults.iter().map(Fault::json).collect();
                json!({ "file": file.path.display().to_string(), "errors": errors })
            });
            let written = written.iter().map(|path| path.display().to_string());
            json!({
                "written": written.collect::<Vec<_>>(),
                "failed": failed.collect::<Vec<_>>(),
                "lost": lost,
            })
        },
    )?;
    files::name_bad(bad, output);
    output.note(&format!("{} written, {} left out", written.len(), bad.len()));
    Ok(match (written, bad) {
        (_, []) => Outcome::Done,
        ([], _) => Outcome::Failed,
        _ => Outcome::Loss,
    })
}

fn check_file(out: &Path) -> anyhow::Result<()> {
    let target = Target::of(out);
    let shown = out.display();
    if target == Some(Target::Bag) {
        if out.exists() {
            bail!(UsageError(format!("{shown} exists, and a bag is not written over it")));
        }
        return Ok(());
    }
    if out.is_dir() {
        bail!(UsageError(format!(
            "{shown} is a folder, SRC is one recording (hint: name a file ending in .csv or .mcap)"
        )));
    }
    match (target, ending(out)) {
        (Some(_), _) => Ok(()),
        (None, Some(ending)) => bail!(UsageError(format!(
            "{shown}: cannot write '.{ending}'; recordings are written as .csv, .mcap or .bag"
        ))),
        (None, None) => bail!(UsageError(format!(
            "{shown}: an ending says what to write, and there is none; recordings are written as \
             .csv, .mcap or .bag (a folder, as is a name that ends in /)"
        ))),
    }
}

fn check_folder(out: &Path) -> anyhow::Result<()> {
    let named_as_file = ending(out).is_some_and(|e| ENDINGS.contains(&e.as_str()));
    if out.is_file() || (named_as_file && !out.is_dir()) {
        bail!(UsageError(format!(
            "{} names a file, SRC is a folder (hint: name a folder to write to)",
            out.display()
        )));
    }
    Ok(())
}

fn ending(path: &Path) -> Option<String> {
    path.extension().map(|ending| ending.to_string_lossy().to_lowercase())
}

/// `pair/class/take` → `OUT/pair_class_take.csv`; a number where two clips would meet.
fn folder_targets<'a>(out: &Path, names: impl Iterator<Item = &'a str>) -> Vec<PathBuf> {
    let mut taken = BTreeSet::new();
    let flat = names.map(|name| name.replace(['/', '\\'], "_"));
    flat.map(|flat| {
        let numbered = (2..).map(|number| format!("{flat}_{number}"));
        // There is always a free number; the name alone is what the chain starts with.
        let free = std::iter::once(flat.clone()).chain(numbered).find(|n| !taken.contains(n));
        let free = free.unwrap_or(flat);
        let path = out.join(format!("{free}.csv"));
        taken.insert(free);
        path
    })
    .collect()
}
