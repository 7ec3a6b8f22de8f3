//! `handover replay`: a recording put to the robot, tick by tick, from demonstrations or a model.

mod source;
mod ticks;

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, bail};
use handover_mesh::demonstration::Demonstration;
use handover_mesh::evaluate::{Figure, Figures, Trial};
use handover_mesh::online::{OnlineModel, TraceHeader};
use handover_mesh::predict::{Method, Predictor};
use handover_mesh::{Config, Frame, Point, Sequence};
use serde_json::{Value, json};

use crate::args::{Global, Replay};
use crate::output::{Output, counted};
use crate::{Outcome, UsageError, demonstrations, files};
use source::Known;
use ticks::{Ticks, TraceFiles};

/// What there is to say of a replay.
struct Replayed<'a> {
    truth: &'a Demonstration,
    role: &'a str,
    method: Method,
    learnt_from: usize,
    /// Where the robot was moved by ticks.
    ticks: Option<Ticks>,
    figures: Figures,
}

/// Loads, learns, ticks or predicts, writes, prints.
///
/// - `config`: of demonstrations; a model has its own.
pub(crate) fn run(
    replay: &Replay,
    global: &Global,
    config: &Config,
    output: &Output,
) -> anyhow::Result<Outcome> {
    let method = Method::ALL.into_iter().find(|method| method.name() == replay.method);
    let method = method.unwrap_or(Method::Mesh);
    let trace = check_out(replay, method)?;
    let Replay { recording, selection, .. } = replay;
    let mut known = Known::read(replay, global, config, output)?;
    let (paths, role) = (std::slice::from_ref(recording), known.role.clone());
    let people = known.people();
    let people = people.each_ref().map(String::as_str);
    let config = &known.config;
    let loaded = demonstrations::load_live(paths, people, &role, selection, config, output)?;
    let [truth] = loaded.demonstrations.as_slice() else {
        bail!(UsageError(format!("{}: replay takes one recording", recording.display())));
    };
    known.without(truth, recording, output)?;
    let predictor = known.predictor(method, output)?;
    let cannot = || format!("cannot replay {}", recording.display());
    let online = if replay.whole {
        None
    } else {
        let online = OnlineModel::new(&predictor, known.config.online.clone());
        Some(Arc::new(online.with_context(cannot)?))
    };
    let trial = Trial::new(truth, &predictor, online.as_ref(), &known.config.ignored_joints);
    let trial = trial.with_context(cannot)?;
    let (predicted, figures, ticks) = match &online {
        Some(online) if has_tick(method) => {
            let trace = trace.map(|out| begin(out, truth, &known, method, online, &predictor));
            let (trace, seen) = (trace.transpose()?, truth.observation());
            let ticks = ticks::run(online, &seen, method == Method::Mesh, trace, output);
            let mut ticks = ticks.with_context(cannot)?;
            let targets = std::mem::take(&mut ticks.targets);
            let figures = trial.figures(&targets);
            (targets, figures, Some(ticks))
        }
        _ => {
            let (predicted, figures) = trial.run(method).with_context(cannot)?;
            (predicted, figures, None)
        }
    };
    if let Some(out) = &replay.out {
        if trace.is_none() {
            let motion = motion(truth, &predicted)?;
            files::write(&truth.recording().with_motion(truth.robot_role(), motion)?, out)?;
        }
        output.note(&format!("wrote {}", out.display()));
    }
    let learnt_from = predictor.demonstrations().len();
    let replayed = Replayed { truth, role: &role, method, learnt_from, ticks, figures };
    output.result(|| replayed.text(), || replayed.json())?;
    Ok(if known.left_out == 0 { Outcome::Done } else { Outcome::Loss })
}

/// Whether the tick itself moves the robot, or something that it is compared with.
fn has_tick(method: Method) -> bool {
    matches!(method, Method::None | Method::Mesh)
}

/// Refuses outputs that cannot be meant, before any work is done; the trace's path, if one is to be
/// written.
///
/// # Errors
/// [`UsageError`].
fn check_out(replay: &Replay, method: Method) -> anyhow::Result<Option<&Path>> {
    let Some(out) = replay.out.as_deref() else { return Ok(None) };
    let inputs = [replay.source.clone(), replay.recording.clone()];
    let shown = out.display();
    let ends_in = |ending| out.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending));
    if !ends_in("jsonl") {
        if !ends_in("csv") && !ends_in("mcap") {
            bail!(UsageError(format!(
                "{shown}: what is written here ends in .csv or .mcap (a recording) or .jsonl (a \
                 trace)"
            )));
        }
        files::check_place(out, &inputs)?;
        return Ok(None);
    }
    let why = if replay.whole {
        "--whole".to_owned()
    } else if has_tick(method) {
        let beside = TraceFiles::times_beside(out);
        files::check_place(out, &inputs)?;
        files::check_place(&beside, &inputs)?;
        check_no_recording(&beside, &replay.source)?;
        return Ok(Some(out));
    } else {
        format!("--method {}", method.name())
    };
    bail!(UsageError(format!(
        "{shown}: {why} has no ticks to write down (hint: a .csv takes the robot's joints)"
    )));
}

/// Refuses to put what looks like a recording among the demonstrations.
fn check_no_recording(beside: &Path, source: &Path) -> anyhow::Result<()> {
    let folder = beside.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new(".")).canonicalize();
    if let (Ok(folder), Ok(source)) = (folder, source.canonicalize())
        && source.is_dir()
        && folder.starts_with(source)
    {
        bail!(UsageError(format!(
            "{}: would be taken for a recording among the demonstrations",
            beside.display()
        )));
    }
    Ok(())
}

/// Begins the trace's files.
fn begin(
    out: &Path,
    truth: &Demonstration,
    known: &Known,
    method: Method,
    online: &OnlineModel,
    predictor: &Predictor,
) -> anyhow::Result<TraceFiles> {
    let names = predictor.demonstrations().iter().map(|d| d.recording().name().to_owned());
    let header = TraceHeader {
        recording: truth.recording().name(),
        role: &known.role,
        method: method.name(),
        demonstrations: &names.collect::<Vec<_>>(),
        parameters: &known.config.values(),
    };
    TraceFiles::begin(out, &header.line(online))
}

/// Predicted positions on the recording's own stamps.
fn motion(truth: &Demonstration, predicted: &[Point]) -> anyhow::Result<Sequence> {
    let robot = truth.robot();
    let poses = predicted.chunks_exact(robot.skeleton().len());
    let frames = robot.stamps().zip(poses);
    let frames = frames.map(|(stamp, pose)| Frame { stamp, positions: pose.into() });
    Ok(Sequence::new(robot.skeleton().clone(), frames.collect())?)
}

impl Replayed<'_> {
    fn text(&self) -> String {
        let recording = self.truth.recording();
        let mut text = format!(
            "{}: {}, the robot is {}, method {}\n",
            recording.name(),
            counted(recording.len(), "frame"),
            self.role,
            self.method.name()
        );
        if let Some(ticks) = &self.ticks {
            text += &ticks.text();
        }
        for figure in Figure::ALL {
            let value = self.figures.get(figure);
            let value = value.map_or("-".to_owned(), |value| format!("{value:.2}"));
            let _ = writeln!(text, "{:>18} {value:>8}", figure.name());
        }
        text
    }

    /// What is known of ticks only is null where there are none.
    fn json(&self) -> Value {
        let ticks = self.ticks.as_ref();
        let mut value = json!({
            "recording": self.truth.recording().name(),
            "role": self.role,
            "method": self.method.name(),
            "demonstrations": self.learnt_from,
            "frames": self.truth.recording().len(),
            "ticks": ticks.map(|ticks| ticks.count),
            "held": ticks.map(|ticks| ticks.held),
            "held_by": ticks.map(Ticks::held_by),
            "tick_us": ticks.map(Ticks::tick_us),
        });
        if let (Value::Object(value), Value::Object(figures)) = (&mut value, self.figures.to_json())
        {
            value.extend(figures);
        }
        value
    }
}
