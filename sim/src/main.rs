//! `handover_sim`: writes sets of made-up handovers, the truth beside the measurement; plays whole
//! trials of the robot among them, and holds their bounds; plays on ROS 2 topics in place of a
//! sensor.
//!
//! Exit codes: 0 done, 1 failed or a bound missed, 2 usage.

mod files;
mod generate;
mod node;
#[cfg(feature = "ros")]
mod ros;
mod run;

use std::io::Write;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Makes two-person handovers and a Kinect-like sensor's view of them; plays the robot's side of
/// them in a closed loop.
#[derive(Parser)]
#[command(name = "handover_sim", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Writes DIR/measured/*.csv, DIR/truth/*.csv and DIR/manifest.json.
    Generate(generate::Generate),
    /// Plays scenarios: person, sensor, tick, arm; prints their figures against their bounds.
    ///
    /// The robot takes the giver's place and has learned from made-up handovers of another seed.
    /// Exit code 0 if every bound holds, 1 if one is missed, 2 if a scenario cannot be read: then
    /// nothing is played, and all that is wrong is said at once. docs/scenario.md explains every key
    /// of a scenario and every figure.
    Run(run::Run),
    /// Plays a recording or a made-up handover on ROS 2 topics, in place of a sensor.
    ///
    /// The partner comes as a skeleton, transforms and, if wanted, markers, as a sensor with the
    /// faults that parameters switch would see them; the robot's own joints and the object come too.
    /// Exit code 0 when a signal ends it; 2 if a parameter or the recording cannot be meant: then all
    /// that is wrong is said at once.
    Node(node::Node),
}

fn main() -> ExitCode {
    // Wrong arguments end here, with exit code 2.
    match Arguments::parse().command {
        Command::Generate(arguments) => generate::run(&arguments),
        Command::Run(arguments) => run::run(&arguments),
        Command::Node(arguments) => node::run(&arguments),
    }
}

/// Says what is wrong on stderr.
pub(crate) fn complain(text: &str, code: u8) -> ExitCode {
    // Nobody is left to tell if stderr is closed.
    let _ = writeln!(std::io::stderr(), "error: {text}");
    ExitCode::from(code)
}
