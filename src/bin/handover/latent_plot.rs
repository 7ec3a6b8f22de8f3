//! A cross-validation in the first two latent dimensions → an SVG: a panel a fold.

use std::fmt::Write as _;

use handover_mesh::evaluate::{MotionEvaluation, MotionFold};
use handover_mesh::motion::Rows;

use crate::plot::{COLOURS, escaped};
use crate::sequences::Unit;

/// A panel and the space around it `[px]`.
const PANEL: f64 = 340.0;
const MARGIN: f64 = 30.0;
/// Above the panels: the key `[px]`.
const HEAD: f64 = 50.0;
/// Panels side by side.
const COLUMNS: usize = 2;

/// Draws what was learned from as dots, true motions in black, made-up ones in colours.
pub(crate) fn svg(found: &MotionEvaluation, unit: Unit) -> String {
    let columns = COLUMNS.min(found.folds.len());
    let rows = found.folds.len().div_ceil(COLUMNS);
    let step = PANEL + 2.0 * MARGIN;
    let (width, height) = (step * columns as f64, HEAD + step * rows as f64);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    let names = found.neighbourhoods.iter().map(|neighbourhood| neighbourhood.name());
    let lines = std::iter::once(("true", "#000000")).chain(names.zip(COLOURS));
    for (at, (name, colour)) in lines.enumerate() {
        let x = MARGIN + 130.0 * at as f64;
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1} 26h26\" stroke=\"{colour}\" stroke-width=\"2\"/>\n\
             <text x=\"{:.1}\" y=\"30\">{}</text>",
            x + 32.0,
            escaped(name)
        );
    }
    for (at, fold) in found.folds.iter().enumerate() {
        let left = MARGIN + step * (at % COLUMNS) as f64;
        let top = HEAD + MARGIN + step * (at / COLUMNS) as f64;
        panel(&mut svg, fold, unit, [left, top]);
    }
    svg.push_str("</svg>\n");
    svg
}

/// One fold: equal scales in both directions, the whole of it inside.
fn panel(svg: &mut String, fold: &MotionFold, unit: Unit, [left, top]: [f64; 2]) {
    let paths = || fold.left_out.iter().flat_map(|sequence| &sequence.paths);
    let truths = fold.left_out.iter().map(|sequence| &sequence.truth);
    let all = std::iter::once(&fold.points).chain(truths).chain(paths().map(|path| &path.points));
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for point in all.flat_map(Rows::iter) {
        for (axis, value) in first_two(point).into_iter().enumerate() {
            low[axis] = low[axis].min(value);
            high[axis] = high[axis].max(value);
        }
    }
    // Of one point only, any scale will do.
    let size = (high[0] - low[0]).max(high[1] - low[1]).max(1e-12);
    let place = |point: &[f64]| {
        let [x, y] = first_two(point);
        let middle = |axis: usize| 0.5 * (low[axis] + high[axis]);
        let scale = PANEL / size;
        [left + 0.5 * PANEL + scale * (x - middle(0)), top + 0.5 * PANEL - scale * (y - middle(1))]
    };
    let names: Vec<&str> = fold.left_out.iter().map(|sequence| sequence.name.as_str()).collect();
    let title = match &names[..] {
        [first, _, ..] => format!("{first} and {} more", names.len() - 1),
        names => names.concat(),
    };
    let _ = writeln!(
        svg,
        "<rect x=\"{left}\" y=\"{top}\" width=\"{PANEL}\" height=\"{PANEL}\" fill=\"none\" \
         stroke=\"#ccc\"/>\n<text x=\"{left}\" y=\"{:.1}\">{}</text>\n\
         <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{size:.2} {} wide</text>",
        top - 8.0,
        escaped(&title),
        left + PANEL,
        top - 8.0,
        unit.symbol()
    );
    let mut dots = String::new();
    for point in fold.points.iter() {
        let [x, y] = place(point);
        let _ = write!(dots, "M{x:.1} {y:.1}h0");
    }
    let _ = writeln!(
        svg,
        "<path d=\"{dots}\" stroke=\"#bbb\" stroke-width=\"2\" stroke-linecap=\"round\"/>"
    );
    let mut line = |points: &Rows, colour: &str| {
        let points = points.iter().map(place).map(|[x, y]| format!("{x:.1},{y:.1}"));
        let points = points.collect::<Vec<_>>().join(" ");
        let _ = writeln!(
            svg,
            "<polyline points=\"{points}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"/>"
        );
    };
    for sequence in &fold.left_out {
        line(&sequence.truth, "#000000");
        for (path, colour) in sequence.paths.iter().zip(COLOURS) {
            line(&path.points, colour);
        }
    }
}

/// A latent point in the plane; of one dimension, on its first axis.
fn first_two(point: &[f64]) -> [f64; 2] {
    [point[0], point.get(1).copied().unwrap_or(0.0)]
}
