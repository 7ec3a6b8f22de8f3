//! `handover learn` as a user meets it: the real process, its files, its exit code and its words.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

#[expect(dead_code, reason = "what the figures are called is for other tests")]
#[path = "common/clips.rs"]
mod clips;
mod common;

use std::fs;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use clips::{clips, keys};
use common::{check, check_json};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Few references and few steps, all of which are taken: the least that has everything.
const SETTINGS: [&str; 6] =
    ["--set", "learn.references=1", "--set", "learn.tolerance=0", "--set", "learn.steps=3"];
const LOG: [&str; 2] = ["--log", "steps.jsonl"];

/// `learn clips -o m.safetensors` with [`SETTINGS`] and more.
fn learn<'a>(more: &[&'a str]) -> Vec<&'a str> {
    ["learn", "clips", "-o", "m.safetensors"]
        .into_iter()
        .chain(SETTINGS)
        .chain(more.iter().copied())
        .collect()
}

fn bytes(folder: &TempDir, path: &str) -> Vec<u8> {
    fs::read(folder.path().join(path)).unwrap()
}

fn remove(folder: &TempDir, path: &str) {
    fs::remove_file(folder.path().join(path)).unwrap();
}

#[test]
fn the_json_of_learning_has_the_promised_shape() {
    let folder = clips(4);
    let found = check_json(&folder, &learn(&["--json"]), 0);
    let promised = ["method", "candidates", "evaluations", "seconds", "initial", "final", "steps"];
    assert_eq!(keys(&found)[..8], [&promised[..], &["held_out"]].concat());
    assert_eq!((&found["method"], &found["candidates"]), (&json!("grow"), &json!(81)));
    let number = |key: &str| found[key].as_f64().unwrap();
    let steps = found["steps"].as_array().unwrap();
    assert_eq!(steps.len(), 3);
    let mut before = number("initial");
    for step in steps {
        assert_eq!(keys(step), ["edge", "move", "before", "distance"]);
        let joint = |end: usize| step["edge"][end].as_str().unwrap();
        assert!(joint(0).starts_with("giver/") && joint(1).starts_with("receiver/"), "{step}");
        assert_eq!(step["move"], "add");
        assert!((step["before"].as_f64().unwrap() - before).abs() < 1e-9);
        let distance = step["distance"].as_f64().unwrap();
        assert!(distance < before, "{step}");
        before = distance;
    }
    assert_eq!(found["steps"][0]["edge"], json!(["giver/right_hand", "receiver/right_hand"]));
    assert_eq!(number("final"), before);
    // Once as it stands, then what is left to add.
    assert_eq!(found["evaluations"], 1 + 81 + 80 + 79);
    assert!(number("seconds") > 0.0 && number("held_out") != number("held_out_initial"));
    assert_eq!((&found["role"], &found["kernel"]), (&json!("giver"), &json!("inverse_distance")));
    assert_eq!(
        (found["references"].as_array().unwrap().len(), &found["demonstrations"]),
        (1, &json!(4))
    );
    let edges = found["edges"].as_array().unwrap();
    assert!(edges.len() == 3 && edges.iter().all(|edge| edge["factors"] == json!([1.0])));

    let model = &check_json(&folder, &["check", "m.safetensors", "--json"], 0)["files"][0];
    assert_eq!(model["edges"], found["edges"]);
    let training = &model["training"];
    assert_eq!((&training["method"], &training["steps"]), (&json!("grow"), &json!(3)));
    assert_eq!(training["evaluations"], found["evaluations"]);
    assert_eq!(training["initial_distance_m"], found["initial"]);
    assert_eq!(training["final_distance_m"], found["final"]);
    assert_eq!(training["held_out_distance_m"], found["held_out"]);
    assert_eq!(model["config"]["learn.references"], 1);
    let names: Vec<&Value> =
        model["demonstrations"].as_array().unwrap().iter().map(|d| &d["name"]).collect();
    assert_eq!(names, ["0", "1", "2", "3"]);
}

#[test]
fn the_text_shows_steps_and_distances() {
    let folder = clips(4);
    let words = [
        "   1  add     giver/right_hand - receiver/right_hand",
        "learned from             1",
        "held out                 1",
        "grow: 3 edges of 81 candidates, 241 evaluations",
        "wrote m.safetensors",
    ];
    check(&folder, &learn(&[]), 0, &words);
    let quiet = check(&folder, &learn(&["--quiet"]), 0, &["grow: 3 edges"]);
    assert_eq!(String::from_utf8_lossy(&quiet.stderr), "");
}

#[test]
fn methods_and_kernels_go_over_the_parameters() {
    let folder = clips(3);
    let learn = |more: &[&str]| {
        let arguments = [&["--json", "--set", "learn.method=prune", "--set", "mesh.scale=7"], more];
        check_json(&folder, &learn(&arguments.concat()), 0)
    };
    let none = learn(&["--method", "none"]);
    assert_eq!(
        (&none["method"], &none["steps"], &none["evaluations"]),
        (&json!("none"), &json!([]), &json!(1))
    );
    assert_eq!((&none["final"], &none["edges"]), (&none["initial"], &json!([])));
    assert_eq!(none["held_out"], none["held_out_initial"]);
    check(&folder, &["check", "m.safetensors"], 0, &["learned by none", "mesh.scale is 7.0"]);
    let pruned = learn(&["--kernel", "uniform"]);
    assert_eq!((&pruned["method"], &pruned["kernel"]), (&json!("prune"), &json!("uniform")));
    assert_eq!(pruned["steps"][0]["move"], "remove");
    check(
        &folder,
        &["check", "m.safetensors"],
        0,
        &["kernel uniform\n", "mesh.kernel is \"uniform\""],
    );
    let uniform = ["--set", "mesh.kernel=uniform", "--kernel", "inverse_distance"];
    learn(&[&uniform[..], &["--method", "none"]].concat());
    check(&folder, &["check", "m.safetensors"], 0, &["kernel 7 * "]);
    let other = self::learn(&["--method", "guess"]);
    check(&folder, &other, 2, &["guess", "none, grow, prune, grow_prune, gradient"]);
    check(&folder, &self::learn(&["--kernel", "cotangent"]), 2, &["uniform, inverse_distance"]);
}

#[test]
fn order_and_threads_change_no_byte_of_a_model() {
    let folder = clips(4);
    let learned = |demonstrations: &[&str], jobs: &str| {
        let rest = ["-o", "m.safetensors", "--log", "steps.jsonl", "--jobs", jobs];
        let arguments = [&["learn"], demonstrations, &rest, &SETTINGS].concat();
        check(&folder, &arguments, 0, &[]);
        let both = (bytes(&folder, "m.safetensors"), bytes(&folder, "steps.jsonl"));
        remove(&folder, "steps.jsonl");
        both
    };
    let folder_alone = learned(&["clips"], "1");
    assert!(folder_alone == learned(&["clips"], "2"), "threads");
    let files = ["clips/3.csv", "clips/1.csv", "clips/0.csv", "clips/2.csv"];
    assert!(folder_alone == learned(&files, "2"), "another order");
    // Two names that only their folders tell apart, and a file by two paths.
    fs::create_dir(folder.path().join("more")).unwrap();
    fs::rename(folder.path().join("clips/3.csv"), folder.path().join("more/0.csv")).unwrap();
    let there = ["clips", "more/0.csv", "clips/../more/0.csv"];
    let back = ["clips/../more/0.csv", "more/0.csv", "clips/2.csv", "clips/1.csv", "clips/0.csv"];
    assert!(learned(&there, "2") == learned(&back, "2"), "names");
}

#[test]
fn the_same_twice_is_learned_from_once() {
    let folder = clips(3);
    check(&folder, &learn(&[]), 0, &[]);
    let once = bytes(&folder, "m.safetensors");
    fs::copy(folder.path().join("clips/1.csv"), folder.path().join("clips/9.csv")).unwrap();
    let text = fs::read_to_string(folder.path().join("clips/2.csv")).unwrap();
    fs::write(folder.path().join("clips/8.csv"), format!("# mood=good\n{text}")).unwrap();
    let words = ["left out: 9 holds the same as 1", "left out: 8 holds the same as 2"];
    check(&folder, &learn(&[]), 0, &words);
    assert!(bytes(&folder, "m.safetensors") == once);
}

/// A log, cut at `length` bytes, and no model: what a killed run leaves.
fn cut(folder: &TempDir, log: &[u8], length: usize) {
    fs::write(folder.path().join("steps.jsonl"), &log[..length]).unwrap();
    let _ = fs::remove_file(folder.path().join("m.safetensors"));
}

#[track_caller]
fn check_resumed(method: &str) {
    let folder = clips(4);
    let method = ["--method", method];
    let resume = learn(&[&method, &LOG[..], &["--resume"]].concat());
    check(&folder, &learn(&[method, LOG].concat()), 0, &[]);
    let (model, log) = (bytes(&folder, "m.safetensors"), bytes(&folder, "steps.jsonl"));
    let ends: Vec<usize> = (0..log.len()).filter(|at| log[*at] == b'\n').collect();
    assert!(ends.len() >= 5, "header, three steps or more, end");
    let mut lengths: Vec<usize> = ends.iter().map(|end| end + 1).collect();
    // Whole but for the line's end, torn in the middle, one byte of it.
    let last = ends[ends.len() - 1];
    lengths.extend([ends[1], ends[2] - 30, ends[2] + 2, last - 5, 0, 1, ends[0] / 2, ends[0]]);
    for length in lengths {
        cut(&folder, &log, length);
        check(&folder, &resume, 0, &[]);
        assert!(bytes(&folder, "steps.jsonl") == log, "the log, cut at {length}");
        assert!(bytes(&folder, "m.safetensors") == model, "the model, cut at {length}");
    }
    remove(&folder, "steps.jsonl");
    check(&folder, &resume, 0, &[]);
    assert!(bytes(&folder, "steps.jsonl") == log, "no log is begun anew");
}

#[test]
fn a_resumed_run_ends_as_an_uninterrupted_one() {
    check_resumed("grow");
}

#[test]
fn a_resumed_descent_ends_as_an_uninterrupted_one() {
    check_resumed("gradient");
}

#[test]
fn a_killed_run_goes_on() {
    let folder = clips(4);
    // Enough steps that one is under way when it is killed, however busy the machine is.
    let more = |resume: &'static [&str]| {
        let steps = ["--set", "learn.steps=40", "--jobs", "1"];
        learn(&[&LOG[..], &steps, resume].concat())
    };
    let path = folder.path().join("steps.jsonl");
    let mut child = Command::new(env!("CARGO_BIN_EXE_handover"))
        .args(more(&[]))
        .current_dir(folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let lines = || fs::read_to_string(&path).map_or(0, |text| text.lines().count());
    while lines() < 3 && child.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let left = fs::read_to_string(&path).unwrap();
    assert!(lines() >= 3 && !left.contains("finished"), "not killed in the middle: {left}");
    assert!(!folder.path().join("m.safetensors").exists(), "no half of a model");
    check(&folder, &more(&["--resume"]), 0, &["redone from the log"]);
    let (model, log) = (bytes(&folder, "m.safetensors"), bytes(&folder, "steps.jsonl"));
    remove(&folder, "steps.jsonl");
    check(&folder, &more(&[]), 0, &[]);
    assert!(bytes(&folder, "m.safetensors") == model && bytes(&folder, "steps.jsonl") == log);
}

#[test]
fn the_log_tells_what_was_learned_from_and_each_step() {
    let folder = clips(3);
    let found =
        check_json(&folder, &learn(&[&LOG[..], &["--json", "--group", "pair"]].concat()), 0);
    let text = fs::read_to_string(folder.path().join("steps.jsonl")).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let header = &lines[0];
    for key in ["method", "role", "candidates", "references"] {
        assert_eq!(header[key], found[key], "{key}");
    }
    assert_eq!(header["held_out"], found["held_out_references"]);
    assert_eq!(header["parameters"]["learn.tolerance"], 0.0);
    let demonstrations = header["demonstrations"].as_object().unwrap();
    assert_eq!(demonstrations.keys().collect::<Vec<_>>(), ["0", "1", "2"]);
    assert_eq!(demonstrations["2"]["group"], "second");
    assert_eq!(demonstrations["2"]["sha256"].as_str().unwrap().len(), 64);
    assert_eq!(json!(lines[1..4]), found["steps"]);
    let end = json!({ "finished": true, "final": found["final"], "held_out": found["held_out"] });
    assert_eq!(lines[4..], [end]);
}

#[test]
fn a_log_of_another_run_is_refused_by_name() {
    let folder = clips(4);
    check(&folder, &learn(&LOG), 0, &[]);
    let log = bytes(&folder, "steps.jsonl");
    let model = bytes(&folder, "m.safetensors");
    check(&folder, &learn(&LOG), 2, &["steps.jsonl exists", "--resume"]);
    check(&folder, &learn(&["--resume"]), 2, &["--log"]);
    let resume = |more: &[&'static str], words: &[&str]| {
        check(&folder, &learn(&[&LOG[..], &["--resume"], more].concat()), 2, words);
        assert!(bytes(&folder, "steps.jsonl") == log && bytes(&folder, "m.safetensors") == model);
    };
    let words = [
        "of another run",
        "method is \"grow\" in the log, \"prune\" here",
        "learn.method is \"grow\" in the log, \"prune\" here",
        "mesh.scale is 30.0 in the log, 29.0 here",
    ];
    resume(&["--method", "prune", "--set", "mesh.scale=29"], &words);
    resume(&["--role", "receiver"], &["role is \"giver\" in the log, \"receiver\" here"]);
    resume(&["--group", "pair"], &["recording 0 is {", "\"group\":\"first\""]);
    resume(&["--up", "y"], &["up is \"z\" in the log, \"y\" here"]);
    resume(&["--filter", "[012].csv"], &["recording 3 is {", "missing here"]);
    let text = fs::read_to_string(folder.path().join("clips/2.csv")).unwrap();
    fs::write(folder.path().join("clips/2.csv"), text + "\n").unwrap();
    resume(&[], &["recording 2 is {\"sha256\":"]);
}

#[test]
fn corrupt_logs_are_named_with_the_line() {
    let folder = clips(3);
    check(&folder, &learn(&LOG), 0, &[]);
    let log = fs::read_to_string(folder.path().join("steps.jsonl")).unwrap();
    let lines: Vec<&str> = log.lines().collect();
    let resume = |lines: &[&str], code: i32, words: &[&str]| {
        let text = lines.iter().map(|line| format!("{line}\n")).collect::<String>();
        fs::write(folder.path().join("steps.jsonl"), &text).unwrap();
        check(&folder, &learn(&[&LOG[..], &["--resume"]].concat()), code, words);
        assert_eq!(fs::read_to_string(folder.path().join("steps.jsonl")).unwrap(), text);
    };
    let [header, first, second, third, end] = lines[..] else { panic!("{log}") };
    resume(&[header, first, "{\"edge\":", third], 1, &["steps.jsonl, line 3: no JSON"]);
    let wave = second.replace("\"add\"", "\"wave\"");
    resume(&[header, first, &wave, third], 1, &["steps.jsonl, line 3", "the move 'wave'"]);
    let tail = second.replacen("giver/", "giver/tail_", 1);
    resume(&[header, first, &tail], 1, &["line 3", "is no joint of giver"]);
    let remove = second.replace("\"add\"", "\"remove\"");
    resume(&[header, first, &remove], 1, &["line 3: step 2 is not of this run"]);
    resume(&[header, first, first], 1, &["line 3: step 2 is not of this run", "before it"]);
    resume(&[header, second, third], 1, &["line 2: step 1 is not of this run", "before it"]);
    resume(&[header, first, end, second], 1, &["line 4: nothing follows", "'finished'"]);
    resume(&[header, first, end], 1, &["says 'finished' where there is a step"]);
    let other = end.replace("\"final\":", "\"final\":1");
    resume(&[header, first, second, third, &other], 1, &["ends with", "must be"]);
    resume(&["{}", first], 2, &["line 1: no log of learning"]);
    resume(&["frame,time_s", "0,0"], 1, &["line 1: no JSON"]);
    fs::write(folder.path().join("steps.jsonl"), "my diary").unwrap();
    let arguments = learn(&[&LOG[..], &["--resume"]].concat());
    check(&folder, &arguments, 2, &["line 1: no log of learning"]);
    assert_eq!(bytes(&folder, "steps.jsonl"), b"my diary");
}

#[test]
fn what_cannot_be_learned_or_written_is_refused_before_any_work() {
    let folder = clips(3);
    let to = |out: &'static str| ["learn", "clips", "-o", out];
    check(&folder, &to("m.model"), 2, &["m.model", "ends in .safetensors"]);
    check(&folder, &to("no/m.safetensors"), 2, &["no folder no"]);
    check(&folder, &["learn", "clips"], 2, &["--out"]);
    check(&folder, &["learn", "-o", "m.safetensors"], 2, &["DEMO"]);
    check(&folder, &learn(&["--log", "no/steps.jsonl"]), 2, &["no folder no"]);
    check(&folder, &learn(&["--log", "m.safetensors"]), 2, &["a file each"]);
    check(&folder, &learn(&["--log", "clips/0.csv", "--resume"]), 2, &["clips/0.csv is an input"]);
    let only = ["--filter", "0.csv"];
    check(&folder, &learn(&only), 1, &["1 group(s) of recordings", "needs two"]);
    let grouped = ["--filter", "[01].csv", "--group", "pair"];
    check(&folder, &learn(&grouped), 1, &["1 group(s)", "needs two"]);
    check(&folder, &learn(&["--group", "mood"]), 2, &["no metadata 'mood' to group by"]);
    check(&folder, &learn(&["--role", "waiter"]), 1, &["no person 'waiter'"]);
    let joint = ["--set", "evaluate.ignored_joints=[tail]"];
    check(&folder, &learn(&joint), 1, &["evaluate.ignored_joints", "'tail'"]);
    assert!(!folder.path().join("m.safetensors").exists());
    // Another name would only be found wrong when the model is made.
    let text = fs::read_to_string(folder.path().join("clips/2.csv")).unwrap();
    fs::write(folder.path().join("clips/2.csv"), text.replace("receiver", "taker")).unwrap();
    check(&folder, &learn(&LOG), 1, &["cannot make a model of this", "'taker'"]);
    assert!(!folder.path().join("steps.jsonl").exists());
}

#[test]
fn a_broken_recording_is_named_and_learning_goes_on() {
    let folder = clips(4);
    fs::write(folder.path().join("clips/3.csv"), "frame,time_s,person,joint,x,y,z\n0,0\n").unwrap();
    check(&folder, &learn(&[]), 3, &["3.csv: line 2", "wrote m.safetensors"]);
    // A model beside its recordings is none of them.
    let beside = ["learn", "clips", "-o", "clips/m.safetensors", "--method", "none"];
    check(&folder, &beside, 3, &["wrote"]);
    check(&folder, &beside, 3, &["wrote"]);
}
