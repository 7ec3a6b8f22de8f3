//! `handover replay`: a recording's robot role, retargeted from demonstrations.

use std::fmt::Write as _;

use anyhow::{Context as _, bail};
use handover_mesh::demonstration::Demonstration;
use handover_mesh::evaluate::{Figure, Figures, Trial};
use handover_mesh::predict::{Method, Predictor};
use handover_mesh::{Config, Frame, Point, Sequence};
use serde_json::{Value, json};

use crate::args::{Replay, Selection};
use crate::demonstrations::{self, Loaded};
use crate::output::Output;
use crate::{Outcome, UsageError, files};

/// Loads, predicts, writes, prints.
pub(crate) fn run(replay: &Replay, config: &Config, output: &Output) -> anyhow::Result<Outcome> {
    let Replay { demonstrations, recording, selection, .. } = replay;
    let inputs = [demonstrations.clone(), recording.clone()];
    files::check_out(replay.out.as_deref(), "csv", &inputs)?;
    let load = |path, role: Option<&str>, selection: &Selection| {
        demonstrations::load(std::slice::from_ref(path), role, selection, config, output)
    };
    // Who learns from the answer need not find it.
    let others = Selection { except: Some(recording.clone()), ..selection.clone() };
    let Loaded { mut demonstrations, role, left_out, .. } =
        load(demonstrations, replay.role.as_deref(), &others)?;
    let replayed = load(recording, Some(&role), selection)?;
    let [truth] = replayed.demonstrations.as_slice() else {
        bail!(UsageError(format!("{}: replay takes one recording", recording.display())));
    };
    // The same scene under another path.
    let (scene, people) = (truth.recording().scene(), truth.recording().people());
    demonstrations.retain(|demonstration| {
        let recording = demonstration.recording();
        recording.scene() != scene && recording.people() != people
    });
    if demonstrations.is_empty() {
        bail!(
            "a recording does not learn from itself, and there is no other than {}",
            recording.display()
        );
    }
    let learnt_from = demonstrations.len();
    let predictor =
        Predictor::fit(demonstrations, config.predict.clone()).context("cannot learn")?;
    let method = Method::ALL.into_iter().find(|method| method.name() == replay.method);
    let (predicted, figures) = Trial::new(truth, &predictor, &config.ignored_joints)
        .and_then(|trial| Ok(trial.run(method.unwrap_or(Method::Mesh))?))
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
