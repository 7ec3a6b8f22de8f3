//! `handover evaluate`: all methods against what people did, as a table or as JSON.

use std::fmt::Write as _;

use anyhow::{Context as _, bail};
use handover_mesh::Config;
use handover_mesh::evaluate::{EvaluateSettings, Evaluation, Figure, leave_one_out};
use handover_mesh::predict::Method;
use handover_mesh::statistics::Summary;

use crate::args::{Evaluate, Protocol};
use crate::demonstrations::{self, Loaded};
use crate::output::Output;
use crate::progress::Progress;
use crate::{Outcome, UsageError, files};

/// The row of what people did themselves.
const HUMAN: &str = "(human)";

/// Loads, evaluates, prints.
pub(crate) fn run(
    arguments: &Evaluate,
    config: &Config,
    output: &Output,
) -> anyhow::Result<Outcome> {
    let Evaluate { demonstrations, selection, out, .. } = arguments;
    files::check_out(out.as_deref(), "json", demonstrations)?;
    let role = arguments.role.as_deref();
    let Loaded { demonstrations, role, left_out } =
        demonstrations::load(demonstrations, role, selection, config, output)?;
    let groups = demonstrations.iter().map(|demonstration| {
        let recording = demonstration.recording();
        let Some(key) = &arguments.group else { return Ok(recording.scene().to_owned()) };
        let Some(group) = recording.metadata().get(key) else {
            bail!(UsageError(format!("{}: no metadata '{key}' to group by (hint: a CSV says it in a line '# {key}=…' above its header)",
                recording.name())));
        };
        Ok(group.clone())
    });
    let groups: Vec<String> = groups.collect::<anyhow::Result<_>>()?;
    let settings = EvaluateSettings {
        methods: methods(&arguments.methods),
        folds: arguments.folds.map_or(config.folds, |folds| folds as usize),
        ignored_joints: config.ignored_joints.clone(),
        predict: config.predict.clone(),
        learn: config.learn.clone(),
    };
    let progress = Progress::new(output, "evaluating", demonstrations.len());
    let evaluation = match arguments.protocol {
        Protocol::LeaveOneOut => {
            leave_one_out(&demonstrations, &groups, &settings, || progress.step())
        }
    };
    drop(progress);
    let evaluation = evaluation.context("cannot evaluate")?;
    for failure in &evaluation.failures {
        output.problem(&format!("not predicted: {failure}"));
    }
    // The table first: it is not lost where the file cannot be written.
    output.result(|| table(&evaluation, &role), || evaluation.to_json(&role))?;
    if let Some(out) = out {
        files::write_text(&format!("{}\n", evaluation.to_json(&role)), out)?;
        output.note(&format!("wrote {}", out.display()));
    }
    let whole = left_out == 0 && evaluation.failures.is_empty();
    Ok(if whole { Outcome::Done } else { Outcome::Loss })
}

/// The methods asked for, each once, in the tables' order; all where none is named.
fn methods(names: &[String]) -> Vec<Method> {
    let wanted = |method: &Method| names.is_empty() || names.iter().any(|n| n == method.name());
    Method::ALL.into_iter().filter(wanted).collect()
}

/// What a column is called, its unit below it.
fn heading(figure: Figure) -> [&'static str; 2] {
    match figure {
        Figure::Joint => ["joint", "cm"],
        Figure::Hand => ["hand", "cm"],
        Figure::Contact => ["contact", "cm"],
        Figure::Gap => ["gap", "cm"],
        Figure::GapAtContact => ["at contact", "cm"],
        Figure::Timing => ["timing", "ms"],
        Figure::Bone => ["bone", "mm"],
        Figure::Jerk => ["jerk", "m/s³"],
    }
}

/// Mean and median per method and figure, and the interval of the mean contact error.
fn table(evaluation: &Evaluation, role: &str) -> String {
    let Evaluation { protocol, clips, .. } = evaluation;
    let frames: usize = clips.iter().map(|clip| clip.frames).sum();
    let mut text = format!(
        "{protocol}: {} clips, {frames} frames, the robot is {role}\n\
         mean / median over the clips, and the 95 % interval of the mean contact error\n\n",
        clips.len()
    );
    for line in 0..2 {
        let _ = write!(text, "{:8}", "");
        for figure in Figure::ALL {
            let _ = write!(text, "{:>15}", heading(figure)[line]);
            if figure == Figure::Contact {
                let _ = write!(text, "{:>14}", ["95 %", "cm"][line]);
            }
        }
        text.push('\n');
    }
    let methods = evaluation.summary.iter().map(|(method, figures)| (method.name(), figures));
    // What people did, by the same figures: how much they scatter themselves.
    for (name, figures) in methods.chain([(HUMAN, &evaluation.human)]) {
        let _ = write!(text, "{name:8}");
        for (figure, summary) in Figure::ALL.into_iter().zip(figures) {
            // How far people are from themselves says nothing.
            let itself = matches!(figure, Figure::Joint | Figure::Hand | Figure::Contact);
            let summary = summary.as_ref().filter(|_| !(itself && name == HUMAN));
            let cell = |text: fn(&Summary) -> String| summary.map_or("-".into(), text);
            let _ = write!(text, " {:>14}", cell(|s| format!("{:.1} / {:.1}", s.mean, s.median)));
            if figure == Figure::Contact {
                let _ = write!(text, "{:>14}", cell(|s| format!("{:.1} - {:.1}", s.low, s.high)));
            }
        }
        text.push('\n');
    }
    text
}
