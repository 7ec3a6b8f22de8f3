//! Lines over steps → an SVG.

use std::fmt::Write as _;

/// The picture `[px]`.
const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 420.0;
/// The edges of the plot in it `[px]`.
const LEFT: f64 = 70.0;
const RIGHT: f64 = 560.0;
const TOP: f64 = 40.0;
const BOTTOM: f64 = 365.0;
/// Told apart by most eyes (Okabe and Ito).
pub(crate) const COLOURS: [&str; 7] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];

/// Lines over the same axes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Figure {
    pub(crate) title: String,
    /// What the axes show, with units.
    pub(crate) x: String,
    pub(crate) y: String,
    pub(crate) lines: Vec<Line>,
}

/// A value at 0, 1, 2 and so on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    pub(crate) name: String,
    pub(crate) y: Vec<f64>,
}

/// Draws lines that are never negative; both axes start at 0.
pub(crate) fn svg(figure: &Figure) -> String {
    let longest = figure.lines.iter().map(|line| line.y.len()).max().unwrap_or(0);
    let highest = figure.lines.iter().flat_map(|line| &line.y).fold(0.0, |a: f64, b| a.max(*b));
    let (x_tick, y_tick) = (tick(longest as f64 - 1.0).max(1.0), tick(highest));
    let x_end = ((longest as f64 - 1.0) / x_tick).ceil().max(1.0) * x_tick;
    let y_end = (highest / y_tick).ceil().max(1.0) * y_tick;
    let x_at = |x: f64| LEFT + (RIGHT - LEFT) * x / x_end;
    let y_at = |y: f64| BOTTOM - (BOTTOM - TOP) * y / y_end;

    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
         font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"white\"/>\n"
    );
    let mut text = |x: f64, y: f64, more: &str, words: &str| {
        let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\"{more}>{}</text>", escaped(words));
    };
    let (middle, end) = (" text-anchor=\"middle\"", " text-anchor=\"end\"");
    let (x_middle, y_middle) = ((LEFT + RIGHT) / 2.0, (TOP + BOTTOM) / 2.0);
    text(x_middle, 24.0, &format!("{middle} font-size=\"15\""), &figure.title);
    text(x_middle, HEIGHT - 14.0, middle, &figure.x);
    let turned = format!("{middle} transform=\"rotate(-90 18 {y_middle})\"");
    text(18.0, y_middle, &turned, &figure.y);
    let ticks =
        |end: f64, tick: f64| (0..=(end / tick).round() as u32).map(move |k| k as f64 * tick);
    for x in ticks(x_end, x_tick) {
        text(x_at(x), BOTTOM + 18.0, middle, &short(x));
    }
    for y in ticks(y_end, y_tick) {
        text(LEFT - 8.0, y_at(y) + 4.0, end, &short(y));
    }
    for (at, line) in figure.lines.iter().enumerate() {
        text(RIGHT + 50.0, TOP + 10.0 + 20.0 * at as f64, "", &line.name);
    }
    for y in ticks(y_end, y_tick) {
        let y = y_at(y);
        let _ = writeln!(svg, "<path d=\"M{LEFT} {y:.1}H{RIGHT}\" stroke=\"#ddd\"/>");
    }
    let _ =
        writeln!(svg, "<path d=\"M{LEFT} {TOP}V{BOTTOM}H{RIGHT}\" fill=\"none\" stroke=\"#444\"/>");
    for (at, (line, colour)) in figure.lines.iter().zip(COLOURS.iter().cycle()).enumerate() {
        let key = TOP + 6.0 + 20.0 * at as f64;
        let points = line.y.iter().enumerate();
        let points = points.map(|(x, y)| format!("{:.1},{:.1}", x_at(x as f64), y_at(*y)));
        // Beyond the colours dashes tell lines apart.
        let dash = if at < COLOURS.len() { "" } else { " stroke-dasharray=\"6 3\"" };
        let style = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"{dash}");
        let _ = writeln!(svg, "<path d=\"M{} {key:.1}h26\" {style}/>", RIGHT + 18.0);
        let points = points.collect::<Vec<_>>().join(" ");
        let _ = writeln!(svg, "<polyline points=\"{points}\" {style}/>");
    }
    svg.push_str("</svg>\n");
    svg
}

/// A round distance of ticks, of which 4 to 10 fit.
fn tick(end: f64) -> f64 {
    if end <= 0.0 {
        return 1.0;
    }
    let power = 10f64.powf((end / 4.0).log10().floor());
    [5.0, 2.0, 1.0].map(|n| n * power).into_iter().find(|tick| end / tick >= 4.0).unwrap_or(power)
}

fn short(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

pub(crate) fn escaped(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
