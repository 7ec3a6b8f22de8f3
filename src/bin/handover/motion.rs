//! `handover motion`: made-up motions beside true ones, as a table or as JSON.

use std::fmt::Write as _;

use anyhow::Context as _;
use handover_mesh::Config;
use handover_mesh::evaluate::{MotionEvaluation, MotionProtocol, PathErrors, cross_validate};
use handover_mesh::motion::{Dimensions, Neighbourhood};
use serde_json::json;

use crate::args::Motion;
use crate::output::{Output, counted};
use crate::progress::Progress;
use crate::sequences::{self, Unit};
use crate::{Outcome, files, latent_plot};

/// The paper's sets, and all of them together.
const PAPER_SETS: [&str; 5] = ["w1", "w2", "r1", "r2", "all"];

/// Gauch & Peters, Table II: medians of errors A and F.
fn paper(neighbourhood: Neighbourhood) -> Option<[[f64; 5]; 2]> {
    match neighbourhood {
        Neighbourhood::Knn => {
            Some([[0.022, 0.105, 0.099, 0.118, 0.079], [0.057, 0.114, 0.044, 0.024, 0.042]])
        }
        Neighbourhood::Delaunay => {
            Some([[0.023, 0.073, 0.749, 0.068, 0.068], [0.020, 0.043, 0.038, 0.067, 0.041]])
        }
        // Their future work.
        Neighbourhood::KDelaunay => None,
    }
}

/// Loads, learns and follows, prints.
pub(crate) fn run(arguments: &Motion, config: &Config, output: &Output) -> anyhow::Result<Outcome> {
    files::check_out(arguments.out.as_deref(), "json", &arguments.sequences)?;
    files::check_out(arguments.plot.as_deref(), "svg", &arguments.sequences)?;
    let Motion { sequences, role, selection, .. } = arguments;
    let loaded = sequences::load(sequences, role.as_deref(), selection, config, output)?;
    let folds = arguments.folds as usize;
    let protocol = MotionProtocol {
        neighbourhoods: arguments.neighbourhoods(),
        dimensions: arguments.variance.map_or(config.motion.dimensions, Dimensions::Share),
        k: config.motion.k,
        folds,
    };
    let steps = folds.min(loaded.sequences.len());
    let progress = Progress::new(output, "learning and following", steps);
    let found = cross_validate(&loaded.sequences, &protocol, || progress.step());
    drop(progress);
    let found = found.context("cannot make up motions")?;
    let mut value = found.to_json();
    value["unit"] = json!(loaded.unit.symbol());
    output.result(|| text(&found, loaded.unit), || value.clone())?;
    if let Some(out) = &arguments.out {
        files::write_text(&format!("{value}\n"), out)?;
        output.note(&format!("wrote {}", out.display()));
    }
    if let Some(plot) = &arguments.plot {
        files::write_text(&latent_plot::svg(&found, loaded.unit), plot)?;
        output.note(&format!("wrote {}", plot.display()));
    }
    Ok(if loaded.left_out == 0 { Outcome::Done } else { Outcome::Loss })
}

fn text(found: &MotionEvaluation, unit: Unit) -> String {
    let sequences = found.left_out().count();
    let frames: usize = found.left_out().map(|sequence| sequence.frames).sum();
    let mut text = format!(
        "motion: {}, {}, {}\n\n{}\n",
        counted(sequences, "sequence"),
        counted(frames, "frame"),
        counted(found.folds.len(), "fold"),
        each_fold(found)
    );
    let _ = write!(
        text,
        "medians over the sequences, in the latent space [{}], beside the medians of Gauch & Peters\n\
         (Table II), whose scale is not stated: only ratios compare\n\n{}",
        unit.symbol(),
        medians(found)
    );
    text
}

/// A line a fold, and below it a line a sequence.
fn each_fold(found: &MotionEvaluation) -> String {
    let mut text = String::new();
    let names = || found.left_out().map(|sequence| sequence.name.chars().count());
    let width = names().max().unwrap_or(0).max(8);
    for fold in &found.folds {
        let _ = writeln!(
            text,
            "learned from {} poses: {} dimensions explain {:.1} % of their variance",
            fold.points.len(),
            fold.dimensions,
            100.0 * fold.explained
        );
        for (at, neighbourhood) in found.neighbourhoods.iter().enumerate() {
            let _ = writeln!(
                text,
                "  graph {:10}  {} edges, {} strongly connected component(s)",
                neighbourhood.name(),
                fold.edges[at],
                fold.components[at]
            );
        }
        for sequence in &fold.left_out {
            for (at, (neighbourhood, path)) in
                found.neighbourhoods.iter().zip(&sequence.paths).enumerate()
            {
                let name = if at == 0 { sequence.name.as_str() } else { "" };
                let PathErrors { a, f, steps, outside, moving, .. } = path;
                let _ = writeln!(
                    text,
                    "  {name:width$}  {:10}  A {a:.4}  F {f:.4}  {steps} steps{}{}",
                    neighbourhood.name(),
                    if *outside > 0 {
                        format!(", {outside} outside the hull")
                    } else {
                        String::new()
                    },
                    if moving < steps {
                        format!(", standing still after {moving}")
                    } else {
                        String::new()
                    },
                );
            }
        }
    }
    text
}

/// Table II with our column before the paper's.
fn medians(found: &MotionEvaluation) -> String {
    let mut text = format!("{:20}{:>9}", "", "here");
    for set in PAPER_SETS {
        let _ = write!(text, "{:>9}", format!("({set})"));
    }
    text.push('\n');
    let errors: [(&str, Vec<Option<f64>>); 2] =
        [("error A", found.medians(|e| e.a)), ("error F", found.medians(|e| e.f))];
    for (which, (label, medians)) in errors.into_iter().enumerate() {
        for (at, (neighbourhood, median)) in found.neighbourhoods.iter().zip(medians).enumerate() {
            let label = if at == 0 { label } else { "" };
            let median = median.map_or("-".to_owned(), |median| format!("{median:.4}"));
            let _ = write!(text, "{label:9}{:11}{median:>9}", neighbourhood.name());
            for set in 0..PAPER_SETS.len() {
                let figure = paper(*neighbourhood).map(|figures| figures[which][set]);
                let _ = write!(text, "{:>9}", figure.map_or("-".into(), |f| format!("{f:.3}")));
            }
            text.push('\n');
        }
    }
    text
}
