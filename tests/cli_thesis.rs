//! `handover evaluate --protocol thesis` as a user meets it: the real process, its tables, its JSON
//! and its picture.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

#[expect(dead_code, reason = "other protocols' names")]
#[path = "common/clips.rs"]
mod clips;
mod common;

use std::fs;

use clips::{FRAMES, clips, keys};
use common::{check, check_json};
use serde_json::{Value, json};

const SETTINGS: [&str; 4] = ["--kernel", "uniform", "--set", "learn.steps=6"];

fn thesis<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let arguments = ["evaluate", "clips", "--protocol", "thesis"];
    arguments.into_iter().chain(SETTINGS).chain(more.iter().copied()).collect()
}

fn numbers(values: &Value) -> Vec<f64> {
    let object = |value: &Value| -> Option<Vec<f64>> {
        Some(value.as_object()?.values().map(|d| d.as_f64().unwrap()).collect())
    };
    object(values)
        .unwrap_or_else(|| values.as_array().unwrap().iter().map(|d| d.as_f64().unwrap()).collect())
}

#[track_caller]
fn check_method(method: &str, moves: &[&str]) {
    let folder = clips(3);
    let found = check_json(&folder, &thesis(&["--json", "--method", method]), 0);
    let shape = [
        "protocol", "role", "method", "kernel", "input", "clips", "table", "curves", "steps",
        "average", "group", "changes",
    ];
    assert_eq!(keys(&found), shape);
    for (key, value) in [
        ("protocol", "thesis"),
        ("role", "giver"),
        ("method", method),
        ("kernel", "uniform"),
        ("input", "0"),
    ] {
        assert_eq!(found[key], value, "{key}");
    }
    let clips = ["0", "1", "2"].map(|name| json!({ "name": name, "frames": FRAMES }));
    assert_eq!(found["clips"], json!(clips));
    let table = &found["table"];
    assert_eq!(keys(table), ["untrained", "0", "1", "2"]);
    for key in ["curves", "steps", "average"] {
        assert_eq!(keys(&found[key]), ["0", "1", "2"], "{key}");
    }
    let untrained = numbers(&table["untrained"]);
    for (own, name) in ["0", "1", "2"].into_iter().enumerate() {
        assert_eq!(keys(&table[name]), ["0", "1", "2"]);
        let row = numbers(&table[name]);
        let curve = numbers(&found["curves"][name]);
        assert!(row[own] <= untrained[own], "{method}, {name}: {row:?}, {untrained:?}");
        assert!(curve.is_sorted_by(|a, b| a > b), "{method}, {name}: {curve:?}");
        assert_eq!((curve[0], curve[curve.len() - 1]), (untrained[own], row[own]));
        let steps = found["steps"][name].as_array().unwrap();
        assert_eq!(steps.len() + 1, curve.len());
        for step in steps {
            assert_eq!(keys(step), ["edge", "move"]);
            assert!(moves.contains(&step["move"].as_str().unwrap()), "{step}");
            let [giver, receiver] = &step["edge"].as_array().unwrap()[..] else { panic!("{step}") };
            assert!(giver.as_str().unwrap().starts_with("giver/"), "{step}");
            assert!(receiver.as_str().unwrap().starts_with("receiver/"), "{step}");
        }
        let average = &found["average"][name];
        let others = |row: &[f64]| (row.iter().sum::<f64>() - row[own]) / 2.0;
        let near = |value: &Value, expected: f64| {
            assert!((value.as_f64().unwrap() - expected).abs() < 1e-12, "{average}");
        };
        near(&average["own"], row[own]);
        near(&average["others"], others(&row));
        near(&average["untrained"]["own"], untrained[own]);
        near(&average["untrained"]["others"], others(&untrained));
    }
    let learned = |name: &str| !found["steps"][name].as_array().unwrap().is_empty();
    assert!(learned("1"), "another motion has something to teach by {method}: {}", found["steps"]);
}

#[test]
fn grow_falls_to_the_tables_own_entry() {
    check_method("grow", &["add"]);
}

#[test]
fn prune_falls_to_the_tables_own_entry() {
    check_method("prune", &["remove"]);
}

#[test]
fn grow_prune_falls_to_the_tables_own_entry() {
    check_method("grow_prune", &["add", "remove"]);
}

#[test]
fn gradient_ends_at_the_tables_own_entry() {
    let folder = clips(2);
    let more = ["--json", "--method", "gradient", "--set", "learn.phases=2"];
    let found = check_json(&folder, &thesis(&more), 0);
    let steps = found["steps"]["1"].as_array().unwrap();
    assert!(!steps.is_empty());
    assert!(steps.iter().all(|step| *step == json!({ "edge": null, "move": "descend" })));
    for (own, name) in ["0", "1"].into_iter().enumerate() {
        let (row, curve) = (numbers(&found["table"][name]), numbers(&found["curves"][name]));
        assert_eq!(row[own], curve[curve.len() - 1]);
        assert!(row[own] <= curve[0], "{name}: {curve:?}");
    }
}

#[test]
fn nothing_is_learned_by_none_and_little_by_few_steps() {
    let folder = clips(2);
    let found = check_json(&folder, &thesis(&["--json", "--method", "none"]), 0);
    let table = &found["table"];
    assert!(table["0"] == table["untrained"] && table["1"] == table["untrained"], "{table}");
    // Without an edge between the people the method's start is the same; prune's has some.
    let start = |method: &str| {
        let one = thesis(&["--json", "--method", method, "--set", "learn.steps=1"]);
        check_json(&folder, &one, 0)["table"]["untrained"].clone()
    };
    assert_eq!(start("grow"), table["untrained"]);
    assert_ne!(start("prune"), table["untrained"]);
}

#[test]
fn threads_change_no_byte_of_thesis() {
    let folder = clips(3);
    let run = |jobs: &str| {
        let more = ["--json", "--jobs", jobs, "-o", "t.json", "--plot", "t.svg"];
        let output = check(&folder, &thesis(&more), 0, &["wrote t.json", "wrote t.svg"]);
        let file = |name: &str| fs::read(folder.path().join(name)).unwrap();
        assert_eq!(file("t.json"), output.stdout, "the same in the file");
        (output.stdout, file("t.svg"))
    };
    assert_eq!(run("1"), run("2"));
}

#[test]
fn the_first_recording_is_the_input() {
    let folder = clips(3);
    let run = |first: &str| {
        let files = [first, "clips"];
        let more = ["--protocol", "thesis", "--json", "--set", "learn.steps=1"];
        let arguments: Vec<&str> = ["evaluate"].into_iter().chain(files).chain(more).collect();
        check_json(&folder, &arguments, 0)
    };
    let (found, other) = (run("clips/0.csv"), run("clips/2.csv"));
    assert_eq!((&found["input"], &other["input"]), (&json!("0"), &json!("2")));
    assert_eq!(keys(&other["table"]), ["untrained", "2", "0", "1"], "in the order given");
    // Onto itself a motion goes as it is, but for bones that the tracker changes.
    let untrained = |found: &Value, name: &str| found["table"]["untrained"][name].as_f64().unwrap();
    assert!(untrained(&found, "0") < 0.1 * untrained(&other, "0"));
    assert!(untrained(&other, "2") < 0.1 * untrained(&found, "2"));
}

#[test]
fn the_thesis_tables_mark_the_own_target() {
    let folder = clips(3);
    let words = [
        "thesis: 3 targets (72 frames), the robot is giver, the input motion is 0",
        "learned by prune, kernel uniform",
        "3 targets; the thesis has 5",
    ];
    let more = ["--method", "prune", "--plot", "curves.svg"];
    let found = check(&folder, &thesis(&more), 0, &words);
    let text = String::from_utf8(found.stdout).unwrap();
    let rows = |start: &str| -> Vec<Vec<&str>> {
        let rows = text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
        rows.filter(|row| row.first() == Some(&start)).collect()
    };
    for (at, name) in ["0", "1", "2"].into_iter().enumerate() {
        // The heading of a table starts with the first name, too.
        let table = rows(name).into_iter().find(|row| row.iter().any(|cell| cell.ends_with('*')));
        let table = table.unwrap_or_else(|| panic!("{text}"));
        assert_eq!(table.len(), 1 + 3 + 2, "{table:?}");
        assert!(table[1 + at].ends_with('*'), "{table:?}");
    }
    assert_eq!(rows("untrained")[0].len(), 1 + 3);
    let svg = fs::read_to_string(folder.path().join("curves.svg")).unwrap();
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"), "{svg}");
    assert_eq!(svg.matches("<polyline").count(), 3);
    for words in ["steps of learning", "distance [m]", "(prune, uniform)"] {
        assert!(svg.contains(words), "no '{words}' in {svg}");
    }
}

#[test]
fn what_the_thesis_cannot_mean_is_refused() {
    let folder = clips(2);
    for (option, value) in [("--methods", "mesh"), ("--folds", "3"), ("--group", "pair")] {
        check(&folder, &thesis(&[option, value]), 2, &[option, "no folds", "--method"]);
    }
    check(&folder, &thesis(&["--plot", "t.png"]), 2, &["t.png", ".svg"]);
    check(&folder, &thesis(&["--method", "guess"]), 2, &["grow_prune"]);
    check(&folder, &thesis(&["--filter", "0.csv"]), 1, &["1 recording(s)", "input motion"]);
    check(&folder, &thesis(&["--set", "evaluate.ignored_joints=[tail]"]), 1, &["'tail'"]);
    let displaced = ["evaluate", "clips", "--protocol", "displaced", "--plot", "t.svg"];
    check(&folder, &displaced, 2, &["--plot", "thesis"]);
}

#[test]
fn a_bad_input_motion_is_not_replaced_by_the_next() {
    let folder = clips(3);
    fs::write(folder.path().join("clips/bad.csv"), "frame,time_s\n1,2\n").unwrap();
    // Among the targets it is a loss.
    check(&folder, &thesis(&["--method", "none"]), 3, &["bad.csv"]);
    let first = ["evaluate", "clips/bad.csv", "clips", "--protocol", "thesis"];
    check(&folder, &first, 1, &["bad.csv", "the first recording is the input motion"]);
}

#[test]
fn phases_are_of_gradient_alone() {
    let folder = clips(2);
    let found = |phases: &str| {
        let mut found = check_json(&folder, &thesis(&["--json", "--set", phases]), 0);
        (found["changes"].take(), found)
    };
    let (one, three) = (found("learn.phases=1"), found("learn.phases=3"));
    assert!(one.0 != three.0, "what was asked for is told");
    assert_eq!(one.1, three.1);
}

#[test]
fn options_of_learning_win_over_parameters_and_serve_all_protocols() {
    let folder = clips(3);
    let over = ["--json", "--method", "none", "--set", "learn.method=prune", "--set"];
    let over: Vec<&str> = over.into_iter().chain(["mesh.kernel=inverse_distance"]).collect();
    let found = check_json(&folder, &thesis(&over), 0);
    assert_eq!((&found["method"], &found["kernel"]), (&json!("none"), &json!("uniform")));
    // `mesh` without an edge is not `mesh` with some, in whatever protocol.
    let mesh = |method: &str| {
        let arguments =
            ["evaluate", "clips", "--protocol", "leave_one_out", "--methods", "mesh", "--json"];
        let more = ["--method", method, "--kernel", "uniform", "--set", "learn.steps=1"];
        let arguments: Vec<&str> = arguments.into_iter().chain(more).collect();
        check_json(&folder, &arguments, 0)["summary"]["mesh"]["joint_cm"].clone()
    };
    assert_ne!(mesh("none"), mesh("grow"));
}
