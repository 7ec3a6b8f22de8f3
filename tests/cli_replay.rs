//! `handover replay` as a user meets it: the real process, its files, its exit code, its words and
//! its JSON.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

#[path = "common/clips.rs"]
mod clips;
mod common;

use std::collections::BTreeSet;
use std::fs;
use std::sync::Arc;

use clips::{FIGURES, FRAMES, METHODS, clips, keys};
use common::{check, check_json};
use handover_mesh::formats::{UpAxis, csv};
use handover_mesh::safety::{HoldReason, SafetySettings};
use handover_mesh::{Frame, Person, Recording, Role, Sequence, Stamp, Vector};
use serde_json::{Map, Value, json};
use tempfile::TempDir;

/// Few references and few steps, all of which are taken: the least that has everything; and no
/// more latent dimensions than clean made-up moments span.
const SETTINGS: [&str; 8] = [
    "--set",
    "learn.references=1",
    "--set",
    "learn.tolerance=0",
    "--set",
    "learn.steps=3",
    "--set",
    "track.dimensions=4",
];
/// What is said beside the figures.
const SAID: [&str; 9] = [
    "recording",
    "role",
    "method",
    "demonstrations",
    "frames",
    "ticks",
    "held",
    "held_by",
    "tick_us",
];

/// `learn clips -o m.safetensors` with [`SETTINGS`] and more.
fn learn<'a>(more: &[&'a str]) -> Vec<&'a str> {
    ["learn", "clips", "-o", "m.safetensors"]
        .into_iter()
        .chain(SETTINGS)
        .chain(more.iter().copied())
        .collect()
}

/// Clips, the last of them `new.csv` apart, and a model without edges of the others.
fn model() -> TempDir {
    let folder = clips(4);
    let path = |path: &str| folder.path().join(path);
    fs::rename(path("clips/3.csv"), path("new.csv")).unwrap();
    check(&folder, &learn(&["--method", "none"]), 0, &[]);
    folder
}

/// What a replay says, but for how long its ticks took.
#[track_caller]
fn replay(folder: &TempDir, arguments: &[&str]) -> Map<String, Value> {
    let found = check_json(folder, &[&["replay"], arguments, &["--json"]].concat(), 0);
    let mut found = found.as_object().unwrap().clone();
    assert!(found.remove("tick_us").is_some());
    found
}

fn bytes(folder: &TempDir, path: &str) -> Vec<u8> {
    fs::read(folder.path().join(path)).unwrap()
}

/// A trace's first line and the others.
fn trace(folder: &TempDir, path: &str) -> (Value, Vec<Value>) {
    let text = String::from_utf8(bytes(folder, path)).unwrap();
    let mut lines = text.lines().map(|line| serde_json::from_str(line).unwrap());
    (lines.next().unwrap(), lines.collect())
}

fn read(folder: &TempDir, path: &str) -> Recording {
    csv::read(&bytes(folder, path), "clip", UpAxis::Z).unwrap()
}

/// Whether every figure is there; a hand that does not reach is neither early nor late.
fn is_measured(found: &Value) -> bool {
    FIGURES.iter().all(|figure| *figure == "reach_ms" || found[*figure].is_number())
}

#[test]
fn the_json_has_the_promised_shape() {
    let folder = model();
    let promised: Vec<&str> = SAID.into_iter().chain(FIGURES).collect();
    let say = |more: &[&str]| {
        let arguments = [&["replay", "m.safetensors", "new.csv", "--json"], more].concat();
        let found = check_json(&folder, &arguments, 0);
        assert_eq!(keys(&found), promised);
        assert_eq!((&found["frames"], &found["demonstrations"]), (&json!(FRAMES), &json!(3)));
        assert!(is_measured(&found), "{found}");
        found
    };
    let ticked = say(&[]);
    assert_eq!(keys(&ticked["tick_us"]), ["p50", "p99", "max"]);
    let [median, p99, max] = ["p50", "p99", "max"].map(|key| ticked["tick_us"][key].as_f64());
    assert!(Some(0.0) < median && median <= p99 && p99 <= max, "{ticked}");
    assert_eq!(ticked["ticks"], FRAMES);
    let held_by = ticked["held_by"].as_object().unwrap().values();
    assert_eq!(ticked["held"], held_by.map(|frames| frames.as_u64().unwrap()).sum::<u64>());
    for without in [&["--method", "knn"][..], &["--whole"], &["--method", "hold", "--whole"]] {
        let found = say(without);
        assert!(SAID[5..].iter().all(|key| found[key].is_null()), "{found}");
    }
    let words = ["new: 24 frames, the robot is giver, method mesh", "24 ticks of", "held at"];
    check(&folder, &["replay", "m.safetensors", "new.csv"], 0, &words);
    // Ticks between the frames.
    let often = ["m.safetensors", "new.csv", "--set", "tick.rate=120"];
    assert_eq!(replay(&folder, &often)["ticks"], 4 * (FRAMES - 1) + 1);
}

#[test]
fn what_nobody_knows_is_null() {
    let folder = clips(3);
    let ignored = "evaluate.ignored_joints=[head,neck,left_shoulder,left_elbow,left_hand,\
        right_shoulder,right_elbow,right_hand]";
    let arguments = ["clips", "clips/0.csv", "--method", "none", "--set", ignored];
    let found = replay(&folder, &[&arguments[..], &SETTINGS].concat());
    assert!(found["joint_cm"].is_null() && found["hand_cm"].is_number(), "{found:?}");
}

/// The very same clip, learned from the very same others.
#[test]
fn a_replay_is_one_clip_of_an_evaluation() {
    let folder = clips(4);
    let evaluate = ["evaluate", "clips", "--protocol", "leave_one_out", "--json"];
    let evaluate = [&evaluate[..], &["--methods", "knn,attach,none"], &SETTINGS].concat();
    for (of_evaluate, of_replay) in [(&["--causal"][..], &[][..]), (&[], &["--whole"])] {
        let all = check_json(&folder, &[&evaluate[..], of_evaluate].concat(), 0);
        for method in ["knn", "attach", "none"] {
            let one = ["clips", "clips/1.csv", "--method", method];
            let one = replay(&folder, &[&one[..], of_replay, &SETTINGS].concat());
            let clip = &all["clips"][1]["methods"][method];
            assert!(FIGURES.iter().all(|figure| clip[figure] == one[*figure]), "{clip} {one:?}");
        }
    }
}

#[test]
fn a_trace_is_the_same_in_every_run() {
    let folder = model();
    let write = |jobs: &str| {
        let arguments = ["replay", "m.safetensors", "new.csv", "-o", "trace.jsonl", "--jobs", jobs];
        check(&folder, &arguments, 0, &["wrote trace.jsonl"]);
        bytes(&folder, "trace.jsonl")
    };
    let first = write("1");
    assert!(first == write("2") && first == write("2"), "the same bytes");

    let (header, ticks) = trace(&folder, "trace.jsonl");
    assert_eq!((&header["format"], &header["version"]), (&"handover_trace".into(), &json!(1)));
    assert_eq!((&header["recording"], &header["role"]), (&"new".into(), &"giver".into()));
    let joints = read(&folder, "new.csv").person(Role::First).motion.skeleton().names().to_vec();
    assert_eq!(
        (&header["robot_joints"], &header["partner_joints"]),
        (&json!(joints), &json!(joints))
    );
    assert_eq!(header["demonstrations"], json!(["0", "1", "2"]));
    assert_eq!(header["parameters"]["tick.rate"], 30.0);
    assert_eq!(ticks.len(), FRAMES as usize);
    let names = [
        "now",
        "sighting",
        "robot",
        "partner",
        "seen",
        "phase",
        "reference",
        "solution",
        "residual",
        "target",
        "stands_in",
        "reason",
    ];
    let partner = read(&folder, "new.csv").person(Role::Second).motion.clone();
    for (tick, frame) in ticks.iter().zip(partner.frames()) {
        assert_eq!(keys(tick), names);
        assert_eq!(
            (&tick["now"], &tick["sighting"]["stamp"]),
            (&json!(frame.stamp.0), &tick["now"])
        );
        let seen = frame.positions.iter().map(|p| json!([p.x, p.y, p.z]));
        assert_eq!(tick["sighting"]["positions"], Value::Array(seen.collect()), "to the bit");
        assert_eq!(tick["target"].as_array().unwrap().len(), joints.len());
    }
    assert!(ticks.iter().any(|tick| tick["reason"].is_null() && tick["solution"].is_array()));

    // How long they took stands beside it.
    let times = String::from_utf8(bytes(&folder, "trace.ticks.csv")).unwrap();
    let mut times = times.lines().map(|line| line.split(',').collect::<Vec<_>>());
    assert_eq!(times.next().unwrap(), ["tick", "now_ns", "tick_us", "reason"]);
    let times: Vec<Vec<&str>> = times.collect();
    assert_eq!(times.len(), ticks.len());
    for (number, (row, tick)) in times.iter().zip(&ticks).enumerate() {
        assert_eq!((row[0], row[1]), (&*number.to_string(), &*tick["now"].to_string()));
        assert!(row[2].parse::<f64>().unwrap() > 0.0);
        assert_eq!(row[3], tick["reason"].as_str().unwrap_or(""));
    }
    let left: Vec<_> =
        fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(left.iter().all(|name| !name.to_string_lossy().ends_with(".tmp")), "{left:?}");
}

/// The keys of a value and of all in it, as `outer.inner`; those of a list's are without `outer`.
fn names_in(value: &Value, outer: &str, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(values) => {
            for (key, value) in values {
                let name = format!("{outer}{key}");
                // Parameters are explained elsewhere.
                if key != "parameters" {
                    names_in(value, &format!("{name}."), names);
                }
                if value.as_object().is_none_or(|inner| inner.is_empty() || key == "parameters") {
                    names.insert(name);
                }
            }
        }
        Value::Array(values) => values.iter().for_each(|value| names_in(value, "", names)),
        _ => {}
    }
}

#[test]
fn every_key_and_reason_of_a_trace_is_explained() {
    let folder = model();
    check(&folder, &["replay", "m.safetensors", "new.csv", "-o", "t.jsonl"], 0, &[]);
    let (header, ticks) = trace(&folder, "t.jsonl");
    let mut names = BTreeSet::new();
    names_in(&header, "", &mut names);
    ticks.iter().for_each(|tick| names_in(tick, "", &mut names));
    assert!(
        names.len() > 35 && names.contains("phase.tempo") && names.contains("yaw"),
        "{names:?}"
    );
    let reasons = HoldReason::ALL.map(|reason| reason.name().to_owned());
    let explained = include_str!("../docs/trace.md");
    let rows: Vec<&str> = explained.lines().filter(|line| line.starts_with("| `")).collect();
    for name in names.into_iter().chain(reasons) {
        let cell = |row: &&str| row.split(" | ").next().unwrap().contains(&format!("`{name}`"));
        assert!(rows.iter().any(cell), "no row of docs/trace.md explains {name}");
    }
    check(&folder, &["replay", "--help"], 0, &["docs/trace.md", "no measurement"]);
    assert!(include_str!("../README.md").contains("](docs/trace.md)"));
}

/// The targets' speed, acceleration and jerk at most, of any joint, by divided differences.
fn fastest(ticks: &[Value]) -> [f64; 3] {
    let number = |value: &Value| value.as_f64().unwrap();
    let points = |tick: &Value| -> Vec<Vector> {
        let points = tick["target"].as_array().unwrap().iter();
        points.map(|p| Vector::new(number(&p[0]), number(&p[1]), number(&p[2]))).collect()
    };
    let step = (number(&ticks[1]["now"]) - number(&ticks[0]["now"])) / 1e9;
    let mut places: Vec<Vec<Vector>> = ticks.iter().map(points).collect();
    [1, 2, 3].map(|_| {
        let differences = places.windows(2).map(|two| {
            two[1].iter().zip(&two[0]).map(|(after, before)| (after - before) / step).collect()
        });
        places = differences.collect();
        places.iter().flatten().map(Vector::norm).fold(0.0, f64::max)
    })
}

#[test]
fn targets_of_a_trace_obey_the_limits() {
    let folder = model();
    let run = |more: &[&str]| {
        let arguments = ["replay", "m.safetensors", "new.csv", "-o", "t.jsonl"];
        check(&folder, &[&arguments[..], more].concat(), 0, &[]);
        let (header, ticks) = trace(&folder, "t.jsonl");
        (header["parameters"]["safety.speed"].clone(), fastest(&ticks))
    };
    let SafetySettings { speed, acceleration, jerk, .. } = SafetySettings::default();
    let (said, free) = run(&[]);
    assert_eq!(said, speed);
    // Places are written to a micrometre: as much for a step's error.
    let within = |found: [f64; 3], speed: f64| {
        let limits = [speed + 1e-4, acceleration + 0.01, jerk + 0.5];
        assert!(found.iter().zip(limits).all(|(found, limit)| *found <= limit), "{found:?}");
    };
    within(free, speed);
    assert!(free[0] > 0.3, "it moves: {free:?}");
    let (said, slow) = run(&["--set", "safety.speed=0.2"]);
    assert_eq!(said, 0.2);
    within(slow, 0.2);
}

/// A clip over and over: `frames` of it.
fn repeated(clip: &Recording, frames: usize) -> Recording {
    let people = clip.people().clone().map(|person| {
        let motion = &person.motion;
        let frames = (0..frames).map(|k| {
            let positions = motion.frames()[k % motion.len()].positions.clone();
            Frame { stamp: Stamp(k as i64 * 33_333_333), positions }
        });
        let skeleton = Arc::clone(motion.skeleton());
        Person { motion: Sequence::new(skeleton, frames.collect()).unwrap(), ..person }
    });
    Recording::new("long", people, None, Default::default()).unwrap()
}

#[test]
fn ten_minutes_of_trace_are_less_than_100_megabytes() {
    let folder = model();
    let long = repeated(&read(&folder, "new.csv"), 200);
    let joints = long.people()[0].motion.skeleton().len();
    fs::write(folder.path().join("long.csv"), csv::write(&long).unwrap()).unwrap();
    let arguments = ["replay", "m.safetensors", "long.csv", "-o", "t.jsonl", "--method", "none"];
    check(&folder, &arguments, 0, &[]);
    let size = fs::metadata(folder.path().join("t.jsonl")).unwrap().len() as f64;
    // The made-up people have fewer joints than a sensor sees.
    let whole = size / 200.0 * 15.0 / joints as f64 * 30.0 * 600.0;
    assert!(whole < 100e6, "{:.1} MB", whole / 1e6);
}

#[test]
fn usage_errors_say_what_there_is() {
    let folder = clips(2);
    let wrong = |more: &[&str], words: &[&str]| {
        check(&folder, &[&["replay", "clips", "clips/0.csv"], more].concat(), 2, words);
    };
    wrong(&["-o", "r.txt"], &["r.txt", ".csv", ".jsonl"]);
    wrong(&["--method", "magic"], &["magic"]);
    wrong(&["-o", "clips/0.csv"], &["clips/0.csv is an input"]);
    wrong(&["-o", "no/o.csv"], &["no folder no"]);
    wrong(&["-o", "no/o.jsonl"], &["no folder no"]);
    wrong(&["-o", "t.jsonl", "--whole"], &["t.jsonl: --whole has no ticks to write down"]);
    wrong(&["-o", "t.jsonl", "--method", "knn"], &["t.jsonl: --method knn has no ticks"]);
    wrong(&["-o", "clips/t.jsonl"], &["clips/t.ticks.csv: would be taken for a recording"]);
    let alone = ["replay", "clips/0.csv", "clips/0.csv"];
    check(&folder, &alone, 1, &["not learn from itself", "clips/0.csv"]);
}

#[test]
fn the_robots_parameters_win_over_a_models() {
    let folder = clips(3);
    let settings = ["--method", "none", "--set", "safety.lead=0.02", "--set", "safety.aim=0.4"];
    check(&folder, &learn(&settings), 0, &[]);
    let replay = |more: &[&str], code: i32, words: &[&str]| {
        let arguments = ["replay", "m.safetensors", "clips/0.csv", "-o", "t.jsonl"];
        check(&folder, &[&arguments[..], more].concat(), code, words);
        let parameters = || trace(&folder, "t.jsonl").0["parameters"].clone();
        if code == 0 { parameters() } else { Value::Null }
    };
    let own = replay(&[], 0, &[]);
    assert_eq!((&own["safety.lead"], &own["safety.aim"]), (&json!(0.02), &json!(0.4)));
    // Checked beside the model's own aim, not beside the default's.
    let leading = replay(&["--set", "safety.lead=0.3"], 0, &[]);
    assert_eq!((&leading["safety.lead"], &leading["safety.aim"]), (&json!(0.3), &json!(0.4)));
    replay(&["--set", "safety.lead=0.45"], 2, &["safety.aim is 0.4, must be at least"]);
    let write = |text: &str| fs::write(folder.path().join("p.yaml"), text).unwrap();
    write("/**:\n  ros__parameters:\n    filter: {stale: 0.3}\n    mesh: {scale: 30}\n");
    let filtered = replay(&["--config", "p.yaml", "--set", "tick.rate=60"], 0, &[]);
    assert_eq!((&filtered["filter.stale"], &filtered["tick.rate"]), (&json!(0.3), &json!(60.0)));
    write("/**:\n  ros__parameters:\n    filter: {stale: 0.3}\n    mesh: {scale: 3, power: 2}\n");
    let refused = [
        "m.safetensors: a model has its own parameters, there mesh.scale is 30.0, not 3.0, \
         mesh.power is 4.0, not 2.0;",
        "for tick, filter, track, window, safety only",
    ];
    replay(&["--config", "p.yaml"], 2, &refused);
    replay(&["--set", "mesh.colour=3"], 2, &["mesh.colour is no parameter"]);
    replay(&["--config", "no.yaml"], 1, &["cannot read no.yaml"]);
}

#[test]
fn a_replayed_robot_keeps_its_bones() {
    let folder = clips(4);
    let arguments = ["replay", "clips", "clips/2.csv", "-o", "out.csv"];
    let arguments = [&arguments[..], &SETTINGS].concat();
    check(&folder, &arguments, 0, &["2: 24 frames, the robot is giver, method mesh", "out.csv"]);
    check(&folder, &["check", "out.csv"], 0, &["24 frames", "pair=second"]);
    let (truth, replayed) = (read(&folder, "clips/2.csv"), read(&folder, "out.csv"));
    assert_eq!(replayed.person(Role::Second), truth.person(Role::Second), "the partner's own");
    let (own, motion) = (&truth.person(Role::First).motion, &replayed.person(Role::First).motion);
    for (bone, length) in motion.skeleton().bones().zip(own.bone_lengths()) {
        for frame in 0..motion.len() {
            let [a, b] = [bone.parent, bone.child].map(|joint| motion.position(frame, joint));
            assert!(((a - b).norm() - length).abs() < 1e-9, "frame {frame}");
        }
    }
    assert_ne!(motion, own, "predicted, not copied");
}

#[test]
fn a_replay_does_not_learn_from_its_own_recording() {
    let folder = clips(4);
    let by = |demonstrations| {
        replay(&folder, &[&[demonstrations, "clips/2.csv"], &SETTINGS[..]].concat())
    };
    let among = by("clips");
    assert_eq!(among["demonstrations"], 3);
    fs::create_dir(folder.path().join("others")).unwrap();
    for name in ["0.csv", "1.csv", "3.csv"] {
        let at = |part: &str| folder.path().join(part).join(name);
        fs::copy(at("clips"), at("others")).unwrap();
    }
    assert_eq!(among, by("others"));
}

#[test]
fn replay_takes_one_recording() {
    let folder = clips(3);
    check(&folder, &["replay", "clips", "clips"], 2, &["replay takes one recording"]);
    check(&folder, &["replay", "clips", "no.csv"], 1, &["no.csv: no such file or folder"]);
}

#[test]
fn the_same_scene_under_another_path_is_not_learnt_from() {
    let folder = clips(3);
    fs::copy(folder.path().join("clips/0.csv"), folder.path().join("copy.csv")).unwrap();
    let by_clips = |recording| replay(&folder, &[&["clips", recording], &SETTINGS[..]].concat());
    let found = by_clips("copy.csv");
    assert_eq!(found["demonstrations"], 2, "the copy's original is left out");
    check(&folder, &["replay", "clips/0.csv", "copy.csv"], 1, &["not learn from itself"]);

    // Two sensors' views of one scene: the same name for it, other numbers in it.
    for (view, number) in [("left", 0), ("right", 1)] {
        let text = fs::read_to_string(folder.path().join(format!("clips/{number}.csv"))).unwrap();
        let path = folder.path().join(format!("clips/{view}.csv"));
        fs::write(path, format!("# scene=studio\n{text}")).unwrap();
    }
    let found = by_clips("clips/left.csv");
    assert_eq!(found["demonstrations"], 2, "neither the other view nor the same people");
    fs::remove_file(folder.path().join("clips/2.csv")).unwrap();
    fs::remove_file(folder.path().join("clips/1.csv")).unwrap();
    fs::remove_file(folder.path().join("clips/0.csv")).unwrap();
    let evaluate = ["evaluate", "clips", "--protocol", "leave_one_out"];
    check(&folder, &evaluate, 1, &["1 group"]);
}

#[test]
fn a_model_replays_as_its_demonstrations_do() {
    let folder = clips(4);
    let path = |path: &str| folder.path().join(path);
    fs::rename(path("clips/3.csv"), path("new.csv")).unwrap();
    check(&folder, &learn(&["--set", "evaluate.ignored_joints=[head]"]), 0, &[]);
    let settings = [&SETTINGS[..], &["--set", "evaluate.ignored_joints=[head]"]].concat();
    let mut gaps = Vec::new();
    let methods = METHODS[5..].iter().map(|method| vec!["--method", *method]);
    for method in methods.chain([vec!["--whole"]]) {
        let by_model = replay(&folder, &[&["m.safetensors", "new.csv"], &method[..]].concat());
        let learned_first =
            replay(&folder, &[&["clips", "new.csv"], &method[..], &settings].concat());
        assert_eq!(by_model, learned_first);
        assert_eq!((&by_model["demonstrations"], &by_model["frames"]), (&json!(3), &json!(FRAMES)));
        assert!(is_measured(&by_model.clone().into()), "{by_model:?}");
        gaps.push(by_model["gap_cm"].clone());
    }
    assert_ne!(gaps[1], gaps[2], "the edges say something");
    let out = ["replay", "m.safetensors", "new.csv", "-o", "out.csv"];
    check(&folder, &out, 0, &["method mesh", "wrote out.csv"]);
    check(&folder, &["check", "out.csv"], 0, &["24 frames"]);
}

#[test]
fn a_model_brings_its_own_parameters_and_role() {
    let folder = clips(4);
    check(&folder, &learn(&["--role", "receiver"]), 0, &[]);
    let replay = |more: &[&str], code: i32, words: &[&str]| {
        check(&folder, &[&["replay", "m.safetensors", "clips/3.csv"], more].concat(), code, words)
    };
    let known = "left out: the model's 3; its edges know it all the same";
    replay(&[], 0, &["the robot is receiver", known]);
    replay(&["--role", "receiver"], 0, &[]);
    replay(&["--role", "giver"], 2, &["the model's robot is receiver, not giver"]);
    replay(&["--set", "mesh.scale=3"], 2, &["a model has its own parameters"]);
    fs::write(folder.path().join("p.yaml"), "/**:\n  ros__parameters: {}\n").unwrap();
    replay(&["--config", "p.yaml"], 0, &[]);
    check(&folder, &["replay", "no.safetensors", "clips/3.csv"], 1, &["no.safetensors: no such"]);
    fs::write(folder.path().join("m.safetensors"), "nothing").unwrap();
    replay(&[], 1, &["m.safetensors: no safetensors file"]);
    let alone = ["replay", "clips/0.csv", "clips/1.csv"];
    check(&folder, &alone, 1, &["cannot learn the edges", "two groups", "--method none"]);
    check(&folder, &[&alone[..], &["--method", "none"], &SETTINGS].concat(), 0, &[]);
}

/// The same text with y up.
fn with_y_up(text: &str) -> String {
    let line = |line: &str| -> String {
        let mut fields: Vec<&str> = line.split(',').collect();
        let is_row = line.starts_with(|first: char| first.is_ascii_digit());
        let Some([_, y, _]) = fields.last_chunk().copied().filter(|_| is_row) else {
            return line.to_owned() + "\n";
        };
        let minus_y = y.strip_prefix('-').map_or(format!("-{y}"), str::to_owned);
        let at = fields.len() - 2;
        fields.swap(at, at + 1);
        fields[at + 1] = &minus_y;
        fields.join(",") + "\n"
    };
    text.lines().map(line).collect()
}

#[test]
fn whoever_lies_is_noted_with_the_axis_that_would_have_them_stand() {
    let folder = clips(4);
    let path = |path: &str| folder.path().join(path);
    fs::create_dir(path("turned")).unwrap();
    for number in 0..4 {
        let text = fs::read_to_string(path(&format!("clips/{number}.csv"))).unwrap();
        fs::write(path(&format!("turned/{number}.csv")), with_y_up(&text)).unwrap();
    }
    let said =
        |arguments: &[&str]| String::from_utf8(check(&folder, arguments, 0, &[]).stderr).unwrap();
    let lying = "note: turned/0.csv and 3 more: people lie on their sides (hint: --up y)\n";
    let evaluate = ["--protocol", "leave_one_out", "--methods", "hold"];
    let model = ["-o", "m.safetensors", "--method", "none", "--up", "y"];
    for (command, more) in [("check", &[][..]), ("evaluate", &evaluate), ("learn", &model[..4])] {
        let of = |folder, axis| said(&[&[command, folder, "--up", axis], more].concat());
        assert_eq!(of("turned", "z").matches("people lie").count(), 1);
        assert!(of("turned", "z").contains(lying), "{command}");
        let other = "note: clips/0.csv and 3 more: people lie on their sides (hint: --up z)\n";
        assert!(of("clips", "y").contains(other), "{command}");
        for right in [of("turned", "y"), of("clips", "z")] {
            assert!(!right.contains("people lie"), "{command}: {right}");
        }
    }
    said(&[&["learn", "turned"], &model[..]].concat());
    let replay =
        |more: &[&str]| said(&[&["replay", "m.safetensors", "turned/3.csv"], more].concat());
    assert!(replay(&[]).contains("note: turned/3.csv: people lie on their sides (hint: --up y)"));
    assert!(!replay(&["--quiet"]).contains("people lie"));
    assert!(!replay(&["--up", "y"]).contains("people lie"));
}
