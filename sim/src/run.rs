//! `handover_sim run`: scenarios → their figures against their bounds.

use std::fmt::Write as _;
use std::fs;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use handover_mesh::Config;
use handover_sim::closed_loop::{Learnt, Outcome};
use handover_sim::scenario::Scenario;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::complain;

/// The elapsed time moves while nothing else does.
const TEMPLATE: &str = "{bar:40} {pos}/{len} {msg} ({elapsed})";

#[derive(clap::Args)]
pub(crate) struct Run {
    /// Scenario files, or folders of them (*.yaml, in the order of their names).
    #[arg(required = true, value_name = "SCENARIO")]
    scenarios: Vec<PathBuf>,
    /// How many made-up handovers the robot has learned from.
    #[arg(long, value_name = "N", default_value_t = Learnt::DEMONSTRATIONS,
          value_parser = clap::value_parser!(u64).range(2..=1000))]
    demonstrations: u64,
    /// The product's parameters [default: as shipped].
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// A parameter over the file's, e.g. safety.speed=1; may be given again.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    settings: Vec<(String, String)>,
    /// Threads to work with, up to 1024 [default: one for each core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Prints one JSON object on stdout.
    #[arg(long)]
    json: bool,
    /// Says nothing on stderr but errors.
    #[arg(short, long)]
    quiet: bool,
}

/// Plays them.
pub(crate) fn run(arguments: &Run) -> ExitCode {
    let read = read_config(arguments).and_then(|config| Ok((config, read_all(arguments)?)));
    let (config, scenarios) = match read {
        Ok(read) => read,
        Err(error) => return complain(&format!("{error:#}"), 2),
    };
    match play(arguments, &config, &scenarios) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => complain(&format!("{error:#}"), 1),
    }
}

fn setting(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("must be KEY=VALUE")?;
    Ok((key.to_owned(), value.to_owned()))
}

fn read_config(arguments: &Run) -> Result<Config> {
    let text = match &arguments.config {
        Some(file) => fs::read_to_string(file).with_context(|| file.display().to_string())?,
        None => String::new(),
    };
    Ok(Config::from_yaml(&text, &arguments.settings)?)
}

/// All scenarios, or all that is wrong with any of them.
fn read_all(arguments: &Run) -> Result<Vec<Scenario>> {
    let mut files = Vec::new();
    for path in &arguments.scenarios {
        if path.is_dir() {
            files.extend(listed(path)?);
        } else {
            files.push(path.clone());
        }
    }
    let (mut scenarios, mut problems) = (Vec::new(), Vec::new());
    for file in &files {
        match read(file) {
            Ok(scenario) => scenarios.push(scenario),
            Err(error) => problems.push(format!("{error:#}")),
        }
    }
    if !problems.is_empty() {
        bail!("{}", problems.join("\n"));
    }
    Ok(scenarios)
}

fn listed(folder: &Path) -> Result<Vec<PathBuf>> {
    let at = || folder.display().to_string();
    let entries = fs::read_dir(folder).with_context(at)?;
    let mut files = entries
        .map(|entry| Ok(entry?.path()))
        .collect::<std::io::Result<Vec<PathBuf>>>()
        .with_context(at)?;
    files.retain(|file| file.extension().is_some_and(|ending| ending == "yaml"));
    files.sort();
    if files.is_empty() {
        bail!("{}: no *.yaml there", at());
    }
    Ok(files)
}

fn read(file: &Path) -> Result<Scenario> {
    let path = file.display().to_string();
    let text = fs::read_to_string(file).with_context(|| path.clone())?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    Ok(Scenario::from_yaml(&path, &name, &text)?)
}

/// Whether every bound held.
fn play(arguments: &Run, config: &Config, scenarios: &[Scenario]) -> Result<bool> {
    let bar = progress_bar(arguments, scenarios.len() as u64 + 1);
    learning(&bar, arguments.demonstrations);
    // 0 lets rayon take one for each core.
    let threads = arguments.jobs.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let outcomes: Vec<Outcome> = pool.install(|| {
        let learnt = Learnt::new(arguments.demonstrations, config)?;
        bar.inc(1);
        bar.set_message("learned and played");
        let played = scenarios.par_iter().map(|scenario| {
            let outcome = Outcome::run(scenario, &learnt);
            bar.inc(1);
            outcome.with_context(|| scenario.name.clone())
        });
        played.collect::<Result<_>>()
    })?;
    bar.finish_and_clear();
    let is_held = outcomes.iter().all(Outcome::is_held);
    let text = if arguments.json {
        let scenarios: Vec<Value> = outcomes.iter().map(Outcome::to_json).collect();
        let result = json!({
            "demonstrations": arguments.demonstrations,
            "scenarios": scenarios,
            "held": is_held,
        });
        format!("{result}\n")
    } else {
        table(&outcomes)
    };
    std::io::stdout().write_all(text.as_bytes())?;
    if !arguments.quiet {
        let missed = outcomes.iter().flat_map(|outcome| &outcome.verdicts);
        let missed = missed.filter(|verdict| !verdict.is_held).count();
        let counts = [counted(outcomes.len(), "scenario"), counted(missed, "bound")];
        writeln!(std::io::stderr(), "{} missed", counts.join(", "))?;
    }
    Ok(is_held)
}

/// `1 bound`, `2 bounds`.
fn counted(count: usize, what: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {what}{ending}")
}

/// One row per bound: what was found, what had to be, and whether it was; then the other figures.
fn table(outcomes: &[Outcome]) -> String {
    let mut text = String::new();
    for outcome in outcomes {
        let _ = writeln!(text, "{}: {}", outcome.name, outcome.about);
        let _ = writeln!(text, "  {:<28} {:>12}   bound", "figure", "value");
        for verdict in &outcome.verdicts {
            let held = if verdict.is_held { "ok" } else { "MISSED" };
            let (value, bound) = (shown(&verdict.value), shown(&verdict.bound));
            let _ = writeln!(text, "  {:<28} {value:>12}   {bound:<18} {held}", verdict.key);
        }
        let bounded: Vec<&str> = outcome.verdicts.iter().map(|v| v.key.as_str()).collect();
        for (figure, value) in &outcome.figures {
            let is_bounded = bounded.iter().any(|key| key.starts_with(figure.key()));
            if let (false, Some(value)) = (is_bounded, value) {
                let _ = writeln!(text, "  {:<28} {:>12}", figure.key(), shown(&json!(value)));
            }
        }
    }
    text
}

fn shown(value: &Value) -> String {
    match value {
        Value::Null => "-".to_owned(),
        Value::Array(names) => {
            let names: Vec<&str> = names.iter().filter_map(Value::as_str).collect();
            if names.is_empty() { "none".to_owned() } else { names.join(",") }
        }
        value => value.as_f64().map_or_else(|| value.to_string(), |n| format!("{n:.3}")),
    }
}

/// A bar on stderr, none when that is no terminal or should be quiet.
fn progress_bar(arguments: &Run, length: u64) -> ProgressBar {
    if arguments.quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
    }
    let bar = ProgressBar::new(length);
    match ProgressStyle::with_template(TEMPLATE) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// Shows the bar from the start, and that it is alive: of many demonstrations, learning takes minutes.
fn learning(bar: &ProgressBar, demonstrations: u64) {
    bar.set_message(format!("learning from {demonstrations} demonstrations"));
    bar.enable_steady_tick(Duration::from_millis(500));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_of_a_kind_is_no_plural() {
        let counts = [0, 1, 2].map(|count| counted(count, "bound"));
        assert_eq!(counts, ["0 bounds", "1 bound", "2 bounds"]);
    }

    #[test]
    fn while_learning_the_bar_says_so() {
        let bar = ProgressBar::hidden();
        learning(&bar, 1000);
        assert_eq!(bar.message(), "learning from 1000 demonstrations");
        assert!(ProgressStyle::with_template(TEMPLATE).is_ok() && TEMPLATE.contains("{msg}"));
    }
}
