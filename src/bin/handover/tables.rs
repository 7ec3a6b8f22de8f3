//! Evaluations as text, a table per summary.

use std::fmt::Write as _;

use handover_mesh::evaluate::{
    Condition, Displaced, Evaluation, Figure, ForecastEvaluation, MethodSummaries, Summaries,
};
use handover_mesh::statistics::Summary;

use crate::output::counted;

/// The row of what people did themselves.
const HUMAN: &str = "(human)";

/// What methods knew, where that is not all: one evaluation must not be taken for the other.
fn by_what(causal: bool) -> &'static str {
    if causal { ", by the past alone" } else { "" }
}

/// Mean and median per method and figure, and the interval of the mean contact error.
pub(crate) fn evaluation(evaluation: &Evaluation, role: &str) -> String {
    let Evaluation { protocol, clips, causal, .. } = evaluation;
    let frames: usize = clips.iter().map(|clip| clip.frames).sum();
    // What people did, by the same figures: how much they scatter themselves.
    let rows = named(&evaluation.summary).chain([(HUMAN, &evaluation.human)]);
    format!(
        "{protocol}{}: {}, {}, the robot is {role}\n\
         mean / median over the clips, and the 95 % interval of the mean contact error\n\n{}",
        by_what(*causal),
        counted(clips.len(), "clip"),
        counted(frames, "frame"),
        table(rows)
    )
}

/// All displacements together, then one by one, then robots of other sizes.
pub(crate) fn displaced(displaced: &Displaced, role: &str) -> String {
    let is_scaled = |condition: &Condition| matches!(condition, Condition::Scaled(_));
    let scales = Condition::ALL.iter().filter(|condition| is_scaled(condition)).count();
    let displacements = Condition::ALL.len() - scales;
    // Every clip is there once for each condition.
    let once = displaced.clips.iter().filter(|clip| clip.condition == Condition::ALL[0]);
    let (count, frames) = once.fold((0, 0), |(clips, frames), c| (clips + 1, frames + c.frames));
    let (clips, frames) = (counted(count, "clip"), counted(frames, "frame"));
    let scaled = displaced.clips.iter().filter(|clip| is_scaled(&clip.condition));
    let reachable = scaled.filter(|clip| clip.reachable).count();
    format!(
        "displaced{}: {clips} ({frames}) × {displacements} displacements, \
         the robot is {role}\n\
         the partner moved up, left, right or nearer by 0.1 or 0.2 m; mean / median over clips and \
         displacements\n\n{}\n\
         mean gap of each condition, cm\n\n{}\n\
         scaled: {clips} × {scales} sizes of the robot, 0.8 and 1.2 times its own; \
         {reachable} of these {} within reach\n\
         the partner not moved; mean / median over those within reach\n\n{}",
        by_what(displaced.causal),
        table(named(&displaced.summary)),
        by_condition(displaced),
        scales * count,
        table(named(&displaced.scaled)),
    )
}

/// The partner's active hand, then all joints: a line a method, a column a horizon.
pub(crate) fn forecast(forecast: &ForecastEvaluation, role: &str) -> String {
    let ForecastEvaluation { methods, horizons, clips, wrist, joint } = forecast;
    let frames: usize = clips.iter().map(|clip| clip.frames).sum();
    let mut text = format!(
        "forecast: {}, {}, the robot is {role}, its partner is forecast\n\
         mean / median over the clips [cm], and the 95 % interval of the mean at each horizon\n",
        counted(clips.len(), "clip"),
        counted(frames, "frame"),
    );
    for (what, summaries) in [("wrist", wrist), ("joints", joint)] {
        let _ = write!(text, "\n{what:18}");
        for horizon in horizons {
            let _ = write!(text, "{:>28}", format!("{:.0} ms", 1e3 * horizon));
        }
        text.push('\n');
        for (method, summaries) in methods.iter().zip(summaries) {
            let _ = write!(text, "{:18}", method.name());
            for summary in summaries {
                let cell = summary.map_or(
                    "-".to_owned(),
                    |Summary { mean, median, low, high, .. }| {
                        format!("{mean:.1} / {median:.1} ({low:.1} - {high:.1})")
                    },
                );
                let _ = write!(text, "{cell:>28}");
            }
            text.push('\n');
        }
    }
    text
}

/// Methods by their names.
fn named(methods: &MethodSummaries) -> impl Iterator<Item = (&'static str, &Summaries)> {
    methods.iter().map(|(method, figures)| (method.name(), figures))
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
        Figure::Reach => ["reach", "ms"],
        Figure::Bone => ["bone", "mm"],
        Figure::Jerk => ["jerk", "m/s³"],
    }
}

/// Mean / median of every figure, and the interval of the mean contact error: a line a row.
fn table<'a>(rows: impl Iterator<Item = (&'static str, &'a Summaries)>) -> String {
    let mut text = String::new();
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
    for (name, figures) in rows {
        let _ = write!(text, "{name:8}");
        for (figure, summary) in Figure::ALL.into_iter().zip(figures) {
            // How far people are from themselves says nothing.
            let itself =
                matches!(figure, Figure::Joint | Figure::Hand | Figure::Contact | Figure::Reach);
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

/// The mean gap: a column a condition, a line a method.
fn by_condition(displaced: &Displaced) -> String {
    let mut text = format!("{:8}", "");
    for (condition, _) in &displaced.conditions {
        let _ = write!(text, "{:>12}", condition.name());
    }
    text.push('\n');
    for (row, (method, _)) in displaced.summary.iter().enumerate() {
        let _ = write!(text, "{:8}", method.name());
        for (_, methods) in &displaced.conditions {
            let gap = methods[row].1[Figure::Gap as usize];
            let _ = write!(text, "{:>12}", gap.map_or("-".into(), |s| format!("{:.1}", s.mean)));
        }
        text.push('\n');
    }
    text
}
