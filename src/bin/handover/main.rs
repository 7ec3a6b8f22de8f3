//! The command line: files and folders in, recordings through the library, files out.

mod args;
mod blend;
mod check;
mod configuration;
mod demonstrations;
mod evaluate;
mod files;
mod import;
mod latent_plot;
mod learn;
mod motion;
mod output;
mod plot;
mod progress;
mod replay;
mod sequences;
mod tables;
mod thesis;

use std::process::ExitCode;

use anyhow::Context as _;
use clap::Parser as _;
use handover_mesh::Config;

use args::{Arguments, Command, Global};
use output::Output;

/// How a command ended that could be carried out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// All of it.
    Done,
    /// Some of it: what was left out has been named.
    Loss,
    /// None of it: why has been said.
    Failed,
}

/// A command line that says what cannot be meant.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct UsageError(pub(crate) String);

/// The one place that turns what happened into an exit code.
fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        // Help and version are no errors: clap knows which is which.
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    let output = Output::new(&arguments.global);
    let code = match run(&arguments, &output) {
        Ok(Outcome::Done) if output.has_lost() => 3,
        Ok(Outcome::Done) => 0,
        Ok(Outcome::Failed) => 1,
        Ok(Outcome::Loss) => 3,
        // Whoever reads stdout has read enough (`handover check … | head`).
        Err(error) if output::is_broken_pipe(&error) => 0,
        Err(error) => {
            output.problem(&format!("error: {error:#}"));
            if error.is::<UsageError>() { 2 } else { 1 }
        }
    };
    ExitCode::from(code)
}

fn run(arguments: &Arguments, output: &Output) -> anyhow::Result<Outcome> {
    set_jobs(&arguments.global)?;
    let global = &arguments.global;
    if let Command::Replay(replay) = &arguments.command
        && files::is_model(&replay.source)
    {
        // What is given is over the model's parameters, not over the defaults.
        return replay::run(replay, global, &Config::default(), output);
    }
    // Read for every command: a wrong parameter is wrong wherever it is given.
    let config = configuration::load(global, &arguments.command.parameters())?;
    match &arguments.command {
        Command::Import(import) => import::run(import, &config, output),
        Command::Learn(learn) => learn::run(learn, &config, output),
        Command::Replay(replay) => replay::run(replay, global, &config, output),
        Command::Evaluate(evaluate) => evaluate::run(evaluate, &config, output),
        Command::Motion(motion) => motion::run(motion, &config, output),
        Command::Blend(blend) => blend::run(blend, output),
        Command::Check(check) => check::run(check, output),
    }
}

fn set_jobs(global: &Global) -> anyhow::Result<()> {
    let Some(jobs) = global.jobs else { return Ok(()) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs.into());
    pool.build_global().with_context(|| format!("cannot start {jobs} threads"))
}
