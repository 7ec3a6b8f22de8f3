//! `handover replay`: a recording's robot role, retargeted from demonstrations or a model.

use std::fmt::Write as _;
use std::sync::Arc;

use anyhow::{Context as _, bail};
use handover_mesh::demonstration::Demonstration;
use handover_mesh::evaluate::{Figure, Figures, Trial, UnknownJoint};
use handover_mesh::learn::learn;
use handover_mesh::predict::{LearnedEdges, Method, Predictor};
use handover_mesh::{Config, Frame, Point, Sequence};
use serde_json::{Value, json};

use crate::args::{Global, Replay, Selection};
use crate::demonstrations::{self, Loaded};
use crate::output::Output;
use crate::{Outcome, UsageError, files};

/// What a replay knows before it sees the recording.
struct Known {
    demonstrations: Vec<Arc<Demonstration>>,
    role: String,
    config: Config,
    /// A model's; of demonstrations they are learned first.
    edges: Option<LearnedEdges>,
    left_out: usize,
}

/// Loads, learns, predicts, writes, prints.
pub(crate) fn run(
    replay: &Replay,
    global: &Global,
    config: &Config,
    output: &Output,
) -> anyhow::Result<Outcome> {
    let Replay { recording, selection, .. } = replay;
    let inputs = [replay.demonstrations.clone(), recording.clone()];
    files::check_out(replay.out.as_deref(), "csv", &inputs)?;
    let known = if files::is_model(&replay.demonstrations) {
        known_by_model(replay, global)?
    } else {
        known_by_demonstrations(replay, config, output)?
    };
    let Known { mut demonstrations, role, config, edges, left_out } = known;
    let paths = std::slice::from_ref(recording);
    let replayed = demonstrations::load(paths, Some(&role), selection, &config, output)?;
    let [truth] = replayed.demonstrations.as_slice() else {
        bail!(UsageError(format!("{}: replay takes one recording", recording.display())));
    };
    // The same scene under another path.
    let (scene, people) = (truth.recording().scene(), truth.recording().people());
    demonstrations.retain(|demonstration| {
        let recording = demonstration.recording();
        let other = recording.scene() != scene && recording.people() != people;
        if !other && edges.is_some() {
            let name = recording.name();
            output.note(&format!("left out: the model's {name}; its edges know it all the same"));
        }
        other
    });
    if demonstrations.is_empty() {
        bail!(
            "a recording does not learn from itself, and there is no other than {}",
            recording.display()
        );
    }
    let learnt_from = demonstrations.len();
    let method = Method::ALL.into_iter().find(|method| method.name() == replay.method);
    let method = method.unwrap_or(Method::Mesh);
    let predictor = predictor(demonstrations, edges, method, &config, output)?;
    let (predicted, figures) = Trial::new(truth, &predictor, None, &config.ignored_joints)
        .and_then(|trial| Ok(trial.run(method)?))
        .with_context(|| format!("cannot replay {}", recording.display()))?;
    if let Some(out) = &replay.out {
        let motion = motion(truth, &predicted)?;
        files::write(&truth.recording().with_motion(truth.robot_role(), motion)?, out)?;
        output.note(&format!("wrote {}", out.display()));
    }
    output.result(
        || text(truth, replay, &role, &figures),
        || {
            let mut value = json!({
                "recording": truth.recording().name(),
                "role": role,
                "method": replay.method,
                "demonstrations": learnt_from,
                "frames": truth.recording().len(),
            });
            merge(&mut value, figures.to_json());
            value
        },
    )?;
    Ok(if left_out == 0 { Outcome::Done } else { Outcome::Loss })
}

fn known_by_demonstrations(
    replay: &Replay,
    config: &Config,
    output: &Output,
) -> anyhow::Result<Known> {
    // Who learns from the answer need not find it.
    let others = Selection { except: Some(replay.recording.clone()), ..replay.selection.clone() };
    let (paths, role) = (std::slice::from_ref(&replay.demonstrations), replay.role.as_deref());
    let loaded = demonstrations::load(paths, role, &others, config, output)?;
    let Loaded { demonstrations, role, left_out, .. } = loaded;
    Ok(Known { demonstrations, role, config: config.clone(), edges: None, left_out })
}

fn known_by_model(replay: &Replay, global: &Global) -> anyhow::Result<Known> {
    let path = &replay.demonstrations;
    let shown = path.display();
    if global.config.is_some() || !global.set.is_empty() {
        bail!(UsageError(format!(
            "{shown}: a model has its own parameters; --config and --set do not go with it"
        )));
    }
    files::about(path)?;
    let model = files::read_model(path).map_err(|faults| {
        let faults: Vec<String> = faults.iter().map(files::Fault::text).collect();
        anyhow::anyhow!("{shown}: {}", faults.join("\n"))
    })?;
    let role = model.people()[model.robot_role() as usize];
    if let Some(other) = replay.role.as_deref().filter(|other| *other != role) {
        bail!(UsageError(format!("{shown}: the model's robot is {role}, not {other}")));
    }
    Ok(Known {
        demonstrations: model.demonstrations().to_vec(),
        role: role.to_owned(),
        config: model.config().clone(),
        edges: Some(model.edges().clone()),
        left_out: 0,
    })
}

/// Fits, and learns the edges where a method has some that are not known.
fn predictor(
    demonstrations: Vec<Arc<Demonstration>>,
    edges: Option<LearnedEdges>,
    method: Method,
    config: &Config,
    output: &Output,
) -> anyhow::Result<Predictor> {
    let groups = demonstrations::groups(&demonstrations, None)?;
    let predictor = Predictor::fit(demonstrations, config.predict.clone());
    let predictor = predictor.context("cannot learn")?;
    let edges = match edges {
        Some(edges) => edges,
        None if method != Method::Mesh => return Ok(predictor),
        None => {
            let count = groups.len();
            output.note(&format!("learning the edges between the people from {count} recordings"));
            let skeleton = predictor.demonstrations()[0].robot().skeleton();
            let ignored = UnknownJoint::find(skeleton, &config.ignored_joints)?;
            learn(&predictor, &groups, &ignored, &config.learn).context(
                "cannot learn the edges between the people (hint: --method none has none)",
            )?
        }
    };
    Ok(predictor.with_edges(edges))
}

/// Predicted positions on the recording's own stamps.
fn motion(truth: &Demonstration, predicted: &[Point]) -> anyhow::Result<Sequence> {
    let robot = truth.robot();
    let poses = predicted.chunks_exact(robot.skeleton().len());
    let frames = robot.stamps().zip(poses);
    let frames = frames.map(|(stamp, pose)| Frame { stamp, positions: pose.into() });
    Ok(Sequence::new(robot.skeleton().clone(), frames.collect())?)
}

fn text(truth: &Demonstration, replay: &Replay, role: &str, figures: &Figures) -> String {
    let recording = truth.recording();
    let mut text = format!(
        "{}: {} frames, the robot is {role}, method {}\n",
        recording.name(),
        recording.len(),
        replay.method
    );
    for figure in Figure::ALL {
        let value = figures.get(figure).map_or("-".to_owned(), |value| format!("{value:.2}"));
        let _ = writeln!(text, "{:>18} {value:>8}", figure.name());
    }
    text
}

fn merge(object: &mut Value, more: Value) {
    if let (Value::Object(object), Value::Object(more)) = (object, more) {
        object.extend(more);
    }
}
