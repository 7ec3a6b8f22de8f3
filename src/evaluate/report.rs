//! An evaluation as a value, and as the JSON object that scripts rely on.

use serde_json::{Value, json};

use super::{EvaluateSettings, Figure, Figures, TrialError};
use crate::predict::Method;
use crate::statistics::Summary;

/// Figures per method, in the columns' order.
pub type MethodFigures = Vec<(Method, Figures)>;

/// Summaries per method, in the columns' order.
pub type MethodSummaries = Vec<(Method, Summaries)>;

/// One clip's figures by all methods.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// The clip.
    pub name: String,
    /// Its length in frames.
    pub frames: usize,
    /// The methods' figures, in the columns' order.
    pub methods: MethodFigures,
    /// The same figures of what the human in the robot's role did, by the hands that really met:
    /// how much people scatter.
    pub human: Figures,
}

/// All figures in [`Figure::ALL`]'s order, each over the clips where it is defined; `None` where
/// it never is.
pub type Summaries = [Option<Summary>; Figure::ALL.len()];

/// All clips and their summary.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// The protocol's name.
    pub protocol: &'static str,
    /// Whether methods knew the past alone.
    pub causal: bool,
    /// The clips, in their own order.
    pub clips: Vec<Clip>,
    /// Per method, in the columns' order.
    pub summary: MethodSummaries,
    /// Of the humans in the robot's role.
    pub human: Summaries,
    /// Clips and methods without a prediction, each with its reason; their figures are undefined.
    pub failures: Vec<String>,
}

impl Evaluation {
    /// Sums up the clips.
    pub(super) fn new(
        protocol: &'static str,
        settings: &EvaluateSettings,
        clips: Vec<Clip>,
        failures: Vec<String>,
    ) -> Self {
        let each: Vec<Vec<&MethodFigures>> = clips.iter().map(|clip| vec![&clip.methods]).collect();
        let summary = summarise(&settings.methods, &each);
        let human = summaries(&clips.iter().map(|clip| vec![clip.human]).collect::<Vec<_>>());
        Self { protocol, causal: settings.causal.is_some(), clips, summary, human, failures }
    }

    /// `{"protocol","role","causal","methods":[METHOD],"clips":[{"name","frames",
    /// "methods":{METHOD:{FIGURE}},"human":{FIGURE}}],
    /// "summary":{METHOD:{FIGURE:{"mean","median","low","high","n"}}},"human":{FIGURE:{…}}}`;
    /// undefined figures are null.
    pub fn to_json(&self, role: &str) -> Value {
        let clips: Vec<Value> = self.clips.iter().map(clip_json).collect();
        json!({
            "protocol": self.protocol,
            "role": role,
            "causal": self.causal,
            "methods": names(&self.summary),
            "clips": clips,
            "summary": summaries_json(&self.summary),
            "human": summary_json(&self.human),
        })
    }
}

/// The figures of every method on one clip, undefined where it fails, and who failed: `what` names
/// the clip.
pub(super) fn every_method(
    what: &str,
    methods: &[Method],
    run: impl Fn(Method) -> Result<Figures, TrialError>,
) -> (MethodFigures, Vec<String>) {
    let mut failures = Vec::new();
    let methods = methods.iter().map(|method| {
        let figures = run(*method).unwrap_or_else(|error| {
            failures.push(format!("{what}, {}: {error}", method.name()));
            Figures::default()
        });
        (*method, figures)
    });
    (methods.collect(), failures)
}

/// Sums up clips, method by method.
///
/// - `clips`: per clip all its figures: one set, or one for each way it was put.
pub(super) fn summarise(methods: &[Method], clips: &[Vec<&MethodFigures>]) -> MethodSummaries {
    let columns = methods.iter().enumerate().map(|(column, method)| {
        let figures = clips.iter().map(|clip| clip.iter().map(|all| all[column].1).collect());
        (*method, summaries(&figures.collect::<Vec<_>>()))
    });
    columns.collect()
}

fn summaries(clips: &[Vec<Figures>]) -> Summaries {
    Figure::ALL.map(|figure| {
        // A hand that is early and one that is late do not make a punctual one.
        let size = |value: f64| if figure == Figure::Timing { value.abs() } else { value };
        let values = clips.iter().map(|clip| -> Vec<f64> {
            clip.iter().filter_map(|figures| figures.get(figure)).map(size).collect()
        });
        let values: Vec<Vec<f64>> = values.collect();
        Summary::of_groups(&values.iter().map(Vec::as_slice).collect::<Vec<_>>())
    })
}

/// The columns' names.
pub(super) fn names(methods: &MethodSummaries) -> Vec<&'static str> {
    methods.iter().map(|(method, _)| method.name()).collect()
}

/// `{METHOD:{FIGURE:{"mean","median","low","high","n"} or null}}`.
pub(super) fn summaries_json(methods: &MethodSummaries) -> Value {
    let methods = methods.iter();
    Value::Object(methods.map(|(method, s)| (method.name().to_owned(), summary_json(s))).collect())
}

fn summary_json(summaries: &Summaries) -> Value {
    let figures = Figure::ALL.iter().zip(summaries).map(|(figure, summary)| {
        let value = summary.map_or(Value::Null, |s| {
            json!({ "mean": s.mean, "median": s.median, "low": s.low, "high": s.high, "n": s.n })
        });
        (figure.name().to_owned(), value)
    });
    Value::Object(figures.collect())
}

/// `{METHOD:{FIGURE: number or null}}`.
pub(super) fn figures_json(methods: &MethodFigures) -> Value {
    let methods = methods.iter();
    Value::Object(methods.map(|(method, f)| (method.name().to_owned(), f.to_json())).collect())
}

fn clip_json(clip: &Clip) -> Value {
    let methods = figures_json(&clip.methods);
    json!({ "name": clip.name, "frames": clip.frames, "methods": methods, "human": clip.human.to_json() })
}

impl Figures {
    /// `{FIGURE: number or null}`.
    pub fn to_json(&self) -> Value {
        let figures = Figure::ALL.iter().map(|f| (f.name().to_owned(), json!(self.get(*f))));
        Value::Object(figures.collect())
    }
}
