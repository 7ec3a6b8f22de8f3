//! `handover evaluate --protocol thesis`: what it takes, and its tables as text.

use std::fmt::Write as _;

use anyhow::bail;
use handover_mesh::evaluate::Thesis;

use crate::UsageError;
use crate::args::{Evaluate, Protocol};
use crate::output::{Output, counted};
use crate::plot::{Figure, Line};

/// As many targets as the thesis has.
const USUAL_TARGETS: usize = 5;
/// Steps at which the table of curves shows the distance.
const SHOWN_STEPS: [usize; 9] = [0, 1, 2, 3, 5, 10, 20, 40, 80];

/// Refuses options that say nothing to this protocol, or to the others.
///
/// # Errors
/// [`UsageError`].
pub(crate) fn check(arguments: &Evaluate) -> anyhow::Result<()> {
    if arguments.protocol != Protocol::Thesis {
        if arguments.plot.is_some() {
            bail!(UsageError("--plot: only the protocol thesis has curves to draw".to_owned()));
        }
        return Ok(());
    }
    let given = [
        ("--methods", !arguments.methods.is_empty()),
        ("--folds", arguments.folds.is_some()),
        ("--group", arguments.group.is_some()),
    ];
    if let Some((option, _)) = given.iter().find(|(_, given)| *given) {
        bail!(UsageError(format!(
            "{option}: the protocol thesis has one input motion and no folds (hint: --method says \
             how its edges are learned)"
        )));
    }
    Ok(())
}

/// Says so where there are fewer targets than the thesis has.
pub(crate) fn note_few(clips: usize, output: &Output) {
    if clips < USUAL_TARGETS {
        output.note(&format!("{}; the thesis has {USUAL_TARGETS}", counted(clips, "target")));
    }
}

/// The table, averages beside it, and the curves.
pub(crate) fn text(thesis: &Thesis, role: &str) -> String {
    let (method, kernel) = (thesis.method.name(), thesis.kernel.name());
    let frames: usize = thesis.clips.iter().map(|(_, frames)| frames).sum();
    format!(
        "thesis: {} ({}), the robot is {role}, the input motion is {}\n\
         learned by {method}, kernel {kernel}\n\
         distance in m, summed over joints and frames; a row a training, a column a target, * its \
         own;\n\
         others: mean over the other targets, in brackets before training\n\n{}\n\
         distance in m to the own target over the steps of learning\n\n{}",
        counted(thesis.clips.len(), "target"),
        counted(frames, "frame"),
        thesis.clips[0].0,
        table(thesis),
        curves(thesis),
    )
}

/// Names, and the width that all of them fit in.
fn names(thesis: &Thesis) -> (Vec<&str>, usize) {
    let names: Vec<&str> = thesis.clips.iter().map(|(name, _)| name.as_str()).collect();
    let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0).max(10);
    (names, width)
}

fn table(thesis: &Thesis) -> String {
    let (names, width) = names(thesis);
    let mut text = format!("{:width$}", "");
    for name in &names {
        let _ = write!(text, "  {name:>width$} ");
    }
    let _ = writeln!(text, "  {:>21}", "others");
    let mut line = |name: &str, distances: &[f64], own: Option<usize>| {
        let _ = write!(text, "{name:width$}");
        for (at, distance) in distances.iter().enumerate() {
            let mark = if Some(at) == own { '*' } else { ' ' };
            let _ = write!(text, "  {distance:>width$.4}{mark}");
        }
        if let Some(own) = own {
            let [trained, untrained] = thesis.average(own);
            let _ = write!(text, "  {:>10.4} ({:.4})", trained.others, untrained.others);
        }
        text.push('\n');
    };
    line("untrained", &thesis.untrained, None);
    for (at, (name, training)) in names.iter().zip(&thesis.trainings).enumerate() {
        line(name, &training.distances, Some(at));
    }
    text
}

/// A line a training: the distance at some of the steps, and at the last.
fn curves(thesis: &Thesis) -> String {
    let (names, width) = names(thesis);
    let longest = thesis.trainings.iter().map(|training| training.steps.len()).max().unwrap_or(0);
    let shown = || SHOWN_STEPS.into_iter().filter(|step| *step <= longest);
    let mut text = format!("{:width$}", "step");
    for step in shown() {
        let _ = write!(text, "{step:>10}");
    }
    text.push_str("      last     steps\n");
    for (name, training) in names.iter().zip(&thesis.trainings) {
        let _ = write!(text, "{name:width$}");
        for step in shown() {
            let distance = training.curve.get(step);
            let _ = write!(text, "{:>10}", distance.map_or("".into(), |d| format!("{d:.4}")));
        }
        let last = training.curve[training.curve.len() - 1];
        let _ = writeln!(text, "{last:>10.4}{:>10}", training.steps.len());
    }
    text
}

/// The curves, as figures 4.5 and 4.7 of the thesis have them.
pub(crate) fn figure(thesis: &Thesis) -> Figure {
    let lines = thesis.clips.iter().zip(&thesis.trainings);
    Figure {
        title: format!(
            "Distance to the target learned from ({}, {})",
            thesis.method.name(),
            thesis.kernel.name()
        ),
        x: "steps of learning".to_owned(),
        y: "distance [m]".to_owned(),
        lines: lines
            .map(|((name, _), training)| Line { name: name.clone(), y: training.curve.clone() })
            .collect(),
    }
}
