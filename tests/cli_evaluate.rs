//! `handover evaluate` and parameters as a user meets them: the real process, its exit code, its
//! words and its JSON.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

#[path = "common/clips.rs"]
mod clips;
mod common;
#[path = "common/object.rs"]
mod object;

use std::fs;
use std::path::Path;

use clips::{FIGURES, FRAMES, METHODS, clips, keys};
use common::{check, check_json, folder};
use object::clips_with_object;
use serde_json::{Value, json};
use tempfile::TempDir;

const EVALUATE: [&str; 4] = ["evaluate", "clips", "--protocol", "leave_one_out"];

fn evaluate<'a>(more: &[&'a str]) -> Vec<&'a str> {
    EVALUATE.into_iter().chain(more.iter().copied()).collect()
}

#[test]
fn the_json_has_the_promised_shape() {
    let folder = clips(4);
    let found = check_json(&folder, &evaluate(&["--json"]), 0);
    let about = ["protocol", "role", "causal", "methods"];
    let shape = [&about[..], &["clips", "summary", "human", "group", "changes"]].concat();
    assert_eq!(keys(&found), shape);
    assert_eq!((&found["protocol"], &found["role"]), (&"leave_one_out".into(), &"giver".into()));
    let clips = found["clips"].as_array().unwrap();
    let names: Vec<&Value> = clips.iter().map(|clip| &clip["name"]).collect();
    assert_eq!(names, ["0", "1", "2", "3"]);
    for clip in clips {
        assert_eq!(keys(clip), ["name", "frames", "methods", "human"]);
        assert_eq!(keys(&clip["human"]), FIGURES);
        assert_eq!(clip["human"]["contact_cm"], 0.0, "people are where they are");
        assert_eq!(clip["frames"], FRAMES);
        assert_eq!(keys(&clip["methods"]), METHODS);
        for figures in clip["methods"].as_object().unwrap().values() {
            assert_eq!(keys(figures), FIGURES);
            // A hand that does not reach is neither early nor late.
            let mut figures = figures.as_object().unwrap().iter();
            assert!(figures.all(|(figure, value)| figure == "reach_ms" || value.is_number()));
        }
    }
    assert_eq!(keys(&found["summary"]), METHODS);
    for figures in found["summary"].as_object().unwrap().values() {
        assert_eq!(keys(figures), FIGURES);
        let measured = figures.as_object().unwrap().iter().filter(|(key, _)| *key != "reach_ms");
        for (_, summary) in measured {
            assert_eq!(keys(summary), ["mean", "median", "low", "high", "n"]);
            assert_eq!(summary["n"], 4);
        }
    }
    let contact = |method: &str| found["summary"][method]["contact_cm"]["mean"].as_f64().unwrap();
    assert!(contact("mesh") < 0.5 * contact("hold"), "{} {}", contact("mesh"), contact("hold"));
}

#[test]
fn an_object_is_in_the_mesh_only_if_asked_for() {
    let (bare, with) = (clips(4), clips_with_object(4, 0));
    let methods = ["--methods", "hold,none,mesh", "--json"];
    let run = |folder: &TempDir, more: &[&str], code| {
        check(folder, &evaluate(&[&methods, more].concat()), code, &[]).stdout
    };
    let before = run(&bare, &[], 0);
    assert!(run(&with, &[], 0) == before, "nobody looks at it");
    let attach = ["--set", "object.attach=true"];
    let on: Value = serde_json::from_slice(&run(&with, &attach, 0)).unwrap();
    let off: Value = serde_json::from_slice(&before).unwrap();
    assert_eq!(on["summary"]["hold"], off["summary"]["hold"]);
    assert_ne!(on["summary"]["mesh"], off["summary"]["mesh"]);
    assert_eq!(on["changes"][0]["key"], "object.attach");
    let nobody = "left out: clips/0.csv: object.attach: no object was tracked";
    check(
        &clips_with_object(4, 1),
        &evaluate(&[&attach[..], &["--methods", "hold"]].concat()),
        3,
        &[nobody],
    );
    check(&bare, &evaluate(&attach), 1, &[nobody, "no recording is left to work with"]);
}

#[test]
fn threads_and_runs_change_no_byte() {
    let folder = clips(5);
    let run = |jobs: &str| {
        check(&folder, &evaluate(&["--json", "--jobs", jobs, "-o", "e.json"]), 0, &["e.json"])
    };
    let (one, two, again) = (run("1"), run("2"), run("2"));
    assert!(one.stdout == two.stdout && two.stdout == again.stdout);
    assert_eq!(fs::read(folder.path().join("e.json")).unwrap(), one.stdout, "the same in the file");
}

#[test]
fn methods_pick_columns_and_the_role_may_be_chosen() {
    let folder = clips(3);
    let found = check_json(&folder, &evaluate(&["--methods", "mesh,hold", "--json"]), 0);
    assert_eq!(keys(&found["summary"]), ["hold", "mesh"]);
    assert_eq!(keys(&found["clips"][0]["methods"]), ["hold", "mesh"]);
    let other = ["--methods", "hold", "--role", "receiver"];
    check(&folder, &evaluate(&other), 0, &["the robot is receiver", "hold"]);
    let nobody = ["--role", "waiter"];
    check(&folder, &evaluate(&nobody), 1, &["no person 'waiter', only 'giver' and 'receiver'"]);
}

#[test]
fn a_result_says_how_it_was_made() {
    let folder = clips(3);
    let by = |more: &[&str]| {
        let arguments = [&["--json", "--methods", "hold,knn"], more].concat();
        let mut found = check_json(&folder, &evaluate(&arguments), 0);
        ["causal", "methods", "group", "changes"].map(|key| found[key].take())
    };
    let methods = json!(["hold", "knn"]);
    assert_eq!(by(&[]), [json!(false), methods.clone(), json!(null), json!([])]);
    let more = ["--causal", "--group", "pair", "--set", "track.dimensions=4", "--folds", "7"];
    let changes = json!([
        { "key": "track.dimensions", "value": 4, "default": 16 },
        { "key": "evaluate.folds", "value": 7, "default": 10 },
    ]);
    assert_eq!(by(&more), [json!(true), methods, json!("pair"), changes]);
    let text = |more: &[&str], line: &str| {
        let arguments = [&["--methods", "hold"], more].concat();
        let found = check(&folder, &evaluate(&arguments), 0, &[]);
        assert!(found.stdout.starts_with(line.as_bytes()), "{found:?}");
    };
    text(&[], "leave_one_out: 3 clips, 72 frames, the robot is giver\n");
    let line = "leave_one_out, by the past alone: 3 clips, 72 frames, the robot is giver\n";
    text(&["--causal", "--set", "track.dimensions=4"], line);
}

#[test]
fn usage_errors_say_what_there_is() {
    let folder = clips(2);
    for protocol in ["forecast", "thesis"] {
        let arguments = ["evaluate", "clips", "--protocol", protocol, "--causal"];
        let words = "--causal: goes with the protocols leave_one_out and displaced, not with";
        check(&folder, &arguments, 2, &[words, protocol]);
    }
    check(&folder, &evaluate(&["--methods", "magic"]), 2, &["magic", "hold, replay, knn"]);
    check(
        &folder,
        &["evaluate", "clips", "--protocol", "guess"],
        2,
        &["guess", "leave_one_out, displaced"],
    );
    check(&folder, &["evaluate", "clips"], 2, &["--protocol"]);
    check(&folder, &evaluate(&["--folds", "1"]), 2, &["--folds", "2..=1000"]);
    check(&folder, &evaluate(&["--group", "mood"]), 2, &["no metadata 'mood' to group by"]);
    check(&folder, &evaluate(&["-o", "e.txt"]), 2, &["e.txt", ".json"]);
}

#[test]
fn groups_never_learn_from_each_other() {
    let folder = clips(4);
    let figures = |more: &[&str]| {
        let arguments = [&["--json", "--methods", "replay"], more].concat();
        check_json(&folder, &evaluate(&arguments), 0)["clips"][0]["methods"]["replay"].clone()
    };
    // Alone, clip 0 is replayed from its neighbour 1, which is of its group.
    assert_ne!(figures(&[]), figures(&["--group", "pair"]));
    let only = ["--group", "pair", "--filter", "[01].csv"];
    check(&folder, &evaluate(&only), 1, &["needs two"]);
}

#[test]
fn a_broken_file_is_named_and_the_rest_goes_on() {
    let folder = clips(3);
    fs::write(folder.path().join("clips/2.csv"), "frame,time_s,person,joint,x,y,z\n0,0\n").unwrap();
    let found = check_json(&folder, &evaluate(&["--methods", "hold", "--json"]), 3);
    assert_eq!(found["clips"].as_array().unwrap().len(), 2);
    check(&folder, &evaluate(&["--methods", "hold"]), 3, &["2.csv: line 2"]);
    for name in ["0", "1"] {
        fs::write(folder.path().join(format!("clips/{name}.csv")), "nothing\n").unwrap();
    }
    check(&folder, &evaluate(&[]), 1, &["0.csv: line 1", "1.csv: line 1", "2.csv: line 2"]);
}

#[test]
fn one_clip_has_nobody_to_learn_from() {
    let folder = clips(1);
    check(&folder, &evaluate(&[]), 1, &["learns from the others and needs two"]);
}

#[test]
fn outputs_that_would_lose_something_are_refused_before_any_work() {
    let folder = clips(3);
    let original = fs::read(folder.path().join("clips/0.csv")).unwrap();
    check(&folder, &["import", "clips/0.csv", "clips/0.csv"], 2, &["is the input"]);
    check(&folder, &["import", "clips", "clips"], 2, &["is the input"]);
    assert_eq!(fs::read(folder.path().join("clips/0.csv")).unwrap(), original);
    check(&folder, &evaluate(&["-o", "no/e.json"]), 2, &["no folder no"]);
}

#[test]
fn a_clip_that_a_method_cannot_solve_is_named_and_the_rest_goes_on() {
    let folder = clips(3);
    let unanchored = evaluate(&[
        "--methods",
        "hold,none",
        "--json",
        "--set",
        "mesh.time_weight=0",
        "--set",
        "retarget.bone_weight=0",
        "--set",
        "retarget.known=soft",
        "--set",
        "retarget.known_weight=1e-6",
        "--set",
        "retarget.laplacian_weight=1e6",
        "--set",
        "retarget.transform=implicit",
    ]);
    let found = check_json(&folder, &unanchored, 3);
    let clip = &found["clips"][0];
    assert!(
        clip["methods"]["none"]["contact_cm"].is_null()
            && clip["methods"]["hold"]["contact_cm"].is_number()
    );
    check(&folder, &unanchored, 3, &["not predicted: 0, none", "not predicted: 2, none"]);
}

#[test]
fn the_odd_one_out_is_left_out_even_if_it_comes_first() {
    let folder = clips(3);
    let text = fs::read_to_string(folder.path().join("clips/0.csv")).unwrap();
    let headless: Vec<&str> = text.lines().filter(|line| !line.contains(",head,")).collect();
    fs::write(folder.path().join("clips/00.csv"), headless.join("\n") + "\n").unwrap();
    let found = check_json(&folder, &evaluate(&["--methods", "hold", "--json"]), 3);
    assert_eq!(found["clips"].as_array().unwrap().len(), 3);
    let words = "left out: clips/00.csv: other joints than in most: giver: head is missing; receiver: \
                 head is missing";
    check(&folder, &evaluate(&["--methods", "hold"]), 3, &[words]);
}

#[test]
fn who_is_left_out_is_named_by_file_with_what_is_wrong() {
    let folder = clips(3);
    let text = fs::read_to_string(folder.path().join("clips/0.csv")).unwrap();
    let write = |name: &str, text: &str| {
        fs::write(folder.path().join("clips").join(name), text).unwrap();
    };
    write("alice.csv", &text.replace(",giver,", ",alice,"));
    // Names in the other order: the other person is the first.
    let swapped = text.replace(",giver,", ",-,").replace(",receiver,", ",giver,");
    write("turned.csv", &swapped.replace(",-,", ",receiver,"));
    let handless = text.lines().filter(|line| !line.contains("giver,right_"));
    write("nohand.csv", &(handless.collect::<Vec<_>>().join("\n") + "\n"));
    let words = [
        "left out: clips/alice.csv: no person 'giver', only",
        "left out: clips/turned.csv: names its people in another order than most",
        "left out: clips/nohand.csv: other joints than in most: giver: right_shoulder, \
         right_elbow, right_hand are missing",
    ];
    check(&folder, &evaluate(&["--methods", "hold"]), 3, &words);
    let replay = ["replay", "clips", "clips/nohand.csv", "--filter", "[0-2].csv"];
    let words = "cannot replay clips/nohand.csv: other joints than in demonstration 0: giver: right_shoulder";
    check(&folder, &[&replay[..], &["--method", "none"]].concat(), 1, &[words]);
}

#[test]
fn what_is_too_short_to_be_an_interaction_is_left_out() {
    let folder = clips(3);
    let text = fs::read_to_string(folder.path().join("clips/0.csv")).unwrap();
    // The whole one is of 24 frames, 30 a second.
    let first = |frames: usize| {
        let mut rows = 0..;
        let row = |line: &&str| line.starts_with(|c: char| c.is_ascii_digit());
        let lines = text.lines().filter(|line| !row(line) || rows.next().unwrap() < 18 * frames);
        lines.collect::<Vec<_>>().join("\n") + "\n"
    };
    let figures = || {
        let found = check_json(&folder, &evaluate(&["--methods", "hold", "--json"]), 3);
        (found["clips"].as_array().unwrap().len(), found["human"]["gap_cm"]["mean"].clone())
    };
    // Something has to be left out in either case.
    fs::write(folder.path().join("clips/nothing.csv"), "nothing\n").unwrap();
    let whole = figures();
    for (name, frames) in [("one", 1), ("three", 3), ("fifteen", 15)] {
        fs::write(folder.path().join(format!("clips/{name}.csv")), first(frames)).unwrap();
    }
    assert_eq!(figures(), whole);
    let words = [
        "left out: clips/one.csv: 1 frame in 0.00 s, no interaction: at least 5 frames",
        "left out: clips/three.csv: 3 frames in 0.07 s, no interaction",
        "left out: clips/fifteen.csv: 15 frames in 0.47 s, no interaction",
    ];
    check(&folder, &evaluate(&["--methods", "hold"]), 3, &words);
    let replay = ["replay", "clips", "clips/one.csv", "--method", "none", "--filter", "[0-2].csv"];
    check(&folder, &replay, 1, &[words[0], "no recording is left to work with"]);
    check(&folder, &["check", "clips/one.csv"], 0, &["clips/one.csv: CSV", ", 1 frame, no rate"]);
    fs::write(folder.path().join("clips/sixteen.csv"), first(16)).unwrap();
    assert_eq!(figures().0, 4);
}

#[test]
fn wrong_parameters_are_reported_together() {
    let folder = clips(2);
    let write = |text: &str| fs::write(folder.path().join("p.yaml"), text).unwrap();
    write(
        "/**:\n  ros__parameters:\n    mesh: {scale: -1, colour: red}\n    retarget: {steps: x}\n",
    );
    let all = ["mesh.scale is -1", "mesh.colour is no parameter", "retarget.steps is \"x\""];
    check(&folder, &evaluate(&["--config", "p.yaml"]), 2, &all);
    let three = &check_json(&folder, &["check", "p.yaml", "--json"], 1)["files"][0]["errors"];
    assert_eq!(three.as_array().unwrap().len(), 3);
    check(&folder, &["check", "p.yaml", "clips"], 3, &all);
    check(&folder, &evaluate(&["--config", "none.yaml"]), 1, &["cannot read none.yaml"]);
    check(&folder, &evaluate(&["--set", "mesh.scale"]), 2, &["KEY=VALUE"]);
}

#[test]
fn check_says_what_parameters_change() {
    let folder = clips(1);
    let write = |text: &str| fs::write(folder.path().join("p.yml"), text).unwrap();
    write("/**:\n  ros__parameters:\n    mesh: {scale: 12, power: 4}\n");
    let words = ["p.yml: parameters, 1 not as by default", "mesh.scale is 12.0, by default 30.0"];
    check(&folder, &["check", "p.yml"], 0, &words);
    let found = check_json(&folder, &["check", "clips/0.csv", "p.yml", "--json"], 0);
    assert_eq!(found["files"][1]["changes"][0]["key"], "mesh.scale");
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/config/handover.yaml");
    check(&folder, &["check", shipped], 0, &["all as by default"]);
    write("mesh: {scale: 12}\n");
    check(&folder, &["check", "p.yml"], 1, &["p.yml: BAD", "ros__parameters"]);
    check(&folder, &["check", "none.yaml"], 1, &["none.yaml: no such file"]);
}

#[test]
fn settings_win_over_the_file() {
    let folder = clips(2);
    let yaml = "/**:\n  ros__parameters:\n    evaluate: {ignored_joints: [head]}\n";
    fs::write(folder.path().join("p.yaml"), yaml).unwrap();
    let joint = |more: &[&str]| {
        let arguments = [&["--json", "--methods", "hold"], more].concat();
        check_json(&folder, &evaluate(&arguments), 0)["summary"]["hold"]["joint_cm"].clone()
    };
    let (plain, ignoring) = (joint(&[]), joint(&["--config", "p.yaml"]));
    assert_ne!(plain, ignoring);
    assert_eq!(plain, joint(&["--config", "p.yaml", "--set", "evaluate.ignored_joints=[]"]));
}

#[test]
fn help_has_all_that_a_command_does() {
    let folder = folder(&[]);
    let help = |command: &str, words: &[&str]| check(&folder, &[command, "--help"], 0, words);
    help("evaluate", &["Measure all methods", "thesis: the first recording is retargeted"]);
    help("learn", &["Some demonstrations are retargeted", "With --log each step"]);
    help("import", &["Bad files are named"]);
    let short = check(&folder, &["--help"], 0, &["Measure all methods against what people did"]);
    assert!(!String::from_utf8(short.stdout).unwrap().contains("each clip is predicted"));
}

#[test]
fn scripts_tell_their_usage() {
    if cfg!(windows) {
        return;
    }
    let folder = folder(&[]);
    for script in ["run", "test"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(script);
        let run = |argument: &str| {
            let mut command = std::process::Command::new(&path);
            command.arg(argument).current_dir(folder.path()).output().unwrap()
        };
        let help = run("--help");
        assert!(help.status.success() && help.stdout.starts_with(b"Usage: ./"), "{help:?}");
        assert_eq!(run("-x").status.code(), Some(2));
    }
}
