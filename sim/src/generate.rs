//! `handover_sim generate`: sets of made-up handovers, the truth beside the measurement.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::ValueEnum;
use handover_mesh::formats::csv;
use handover_sim::output::{clip_entry, manifest};
use handover_sim::sensor::{Sensor, SensorConfig};
use handover_sim::{Clip, generate};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::complain;
use crate::files::OutputFolder;

#[derive(clap::Args)]
pub(crate) struct Generate {
    /// How many clips.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    count: u32,
    /// What all random choices follow from: the same seed, the same bytes.
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
    /// Where to write.
    #[arg(short, long = "out", value_name = "DIR")]
    output: PathBuf,
    /// What the sensor gets wrong.
    #[arg(long, value_enum, default_value_t = Noise::Kinect)]
    noise: Noise,
    /// Frames a second, 5 to 120.
    #[arg(long, value_name = "HZ", default_value_t = 30.0)]
    rate: f64,
    /// Threads to work with, up to 1024 [default: one for each core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Writes into DIR even if it is not empty; clips of an earlier set are removed from it.
    #[arg(long)]
    force: bool,
    /// Prints one JSON object on stdout.
    #[arg(long)]
    json: bool,
    /// Says nothing on stderr but errors.
    #[arg(short, long)]
    quiet: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Noise {
    /// The truth itself.
    None,
    /// A Kinect of the first kind with NiTE.
    Kinect,
}

impl Noise {
    fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Kinect => "kinect",
        }
    }

    fn config(self, rate: f64) -> SensorConfig {
        match self {
            Self::None => SensorConfig::ideal(rate),
            Self::Kinect => SensorConfig::kinect(rate),
        }
    }
}

/// Writes the set.
pub(crate) fn run(arguments: &Generate) -> ExitCode {
    let sensor = match Sensor::new(arguments.noise.config(arguments.rate)) {
        Ok(sensor) => sensor,
        Err(violations) => return complain(&violations.to_string(), 2),
    };
    match write(arguments, &sensor) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => complain(&format!("{error:#}"), 1),
    }
}

fn write(arguments: &Generate, sensor: &Sensor) -> Result<()> {
    let folder = OutputFolder::prepare(&arguments.output, arguments.force)?;
    // 0 lets rayon take one for each core.
    let threads = arguments.jobs.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let bar = progress_bar(arguments);
    let digits = (arguments.count - 1).to_string().len().max(3);
    // Collected in clip order, whichever thread is done first.
    let clips: Vec<Made> = pool.install(|| {
        let made = (0..arguments.count).into_par_iter().map(|index| {
            let name = format!("handover_{index:0digits$}");
            let made = make(arguments.seed, index, &name, sensor, &folder);
            bar.inc(1);
            made
        });
        made.collect::<Result<_>>()
    })?;
    bar.finish_and_clear();
    let sums = clips.iter().fold(Made::default(), |sums, clip| sums.plus(clip));
    let entries = clips.into_iter().map(|clip| clip.entry).collect();
    let manifest = manifest(arguments.seed, arguments.noise.name(), sensor.config(), entries);
    let mut text = serde_json::to_string_pretty(&manifest)?;
    text.push('\n');
    // Last: whoever finds a manifest finds all its clips.
    folder.write("manifest.json", text.as_bytes())?;
    report(arguments, &sums)
}

/// A clip on disk: its manifest entry and what is summed up over a set.
#[derive(Default)]
struct Made {
    entry: Value,
    frames: usize,
    lost_frames: usize,
    swapped_frames: usize,
    held_joints: usize,
    clamped_clips: usize,
}

impl Made {
    fn plus(self, other: &Self) -> Self {
        Self {
            entry: Value::Null,
            frames: self.frames + other.frames,
            lost_frames: self.lost_frames + other.lost_frames,
            swapped_frames: self.swapped_frames + other.swapped_frames,
            held_joints: self.held_joints + other.held_joints,
            clamped_clips: self.clamped_clips + other.clamped_clips,
        }
    }
}

fn make(seed: u64, index: u32, name: &str, sensor: &Sensor, folder: &OutputFolder) -> Result<Made> {
    let clip: Clip = generate(seed, index.into(), name, sensor).with_context(|| name.to_owned())?;
    for (part, recording) in [("truth", &clip.truth), ("measured", &clip.view.measured)] {
        let text = csv::write_rounded(recording).with_context(|| name.to_owned())?;
        folder.write(&format!("{part}/{name}.csv"), text.as_bytes())?;
    }
    Ok(Made {
        entry: clip_entry(&clip),
        frames: clip.truth.len(),
        lost_frames: clip.view.lost_frames,
        swapped_frames: clip.view.swapped_frames,
        held_joints: clip.view.held_joints,
        clamped_clips: usize::from(clip.clamped_frames != [0, 0]),
    })
}

fn report(arguments: &Generate, sums: &Made) -> Result<()> {
    let Made { frames, lost_frames, swapped_frames, held_joints, clamped_clips, .. } = sums;
    if arguments.json {
        let summary = json!({
            "directory": arguments.output.display().to_string(),
            "count": arguments.count,
            "seed": arguments.seed,
            "frames": frames,
            "lost_frames": lost_frames,
            "swapped_frames": swapped_frames,
            "held_joints": held_joints,
            "clamped_clips": clamped_clips,
        });
        writeln!(std::io::stdout(), "{summary}")?;
    }
    if !arguments.quiet {
        writeln!(
            std::io::stderr(),
            "{} clips, {frames} frames in {}: {lost_frames} frames lost, {swapped_frames} with \
             left and right mistaken, {held_joints} joints held; meeting point out of reach in \
             {clamped_clips} clips",
            arguments.count,
            arguments.output.display()
        )?;
    }
    Ok(())
}

/// A bar on stderr, none when that is no terminal or should be quiet.
fn progress_bar(arguments: &Generate) -> ProgressBar {
    if arguments.quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
    }
    let bar = ProgressBar::new(arguments.count.into());
    match ProgressStyle::with_template("{bar:40} {pos}/{len} clips") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
