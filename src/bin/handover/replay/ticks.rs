//! The real tick over a recording, by the recorded clock: targets, what held them up, and how long
//! the ticks took.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::Context as _;
use handover_mesh::Point;
use handover_mesh::demonstration::Observation;
use handover_mesh::online::{OnlineModel, Pipeline, Replay, trace_line};
use handover_mesh::safety::HoldReason;
use handover_mesh::statistics::quantile;
use serde_json::{Value, json};

use crate::files;
use crate::output::{Output, counted};
use crate::progress::Progress;

/// What became of a recording.
pub(super) struct Ticks {
    /// Where the robot was to be at each frame: `[m]`, `frames × joints`.
    pub(super) targets: Vec<Point>,
    /// How many ticks there were: as many as frames, or more where these are far apart.
    pub(super) count: usize,
    /// Frames at which the robot did not move as proposed.
    pub(super) held: usize,
    /// The same by reason.
    held_by: BTreeMap<HoldReason, usize>,
    times: Times,
}

/// How long a tick took `[us]`.
struct Times {
    median: f64,
    /// Of a hundred ticks one takes longer.
    p99: f64,
    max: f64,
}

/// The files of a trace while they are written.
pub(super) struct TraceFiles {
    trace: files::Growing,
    times: files::Growing,
}

/// Ticks through what was observed.
///
/// - `edges`: whether the edges between the people count.
pub(super) fn run(
    model: &Arc<OnlineModel>,
    observation: &Observation,
    edges: bool,
    mut trace: Option<TraceFiles>,
    output: &Output,
) -> anyhow::Result<Ticks> {
    let mut pipeline = Pipeline::new(model.clone(), &observation.bone_lengths, edges)?;
    let mut replay = Replay::new(observation, model.settings().tick_rate);
    let progress = Progress::new(output, "ticking", observation.len());
    let mut targets = Vec::with_capacity(observation.len() * observation.robot_skeleton.len());
    let (mut held_by, mut times) = (BTreeMap::new(), Vec::new());
    while let Some((frame, input)) = replay.next_tick() {
        #[expect(clippy::disallowed_methods, reason = "a shell: how long a tick takes is asked")]
        let begun = Instant::now();
        let tick = pipeline.tick(&input);
        let time = begun.elapsed().as_nanos() as f64 / 1000.0;
        if let Some(trace) = &mut trace {
            let reason = tick.reason.map_or("", HoldReason::name);
            let took = format!("{},{},{time:.3},{reason}\n", times.len(), input.now.0);
            trace.append(&trace_line(model, &input, &tick), &took)?;
        }
        times.push(time);
        if frame.is_some() {
            let target = tick.target.context("the robot's first pose is no place to start from")?;
            targets.extend_from_slice(target.positions());
            if let Some(reason) = tick.reason {
                *held_by.entry(reason).or_insert(0) += 1;
            }
            progress.step();
        }
    }
    if let Some(trace) = trace {
        trace.finish()?;
    }
    let count = times.len();
    let part = |part| quantile(times.clone(), part).unwrap_or(0.0);
    let times = Times { median: part(0.5), p99: part(0.99), max: part(1.0) };
    Ok(Ticks { targets, count, held: held_by.values().sum(), held_by, times })
}

impl Ticks {
    /// `{REASON: frames}`, of the reasons that there were.
    pub(super) fn held_by(&self) -> Value {
        let reasons = self.held_by.iter();
        Value::Object(reasons.map(|(reason, n)| (reason.name().to_owned(), json!(n))).collect())
    }

    /// `{"p50","p99","max"}` `[us]`.
    pub(super) fn tick_us(&self) -> Value {
        let Times { median, p99, max } = self.times;
        json!({ "p50": median, "p99": p99, "max": max })
    }

    /// The same in words, a line each.
    pub(super) fn text(&self) -> String {
        let reasons = self.held_by.iter().map(|(reason, n)| format!("{} {n}", reason.name()));
        let reasons: Vec<String> = reasons.collect();
        let reasons =
            if reasons.is_empty() { String::new() } else { format!(" ({})", reasons.join(", ")) };
        let Times { median, p99, max } = self.times;
        format!(
            "{} of {median:.0} us, 1 % longer than {p99:.0} us, none than {max:.0} us; held \
             at {}{reasons}\n",
            counted(self.count, "tick"),
            counted(self.held, "frame")
        )
    }
}

impl TraceFiles {
    /// Begins a trace.
    pub(super) fn begin(out: &Path, header: &str) -> anyhow::Result<Self> {
        let trace = files::Growing::new(out)?;
        let times = files::Growing::new(&Self::times_beside(out))?;
        let mut files = Self { trace, times };
        files.append(header, "tick,now_ns,tick_us,reason\n")?;
        Ok(files)
    }

    /// Where the times go: no part of the trace, which is the same in every run.
    pub(super) fn times_beside(out: &Path) -> PathBuf {
        out.with_extension("ticks.csv")
    }

    fn append(&mut self, trace: &str, times: &str) -> anyhow::Result<()> {
        self.trace.write(trace.as_bytes())?;
        self.trace.write(b"\n")?;
        self.times.write(times.as_bytes())
    }

    fn finish(self) -> anyhow::Result<()> {
        self.times.finish()?;
        self.trace.finish()
    }
}
