//! An evaluation as a value, and as the JSON object that scripts rely on.

use serde_json::{Map, Value, json};

use super::{Figure, Figures};
use crate::predict::Method;
use crate::statistics::Summary;

/// One clip's figures by all methods.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// The clip.
    pub name: String,
    /// Its length in frames.
    pub frames: usize,
    /// The methods' figures, in the columns' order.
    pub methods: Vec<(Method, Figures)>,
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
    /// The clips, in their own order.
    pub clips: Vec<Clip>,
    /// Per method, in the columns' order.
    pub summary: Vec<(Method, Summaries)>,
    /// Of the humans in the robot's role.
    pub human: Summaries,
    /// Clips and methods without a prediction, each with its reason; their figures are undefined.
    pub failures: Vec<String>,
}

impl Evaluation {
    /// Sums up the clips.
    pub(super) fn new(
        protocol: &'static str,
        methods: &[Method],
        clips: Vec<Clip>,
        failures: Vec<String>,
    ) -> Self {
        let summary = methods.iter().enumerate().map(|(column, method)| {
            (*method, summaries(clips.iter().map(|clip| &clip.methods[column].1)))
        });
        let summary = summary.collect();
        let human = summaries(clips.iter().map(|clip| &clip.human));
        Self { protocol, clips, summary, human, failures }
    }

    /// `{"protocol","role","clips":[{"name","frames","methods":{METHOD:{FIGURE}},"human":{FIGURE}}],
    /// "summary":{METHOD:{FIGURE:{"mean","median","low","high","n"}}},"human":{FIGURE:{…}}}`;
    /// undefined figures are null.
    pub fn to_json(&self, role: &str) -> Value {
        let clips: Vec<Value> = self.clips.iter().map(clip_json).collect();
        let methods = self.summary.iter();
        let summary: Map<String, Value> = methods
            .map(|(method, summaries)| (method.name().to_owned(), summaries_json(summaries)))
            .collect();
        json!({
            "protocol": self.protocol,
            "role": role,
            "clips": clips,
            "summary": summary,
            "human": summaries_json(&self.human),
        })
    }
}

fn summaries<'a>(clips: impl Iterator<Item = &'a Figures> + Clone) -> Summaries {
    Figure::ALL.map(|figure| {
        // A hand that is early and one that is late do not make a punctual one.
        let size = |value: f64| if figure == Figure::Timing { value.abs() } else { value };
        let values = clips.clone().filter_map(|figures| figures.get(figure));
        Summary::of(&values.map(size).collect::<Vec<_>>())
    })
}

fn summaries_json(summaries: &Summaries) -> Value {
    let figures = Figure::ALL.iter().zip(summaries).map(|(figure, summary)| {
        let value = summary.map_or(Value::Null, |s| {
            json!({ "mean": s.mean, "median": s.median, "low": s.low, "high": s.high, "n": s.n })
        });
        (figure.name().to_owned(), value)
    });
    Value::Object(figures.collect())
}

fn clip_json(clip: &Clip) -> Value {
    let methods =
        clip.methods.iter().map(|(method, figures)| (method.name().to_owned(), figures.to_json()));
    let methods: Map<String, Value> = methods.collect();
    json!({ "name": clip.name, "frames": clip.frames, "methods": methods, "human": clip.human.to_json() })
}

impl Figures {
    /// `{FIGURE: number or null}`.
    pub fn to_json(&self) -> Value {
        let figures = Figure::ALL.iter().map(|f| (f.name().to_owned(), json!(self.get(*f))));
        Value::Object(figures.collect())
    }
}
