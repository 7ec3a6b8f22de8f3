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
}

/// One figure of one method, over the clips where it is defined; `None` where it never is.
pub type SummaryOfFigure = Option<Summary>;

/// All clips and their summary.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// The protocol's name.
    pub protocol: &'static str,
    /// The clips, in their own order.
    pub clips: Vec<Clip>,
    /// Per method, in the columns' order, all figures in [`Figure::ALL`]'s order.
    pub summary: Vec<(Method, [SummaryOfFigure; Figure::ALL.len()])>,
}

impl Evaluation {
    /// Sums up the clips.
    pub(super) fn new(protocol: &'static str, methods: &[Method], clips: Vec<Clip>) -> Self {
        let summary = methods.iter().enumerate().map(|(column, method)| {
            let figures = Figure::ALL.map(|figure| {
                let values = clips.iter().filter_map(|clip| clip.methods[column].1.get(figure));
                // A hand that is early and one that is late do not make a punctual one.
                let size = |value: f64| if figure == Figure::Timing { value.abs() } else { value };
                Summary::of(&values.map(size).collect::<Vec<_>>())
            });
            (*method, figures)
        });
        let summary = summary.collect();
        Self { protocol, clips, summary }
    }

    /// `{"protocol","role","clips":[{"name","frames","methods":{METHOD:{FIGURE}}}],"summary":
    /// {METHOD:{FIGURE:{"mean","median","low","high","n"}}}}`; undefined figures are null.
    pub fn to_json(&self, role: &str) -> Value {
        let clips: Vec<Value> = self.clips.iter().map(clip_json).collect();
        let summary = self.summary.iter().map(|(method, figures)| {
            let figures = Figure::ALL.iter().zip(figures);
            let figures = figures.map(|(figure, summary)| {
                let value = summary.map_or(Value::Null, |s| {
                    json!({
                        "mean": s.mean, "median": s.median, "low": s.low, "high": s.high, "n": s.n
                    })
                });
                (figure.name().to_owned(), value)
            });
            (method.name().to_owned(), Value::Object(figures.collect()))
        });
        let summary: Map<String, Value> = summary.collect();
        json!({ "protocol": self.protocol, "role": role, "clips": clips, "summary": summary })
    }
}

fn clip_json(clip: &Clip) -> Value {
    let methods =
        clip.methods.iter().map(|(method, figures)| (method.name().to_owned(), figures.to_json()));
    let methods: Map<String, Value> = methods.collect();
    json!({ "name": clip.name, "frames": clip.frames, "methods": methods })
}

impl Figures {
    /// `{FIGURE: number or null}`.
    pub fn to_json(&self) -> Value {
        let figures = Figure::ALL.iter().map(|f| (f.name().to_owned(), json!(self.get(*f))));
        Value::Object(figures.collect())
    }
}
