//! `handover check`: what files hold and what is wrong with them.

mod model;
mod parameters;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use handover_mesh::formats::rate;
use handover_mesh::{JointId, Part, PointTrack, Recording, Role, Side};
use serde_json::{Value, json};

use crate::Outcome;
use crate::args::Check;
use crate::files::{self, Fault, Loaded, ReadFile};
use crate::output::{Output, counted};
use model::ModelFile;
use parameters::ParameterFile;

/// Reads all files and says what is in each: the recordings, then the parameters, then the models.
pub(crate) fn run(check: &Check, output: &Output) -> anyhow::Result<Outcome> {
    let (parameters, others): (Vec<PathBuf>, Vec<PathBuf>) =
        check.files.iter().cloned().partition(|path| parameters::is_named_so(path));
    let (models, recordings): (Vec<PathBuf>, Vec<PathBuf>) =
        others.into_iter().partition(|path| files::is_model(path));
    let files = match recordings.as_slice() {
        [] => Vec::new(),
        recordings => files::read_all(recordings, &check.selection, output)?,
    };
    let parameters: Vec<ParameterFile> =
        parameters.into_iter().map(ParameterFile::read).collect::<anyhow::Result<_>>()?;
    let models: Vec<ModelFile> =
        models.into_iter().map(ModelFile::read).collect::<anyhow::Result<_>>()?;
    output.result(
        || {
            let parameters = parameters.iter().map(ParameterFile::text);
            files
                .iter()
                .map(text)
                .chain(parameters)
                .chain(models.iter().map(ModelFile::text))
                .collect()
        },
        || {
            let parameters = parameters.iter().map(ParameterFile::json);
            let values = files.iter().map(value).chain(parameters);
            json!({ "files": values.chain(models.iter().map(ModelFile::json)).collect::<Vec<_>>() })
        },
    )?;
    let all = files.len() + parameters.len() + models.len();
    let bad = files.iter().filter(|file| file.outcome.is_err()).count()
        + parameters.iter().filter(|file| file.outcome.is_err()).count()
        + models.iter().filter(|file| file.outcome.is_err()).count();
    if bad > 0 {
        output.note(&format!("{bad} of {all} files are bad"));
    }
    Ok(match bad {
        0 => Outcome::Done,
        bad if bad == all => Outcome::Failed,
        _ => Outcome::Loss,
    })
}

/// The two hands that come nearest each other, and when.
struct Closest {
    distance: f64,
    frame: usize,
    seconds: f64,
    hands: [String; 2],
}

fn closest_hands(recording: &Recording) -> Option<Closest> {
    let mut closest: Option<Closest> = None;
    let hands = |role| {
        let skeleton = recording.person(role).motion.skeleton();
        Side::BOTH.into_iter().filter_map(|side| skeleton.part(Part::Hand(side)))
    };
    let named = |role: Role, joint: JointId| {
        let person = recording.person(role);
        format!("{}/{}", person.name, person.motion.skeleton().name(joint))
    };
    for (frame, stamp) in recording.stamps().enumerate() {
        for first in hands(Role::First) {
            for second in hands(Role::Second) {
                let of = |role, joint| recording.person(role).motion.position(frame, joint);
                let distance = (of(Role::First, first) - of(Role::Second, second)).norm();
                if closest.as_ref().is_none_or(|closest| distance < closest.distance) {
                    let hands = [named(Role::First, first), named(Role::Second, second)];
                    closest = Some(Closest { distance, frame, seconds: stamp.seconds(), hands });
                }
            }
        }
    }
    closest
}

/// First to last frame, in seconds.
pub(crate) fn duration(recording: &Recording) -> f64 {
    let mut stamps = recording.stamps();
    let first = stamps.next();
    first.zip(stamps.last()).map_or(0.0, |(first, last)| (last - first).seconds())
}

fn bad_text(path: &Path, faults: &[Fault]) -> String {
    let lines = faults.iter().map(|fault| format!("  {}\n", fault.text()));
    format!("{}: BAD\n{}", path.display(), lines.collect::<String>())
}

fn bad_value(path: &Path, faults: &[Fault]) -> Value {
    let errors: Vec<_> = faults.iter().map(Fault::json).collect();
    json!({ "file": path.display().to_string(), "good": false, "errors": errors })
}

fn text(file: &ReadFile) -> String {
    let path = file.path.display();
    let Loaded { recording, format, losses, .. } = match &file.outcome {
        Ok(loaded) => loaded,
        Err(faults) => return bad_text(&file.path, faults),
    };
    let people = recording.people().each_ref().map(|person| {
        format!("{} ({})", person.name, counted(person.motion.skeleton().len(), "joint"))
    });
    let hz = rate(recording.stamps()).map_or("no rate".into(), |hz| format!("{hz:.1} Hz"));
    let mut text = format!(
        "{path}: {format}, {}, {}, {hz}, {:.2} s",
        people.join(" and "),
        counted(recording.len(), "frame"),
        duration(recording),
    );
    // Writing to a String cannot fail.
    if let Some(object) = recording.object() {
        for PointTrack { name, places } in &object.points {
            let _ = write!(text, ", object '{name}' in {}", counted(places.len(), "frame"));
        }
    }
    text.push('\n');
    if let Some(Closest { distance, frame, seconds, hands: [first, second] }) =
        closest_hands(recording)
    {
        let _ = writeln!(
            text,
            "  hands closest: {distance:.3} m, {first} and {second}, at {seconds:.3} s \
             (frame {frame})"
        );
    }
    for loss in losses {
        let _ = writeln!(text, "  lost: {loss}");
    }
    if !recording.metadata().is_empty() {
        let known = recording.metadata().iter().map(|(key, value)| format!("{key}={value}"));
        let _ = writeln!(text, "  {}", known.collect::<Vec<_>>().join(", "));
    }
    text
}

fn value(file: &ReadFile) -> Value {
    let path = file.path.display().to_string();
    let Loaded { recording, format, sha256, losses, notes, .. } = match &file.outcome {
        Ok(loaded) => loaded,
        Err(faults) => return bad_value(&file.path, faults),
    };
    let people = recording
        .people()
        .iter()
        .map(|person| json!({ "name": person.name, "joints": person.motion.skeleton().names() }));
    let object = recording.object().map(|object| {
        let names: Vec<&str> = object.points.iter().map(|point| point.name.as_str()).collect();
        let frames = object.points.iter().map(|point| point.places.len()).max();
        json!({ "name": names.join(" "), "frames": frames })
    });
    let closest = closest_hands(recording).map(|closest| {
        json!({
            "distance_m": closest.distance,
            "frame": closest.frame,
            "time_s": closest.seconds,
            "hands": closest.hands,
        })
    });
    json!({
        "file": path,
        "good": true,
        "errors": [],
        "name": recording.name(),
        "format": format.to_string(),
        "people": people.collect::<Vec<_>>(),
        "frames": recording.len(),
        "rate_hz": rate(recording.stamps()),
        "duration_s": duration(recording),
        "object": object,
        "closest_hands": closest,
        "metadata": recording.metadata(),
        "sha256": sha256,
        "losses": losses,
        "notes": notes,
    })
}
