//! `handover evaluate`: all methods against what people did, as a table or as JSON.

use std::path::Path;

use anyhow::{Context as _, bail};
use clap::ValueEnum as _;
use handover_mesh::Config;
use handover_mesh::evaluate::{
    self, Condition, EvaluateSettings, ForecastProtocol, displaced, leave_one_out,
};
use handover_mesh::forecast::ForecastMethod;
use handover_mesh::predict::Method;
use serde_json::{Value, json};

use crate::args::{Evaluate, Protocol, Selection};
use crate::demonstrations::{self, Loaded};
use crate::output::Output;
use crate::progress::Progress;
use crate::{Outcome, UsageError, files, plot, tables, thesis};

/// Loads, evaluates, prints.
pub(crate) fn run(
    arguments: &Evaluate,
    config: &Config,
    output: &Output,
) -> anyhow::Result<Outcome> {
    let Evaluate { demonstrations, selection, out, .. } = arguments;
    files::check_out(out.as_deref(), "json", demonstrations)?;
    files::check_out(arguments.plot.as_deref(), "svg", demonstrations)?;
    thesis::check(arguments)?;
    check(arguments)?;
    let role = arguments.role.as_deref();
    // A forecast is of one person, and has no figure where a clip is too short.
    let any_length = arguments.protocol == Protocol::Forecast;
    let selection = Selection { any_length, ..selection.clone() };
    let Loaded { demonstrations, role, left_out, first_left_out, .. } =
        demonstrations::load(demonstrations, role, &selection, config, output)?;
    let groups = demonstrations::groups(&demonstrations, arguments.group.as_deref())?;
    let settings = EvaluateSettings {
        methods: methods(&arguments.methods, &Method::ALL, Method::name),
        folds: config.folds,
        ignored_joints: config.ignored_joints.clone(),
        predict: config.predict.clone(),
        learn: config.learn.clone(),
        causal: arguments.causal.then(|| config.online.clone()),
    };
    let folds = evaluate::folds(&groups, config.folds).into_iter().max().map_or(0, |last| last + 1);
    let about = |mut found: Value| {
        found["group"] = json!(arguments.group);
        found["changes"] = changes(config);
        found
    };
    let progress = |steps| Progress::new(output, "learning and evaluating", folds + steps);
    let (clips, out) = (demonstrations.len(), out.as_deref());
    let whole = match arguments.protocol {
        Protocol::LeaveOneOut => {
            let progress = progress(clips);
            let found = leave_one_out(&demonstrations, &groups, &settings, || progress.step());
            drop(progress);
            let found = found.context("cannot evaluate")?;
            let text = || tables::evaluation(&found, &role);
            say(output, out, &found.failures, text, &about(found.to_json(&role)))?;
            found.failures.is_empty()
        }
        Protocol::Displaced => {
            let progress = progress(clips * Condition::ALL.len());
            let found = displaced(&demonstrations, &groups, &settings, || progress.step());
            drop(progress);
            let found = found.context("cannot evaluate")?;
            let text = || tables::displaced(&found, &role);
            say(output, out, &found.failures, text, &about(found.to_json(&role)))?;
            found.failures.is_empty()
        }
        Protocol::Thesis => {
            if first_left_out {
                bail!("the first recording is the input motion, and it had to be left out");
            }
            thesis::note_few(clips, output);
            let progress = Progress::new(output, "learning", clips);
            let found = evaluate::thesis(&demonstrations, &settings, || progress.step());
            drop(progress);
            let found = found.context("cannot evaluate")?;
            let text = || thesis::text(&found, &role);
            say(output, out, &[], text, &about(found.to_json(&role)))?;
            if let Some(plot) = &arguments.plot {
                files::write_text(&plot::svg(&thesis::figure(&found)), plot)?;
                output.note(&format!("wrote {}", plot.display()));
            }
            true
        }
        Protocol::Forecast => {
            let protocol = ForecastProtocol {
                methods: methods(&arguments.methods, &ForecastMethod::ALL, ForecastMethod::name),
                folds: settings.folds,
                settings: config.forecast.clone(),
            };
            let progress = progress(clips);
            let found = evaluate::forecast(&demonstrations, &groups, &protocol, || progress.step());
            drop(progress);
            let found = found.context("cannot evaluate")?;
            let text = || tables::forecast(&found, &role);
            say(output, out, &[], text, &about(found.to_json(&role)))?;
            true
        }
    };
    Ok(if whole && left_out == 0 { Outcome::Done } else { Outcome::Loss })
}

/// Refuses methods of other protocols, how edges are learned where none are, and the past alone
/// where nothing else is known or it is not asked for.
///
/// # Errors
/// [`UsageError`].
fn check(arguments: &Evaluate) -> anyhow::Result<()> {
    let protocol = arguments.protocol.to_possible_value();
    let protocol = protocol.as_ref().map_or("", |protocol| protocol.get_name());
    let has_causal = matches!(arguments.protocol, Protocol::LeaveOneOut | Protocol::Displaced);
    if arguments.causal && !has_causal {
        bail!(UsageError(format!(
            "--causal: goes with the protocols leave_one_out and displaced, not with {protocol}"
        )));
    }
    let own = match arguments.protocol {
        Protocol::LeaveOneOut | Protocol::Displaced => Method::ALL.map(Method::name),
        Protocol::Forecast => ForecastMethod::ALL.map(ForecastMethod::name),
        // It has no columns.
        Protocol::Thesis => return Ok(()),
    };
    if let Some(other) = arguments.methods.iter().find(|name| !own.contains(&name.as_str())) {
        bail!(UsageError(format!(
            "--methods: '{other}' is no method of the protocol {protocol}, which has {}",
            own.join(", ")
        )));
    }
    let learning = &arguments.learning;
    let given = [("--method", &learning.method), ("--kernel", &learning.kernel)];
    let given = given.iter().find(|(_, given)| given.is_some());
    if let Some((option, _)) = given.filter(|_| arguments.protocol == Protocol::Forecast) {
        bail!(UsageError(format!(
            "{option}: the protocol forecast learns no edges (hint: --methods picks its columns)"
        )));
    }
    Ok(())
}

/// The parameters that are not as by default: one evaluation must not be taken for another.
fn changes(config: &Config) -> Value {
    // It was read within its bounds.
    let changes = config.differences().unwrap_or_default().into_iter();
    changes.map(|c| json!({ "key": c.key, "value": c.value, "default": c.default })).collect()
}

/// Failures to stderr, the result to stdout and to a file.
fn say(
    output: &Output,
    out: Option<&Path>,
    failures: &[String],
    text: impl FnOnce() -> String,
    value: &Value,
) -> anyhow::Result<()> {
    for failure in failures {
        output.problem(&format!("not predicted: {failure}"));
    }
    // The table first: it is not lost where the file cannot be written.
    output.result(text, || value.clone())?;
    if let Some(out) = out {
        files::write_text(&format!("{value}\n"), out)?;
        output.note(&format!("wrote {}", out.display()));
    }
    Ok(())
}

/// The protocol's methods of these names, each once, in the tables' order; all where none is named.
fn methods<M: Copy>(names: &[String], all: &[M], name: fn(M) -> &'static str) -> Vec<M> {
    let wanted = |method: &M| names.is_empty() || names.iter().any(|n| n == name(*method));
    all.iter().copied().filter(wanted).collect()
}
