//! `handover learn`: demonstrations → a model, step by step, resumable.

mod log;
mod report;

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context as _, bail};
use handover_mesh::Config;
use handover_mesh::demonstration::Hands;
use handover_mesh::evaluate::UnknownJoint;
use handover_mesh::learn::{Lesson, Lessons, Search, Step};
use handover_mesh::model::{Model, Source, Training};
use handover_mesh::predict::{LearnedEdges, Predictor};
use serde_json::{Map, Value, json};

use crate::args::Learn;
use crate::demonstrations::{self, Loaded};
use crate::output::{Output, counted};
use crate::progress::Progress;
use crate::{Outcome, UsageError, files};
use log::{Found, Log};
use report::Report;

/// What a log says it is, and the version of its lines.
const LOG_FORMAT: &str = "handover_mesh learn log";
const LOG_VERSION: u64 = 1;

/// Loads, searches, writes, prints.
pub(crate) fn run(learn: &Learn, config: &Config, output: &Output) -> anyhow::Result<Outcome> {
    check_outs(learn)?;
    #[expect(clippy::disallowed_methods, reason = "a shell: how long it took is worth knowing")]
    let begun = Instant::now();
    let Learn { demonstrations, selection, role, .. } = learn;
    let loaded =
        demonstrations::load_sorted(demonstrations, role.as_deref(), selection, config, output)?;
    let groups = demonstrations::groups(&loaded.demonstrations, learn.group.as_deref())?;
    let count = groups.iter().collect::<BTreeSet<_>>().len();
    if count < 2 {
        bail!(
            "{count} group(s) of recordings; edges are learned from one group by another, and \
             that needs two"
        );
    }
    let mut search = search(&loaded, &groups, config).context("cannot learn")?;
    // What would be no model in the end is refused before the search.
    let unlearned = model(&loaded, config, LearnedEdges::none(hands(&loaded)), training(&search))?;
    let held_out = |search: &Search| search.lessons().held_out_distance().context("cannot learn");
    let held_out_initial = held_out(&search)?;
    let (mut log, found) = match &learn.log {
        Some(path) => {
            let header = header(learn, &loaded, &groups, config, &search);
            let (log, found) = Log::open(path, &header, learn.resume)?;
            (Some((log, path.as_path())), found)
        }
        None => (None, Found::default()),
    };
    let mut steps = redo(&mut search, &found, &unlearned, learn)?;
    if !steps.is_empty() {
        output.note(&format!("{} redone from the log", counted(steps.len(), "step")));
    }
    while let Some(step) = step(&mut search, &steps, output)? {
        if let Some((log, path)) = &mut log {
            if found.end.is_some() {
                bail!("{}: says 'finished' where there is a step to take", path.display());
            }
            log.append(&step.to_json(unlearned.pair(), unlearned.people()))?;
        }
        steps.push(step);
    }
    let training = Training {
        steps: steps.len(),
        // Before it ends, `gradient` may drop small weights.
        final_distance: search.lessons().distance().context("cannot learn")?,
        held_out_distance: held_out(&search)?,
        ..training(&search)
    };
    end(log, &found, &training)?;
    let training_held_out = training.held_out_distance;
    let edges = search.edges().context("cannot learn")?;
    let model = model(&loaded, config, edges, training)?;
    if let (Some(before), Some(after)) = (held_out_initial, training_held_out)
        && after > before
    {
        output.note(&format!(
            "note: the references held out are farther away than without these edges ({before:.4} \
             to {after:.4} m): more or other recordings, or a larger learn.tolerance, may help"
        ));
    }
    // The file first, whoever listens; the words all the same where it cannot be written.
    let written = files::write_bytes(&model.to_bytes(), &learn.out);
    let seconds = begun.elapsed().as_secs_f64();
    let (path, model, search, steps) = (learn.out.as_path(), &model, &search, steps.as_slice());
    let report = Report { path, model, search, steps, held_out_initial, seconds };
    output.result(|| report.text(), || report.json())?;
    written?;
    output.note(&format!("wrote {}", path.display()));
    Ok(if loaded.left_out == 0 { Outcome::Done } else { Outcome::Loss })
}

/// Refuses outputs that cannot be meant, before any work is done.
fn check_outs(learn: &Learn) -> anyhow::Result<()> {
    let Learn { demonstrations, out, log, .. } = learn;
    files::check_out(Some(out), "safetensors", demonstrations)?;
    let Some(log) = log else { return Ok(()) };
    if log == out {
        bail!(UsageError(format!("{}: the model and the log need a file each", out.display())));
    }
    files::check_place(log, demonstrations)?;
    Log::check_new(log, learn.resume)
}

fn search(loaded: &Loaded, groups: &[String], config: &Config) -> anyhow::Result<Search> {
    let predictor = Predictor::fit(loaded.demonstrations.clone(), config.predict.clone())?;
    let skeleton = predictor.demonstrations()[0].robot().skeleton();
    let ignored = UnknownJoint::find(skeleton, &config.ignored_joints)?;
    let lessons = Lessons::of(&predictor, groups, &ignored, &config.learn)?;
    Ok(Search::new(lessons, config.learn.clone())?)
}

/// Any of the hands that meet: what edges are named for where there are none.
fn hands(loaded: &Loaded) -> Hands {
    loaded.demonstrations[0].contact().hands
}

/// What the search has done so far, but for its steps.
fn training(search: &Search) -> Training {
    Training {
        method: search.settings().method.name().to_owned(),
        steps: 0,
        evaluations: search.evaluations(),
        initial_distance: search.initial(),
        final_distance: search.initial(),
        held_out_distance: None,
    }
}

fn model(
    loaded: &Loaded,
    config: &Config,
    edges: LearnedEdges,
    training: Training,
) -> anyhow::Result<Model> {
    let sources = loaded.demonstrations.iter().zip(&loaded.hashes);
    let sources = sources.map(|(demonstration, sha256)| Source {
        recording: demonstration.recording().clone(),
        sha256: sha256.clone(),
    });
    Model::new(sources.collect(), &loaded.role, edges, config.clone(), training)
        .context("cannot make a model of this")
}

/// The names of the references to learn from, and of those held out.
fn references(lessons: &Lessons) -> (Vec<&str>, Vec<&str>) {
    let [learned, held_out] = [lessons.lessons(), lessons.held_out()]
        .map(|lessons| lessons.iter().map(Lesson::name).collect());
    (learned, held_out)
}

/// All that decides what is learned.
fn header(
    learn: &Learn,
    loaded: &Loaded,
    groups: &[String],
    config: &Config,
    search: &Search,
) -> Value {
    let parameters: Map<String, Value> = config.values().into_iter().collect();
    let demonstrations = loaded.demonstrations.iter().zip(&loaded.hashes).zip(groups);
    let demonstrations: Map<String, Value> = demonstrations
        .map(|((demonstration, sha256), group)| {
            let name = demonstration.recording().name().to_owned();
            (name, json!({ "sha256": sha256, "group": group }))
        })
        .collect();
    let (references, held_out) = references(search.lessons());
    json!({
        "format": LOG_FORMAT,
        "format_version": LOG_VERSION,
        "program_version": env!("CARGO_PKG_VERSION"),
        "method": config.learn.method.name(),
        "role": loaded.role,
        "up": format!("{:?}", learn.selection.up_axis()).to_lowercase(),
        "candidates": search.lessons().candidates().len(),
        "references": references,
        "held_out": held_out,
        "parameters": parameters,
        "demonstrations": demonstrations,
    })
}

/// Takes the steps that a log holds.
fn redo(
    search: &mut Search,
    found: &Found,
    model: &Model,
    learn: &Learn,
) -> anyhow::Result<Vec<Step>> {
    let path = learn.log.as_deref().unwrap_or(Path::new(""));
    let mut steps = Vec::new();
    for (line, record) in &found.steps {
        let place = || format!("{}, line {line}", path.display());
        let step = Step::from_json(record, model.pair(), model.people()).with_context(place)?;
        search.redo(&step).with_context(place)?;
        steps.push(step);
    }
    Ok(steps)
}

/// Takes the next step, with a bar for whoever waits.
pub(crate) fn step(
    search: &mut Search,
    taken: &[Step],
    output: &Output,
) -> anyhow::Result<Option<Step>> {
    let (number, distance) = (taken.len() + 1, last_distance(search, taken));
    let label = format!("step {number}, distance {distance:.4} m");
    let progress = Progress::new(output, label, search.next_evaluations());
    search.step(|| progress.step()).context("cannot learn")
}

fn last_distance(search: &Search, steps: &[Step]) -> f64 {
    steps.last().map_or(search.initial(), |step| step.distance)
}

/// Writes the log's last line, or checks the one that is there.
fn end(log: Option<(Log, &Path)>, found: &Found, training: &Training) -> anyhow::Result<()> {
    let Some((mut log, path)) = log else { return Ok(()) };
    let end = json!({
        "finished": true,
        "final": training.final_distance,
        "held_out": training.held_out_distance,
    });
    match &found.end {
        None => log.append(&end),
        Some(found) if *found == end => Ok(()),
        Some(found) => bail!("{}: ends with {found}, must be {end}", path.display()),
    }
}
