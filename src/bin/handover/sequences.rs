//! Files named on the command line → sequences of poses of one kind.

use std::path::PathBuf;

use anyhow::bail;
use handover_mesh::evaluate::NamedSequence;
use handover_mesh::formats::rate;
use handover_mesh::motion::Rows;
use handover_mesh::statistics::median;
use handover_mesh::{Config, Sequence};

use crate::args::Selection;
use crate::demonstrations::{default_role, most_common};
use crate::files::{self, BadFile, Motion, ReadFile};
use crate::output::Output;

/// Sequences to work with, and how many files were left out (each has been named).
pub(crate) struct Loaded {
    pub(crate) sequences: Vec<NamedSequence>,
    /// What the numbers of a pose are.
    pub(crate) unit: Unit,
    pub(crate) left_out: usize,
}

/// What the numbers of a pose are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unit {
    /// Joint angles.
    Radians,
    /// Joints' places from the base, in the person's heading.
    Metres,
}

impl Unit {
    pub(crate) fn symbol(self) -> &'static str {
        match self {
            Self::Radians => "rad",
            Self::Metres => "m",
        }
    }
}

/// One sequence, and what must be the same in all.
struct Found {
    name: String,
    poses: Rows,
    unit: Unit,
    channels: Vec<String>,
    /// Frames a second `[Hz]`; none of a single frame.
    rate: Option<f64>,
}

/// Rates farther apart than by this factor are two: a motion model counts time in frames.
const SAME_RATE: f64 = 1.25;

/// Loads motions without their root; names on stderr what has to be left out.
///
/// # Errors
/// If nothing remains.
pub(crate) fn load(
    paths: &[PathBuf],
    role: Option<&str>,
    selection: &Selection,
    config: &Config,
    output: &Output,
) -> anyhow::Result<Loaded> {
    let (mut motions, mut bad) = (Vec::new(), Vec::new());
    for (ReadFile { path, outcome }, name) in files::read_motions(paths, selection, output)? {
        match outcome {
            Ok(motion) => motions.push((name, motion)),
            Err(faults) => bad.push(BadFile { path, faults }),
        }
    }
    files::name_bad(&bad, output);
    let mut left_out = bad.len();
    let role = role_of(role, &motions)?;
    let mut leave_out = |why: String| {
        output.problem(&format!("left out: {why}"));
        left_out += 1;
    };
    let mut found: Vec<Found> = Vec::new();
    for (name, motion) in motions {
        match take(name, &motion, role.as_deref(), config) {
            Ok(sequence) => found.push(sequence),
            Err(why) => leave_out(why),
        }
    }
    if let Some(usual) = most_common(found.iter().map(|f| f.channels.clone())) {
        found.retain(|sequence| {
            let same = sequence.channels == usual;
            if !same {
                leave_out(format!("{}: its poses have other channels than most", sequence.name));
            }
            same
        });
    }
    if let Some(usual) = median(found.iter().filter_map(|sequence| sequence.rate).collect()) {
        found.retain(|sequence| {
            let rate = sequence.rate.unwrap_or(usual);
            let same = rate <= SAME_RATE * usual && usual <= SAME_RATE * rate;
            if !same {
                leave_out(format!(
                    "{}: {rate:.1} Hz, where most have about {usual:.1} Hz",
                    sequence.name
                ));
            }
            same
        });
    }
    let Some(unit) = found.first().map(|sequence| sequence.unit) else {
        bail!("no sequence is left to work with");
    };
    let sequences =
        found.into_iter().map(|Found { name, poses, .. }| NamedSequence { name, poses });
    Ok(Loaded { sequences: sequences.collect(), unit, left_out })
}

/// The robot's role, if there are recordings of two people.
fn role_of(role: Option<&str>, motions: &[(String, Motion)]) -> anyhow::Result<Option<String>> {
    let recordings = motions.iter().filter_map(|(_, motion)| match motion {
        Motion::People(loaded) => Some(&loaded.recording),
        Motion::Angles(_) => None,
    });
    match role {
        Some(role) => Ok(Some(role.to_owned())),
        None if recordings.clone().next().is_none() => Ok(None),
        None => default_role(recordings).map(Some),
    }
}

fn take(
    name: String,
    motion: &Motion,
    role: Option<&str>,
    config: &Config,
) -> Result<Found, String> {
    match motion {
        Motion::Angles(motion) => {
            let values = (0..motion.len()).flat_map(|frame| motion.angles(frame).to_vec());
            let poses = Rows::new(motion.skeleton().channel_count(), values.collect());
            let poses = poses.map_err(|error| format!("{name}: {error}"))?;
            let (channels, rate) = (motion.channel_names(), rate(motion.stamps()));
            Ok(Found { name, poses, unit: Unit::Radians, channels, rate })
        }
        Motion::People(loaded) => {
            let recording = &loaded.recording;
            let role = role.and_then(|role| recording.role(role)).ok_or_else(|| {
                let people = recording.people().each_ref().map(|person| person.name.as_str());
                format!(
                    "{name}: nobody is called '{}'; there are {}",
                    role.unwrap_or(""),
                    people.join(" and ")
                )
            })?;
            let partner = &recording.person(role.partner()).motion;
            let poses = rootless(partner, &config.base_joint);
            let poses = poses.map_err(|error| format!("{name}: {error}"))?;
            let channels = partner.skeleton().names().to_vec();
            let rate = rate(recording.stamps());
            Ok(Found { name, poses, unit: Unit::Metres, channels, rate })
        }
    }
}

/// Joints from the base, turned so that the person faces x.
fn rootless(motion: &Sequence, base: &str) -> Result<Rows, handover_mesh::motion::MotionError> {
    let skeleton = motion.skeleton();
    let base = skeleton.joint(base).unwrap_or(skeleton.root());
    let joints = (0..motion.len()).flat_map(|frame| motion.rootless(frame, base));
    Rows::new(3 * skeleton.len(), joints.flat_map(|p| [p.x, p.y, p.z]).collect())
}
