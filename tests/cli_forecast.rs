//! `handover evaluate --protocol forecast` as a user meets it: the real process, its table, its JSON
//! and what it refuses.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

#[expect(dead_code, reason = "other protocols' names")]
#[path = "common/clips.rs"]
mod clips;
mod common;

use std::fmt::Write as _;
use std::fs;

use clips::{FRAMES, clips, keys};
use common::{check, check_json};
use serde_json::{Value, json};
use tempfile::TempDir;

const METHODS: [&str; 8] = [
    "zero_velocity",
    "constant_velocity",
    "damped_velocity",
    "ridge",
    "knn",
    "delaunay",
    "k_delaunay",
    "mixed",
];
const FIGURES: [&str; 2] = ["wrist_cm", "joint_cm"];

fn forecast<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let arguments = ["evaluate", "clips", "--protocol", "forecast"];
    arguments.into_iter().chain(more.iter().copied()).collect()
}

/// Rewrites a clip's rows: those whose frame and time `[s]` `change` gives another time.
fn rewrite(folder: &TempDir, clip: &str, change: impl Fn(i64, f64) -> Option<f64>) {
    let path = folder.path().join(format!("clips/{clip}.csv"));
    let mut rewritten = String::new();
    for line in fs::read_to_string(&path).unwrap().lines() {
        let mut cells = line.splitn(3, ',');
        let mut cell = || cells.next().unwrap_or_default();
        let (Ok(frame), Ok(time), rest) = (cell().parse(), cell().parse(), cell()) else {
            let _ = writeln!(rewritten, "{line}");
            continue;
        };
        if let Some(time) = change(frame, time) {
            let _ = writeln!(rewritten, "{frame},{time},{rest}");
        }
    }
    fs::write(path, rewritten).unwrap();
}

/// Clips of 2.3 s, long enough for every horizon.
fn slow_clips(count: u32) -> TempDir {
    let folder = clips(count);
    for clip in 0..count {
        rewrite(&folder, &clip.to_string(), |_, time| Some(3.0 * time));
    }
    folder
}

#[test]
fn the_forecast_json_has_the_promised_shape() {
    let folder = slow_clips(4);
    let found = check_json(&folder, &forecast(&["--json"]), 0);
    let shape = ["protocol", "role", "horizons_ms", "clips", "summary", "group", "changes"];
    assert_eq!(keys(&found), shape);
    assert_eq!((&found["protocol"], &found["role"]), (&"forecast".into(), &"giver".into()));
    assert_eq!(found["horizons_ms"], json!([100.0, 200.0, 300.0, 500.0]));
    let clips = found["clips"].as_array().unwrap();
    assert_eq!(clips.len(), 4);
    for (at, clip) in clips.iter().enumerate() {
        assert_eq!(keys(clip), ["name", "frames", "methods"]);
        assert_eq!((&clip["name"], &clip["frames"]), (&at.to_string().into(), &FRAMES.into()));
        assert_eq!(keys(&clip["methods"]), METHODS);
        for errors in clip["methods"].as_object().unwrap().values() {
            assert_eq!(keys(errors), FIGURES);
            for figure in FIGURES {
                let numbers = errors[figure].as_array().unwrap();
                assert!(numbers.len() == 4 && numbers.iter().all(Value::is_number), "{errors}");
            }
        }
    }
    assert_eq!(keys(&found["summary"]), METHODS);
    for (method, figures) in found["summary"].as_object().unwrap() {
        assert_eq!(keys(figures), FIGURES);
        for figure in FIGURES {
            let summaries = figures[figure].as_array().unwrap();
            assert_eq!(summaries.len(), 4);
            for (horizon, summary) in summaries.iter().enumerate() {
                assert_eq!(keys(summary), ["mean", "median", "low", "high", "n"]);
                assert_eq!(summary["n"], 4);
                let of = |clip: &Value| clip["methods"][method][figure][horizon].as_f64().unwrap();
                let mean = clips.iter().map(of).sum::<f64>() / 4.0;
                assert!((summary["mean"].as_f64().unwrap() - mean).abs() < 1e-9);
            }
        }
    }
    let wrist = |method: &str, horizon: usize| {
        found["summary"][method]["wrist_cm"][horizon]["mean"].as_f64().unwrap()
    };
    for horizon in 0..4 {
        let [still, learned] = [wrist("zero_velocity", horizon), wrist("mixed", horizon)];
        assert!(learned < 0.5 * still, "{horizon}: {learned} {still}");
    }
    assert!(wrist("zero_velocity", 0) < wrist("zero_velocity", 2), "farther is harder");
}

#[test]
fn the_table_has_a_line_a_method_and_a_column_a_horizon() {
    let folder = slow_clips(3);
    let words = [
        "forecast: 3 clips, 72 frames, the robot is giver, its partner is forecast",
        "100 ms",
        "500 ms",
        "wrist",
        "joints",
    ];
    let said = check(&folder, &forecast(&[]), 0, &[&words[..], &METHODS].concat());
    let text = String::from_utf8(said.stdout).unwrap();
    for method in METHODS {
        let lines = text.lines().filter(|line| line.split_whitespace().next() == Some(method));
        assert_eq!(lines.count(), 2, "{method}: {text}");
    }
    let role = ["--role", "receiver", "--methods", "ridge"];
    check(&folder, &forecast(&role), 0, &["the robot is receiver", "ridge"]);
}

#[test]
fn threads_change_no_byte_of_forecast() {
    let folder = clips(5);
    let run = |jobs: &str| {
        let arguments = forecast(&["--json", "--jobs", jobs, "-o", "f.json"]);
        check(&folder, &arguments, 0, &["f.json"]).stdout
    };
    let (one, two, again) = (run("1"), run("2"), run("2"));
    assert!(one == two && two == again);
    assert_eq!(fs::read(folder.path().join("f.json")).unwrap(), one, "the same in the file");
}

#[test]
fn forecast_methods_pick_columns_and_change_no_other() {
    let folder = clips(3);
    let all = check_json(&folder, &forecast(&["--json"]), 0);
    let some = check_json(&folder, &forecast(&["--methods", "mixed,knn,mixed", "--json"]), 0);
    assert_eq!(keys(&some["summary"]), ["knn", "mixed"]);
    assert_eq!(keys(&some["clips"][2]["methods"]), ["knn", "mixed"]);
    for method in ["knn", "mixed"] {
        assert_eq!(some["summary"][method], all["summary"][method]);
    }
}

#[test]
fn methods_of_another_protocol_are_refused() {
    let folder = clips(2);
    let own = ["forecast", "zero_velocity, constant_velocity", "mixed"];
    check(&folder, &forecast(&["--methods", "knn,mesh"]), 2, &[&["'mesh'"], &own[..]].concat());
    for protocol in ["leave_one_out", "displaced"] {
        let arguments = ["evaluate", "clips", "--protocol", protocol, "--methods", "hold,delaunay"];
        check(&folder, &arguments, 2, &["'delaunay'", protocol, "hold, replay, knn"]);
    }
    // Before anything is read.
    let nowhere = ["evaluate", "no", "--protocol", "forecast", "--methods", "hold"];
    check(&folder, &nowhere, 2, &["'hold'"]);
    check(&folder, &forecast(&["--methods", "magic"]), 2, &["magic"]);
}

#[test]
fn options_that_say_nothing_to_a_forecast_are_refused() {
    let folder = clips(2);
    check(&folder, &forecast(&["--plot", "f.svg"]), 2, &["--plot", "only the protocol thesis"]);
    check(&folder, &forecast(&["--method", "grow"]), 2, &["--method", "learns no edges"]);
    check(&folder, &forecast(&["--kernel", "uniform"]), 2, &["--kernel", "learns no edges"]);
    check(&folder, &forecast(&["-o", "f.txt"]), 2, &["f.txt", ".json"]);
    for (setting, bound) in [
        ("forecast.neighbours=0", "must be a whole number from 1 to 1000"),
        ("forecast.averaged=1001", "must be a whole number from 1 to 1000"),
        ("forecast.simplex_dimensions=5", "must be a whole number from 2 to 4"),
        ("forecast.velocity_window=0", "must be a number from 0.001 to 10"),
        ("forecast.velocity_weight=0", "must be a number from 0.001 to 1000"),
    ] {
        check(&folder, &forecast(&["--set", setting]), 2, &[&setting.replace('=', " is "), bound]);
    }
}

#[test]
fn one_clip_has_nobody_to_be_forecast_from() {
    let folder = clips(1);
    check(&folder, &forecast(&[]), 1, &["1 group", "needs one"]);
    let folder = clips(3);
    check(&folder, &forecast(&["--group", "pair", "--filter", "[01].csv"]), 1, &["1 group"]);
}

#[test]
fn clips_too_short_for_a_horizon_have_no_figure_there() {
    // 0.77 s: with 0.3 s of past none is left 0.5 s later. The last is over after 0.23 s.
    let folder = clips(4);
    rewrite(&folder, "3", |frame, time| (frame < 8).then_some(time));
    let found = check_json(&folder, &forecast(&["--json"]), 0);
    for method in METHODS {
        for figure in FIGURES {
            let figures = &found["clips"][0]["methods"][method][figure];
            assert!(figures[2].is_number() && figures[3].is_null(), "{method}: {figures}");
            assert_eq!(
                found["clips"][3]["methods"][method][figure],
                json!([null, null, null, null])
            );
            let summary = &found["summary"][method][figure];
            assert_eq!((&summary[2]["n"], &summary[3]), (&json!(3), &Value::Null));
        }
    }
    check(&folder, &forecast(&[]), 0, &["4 clips", " -\n"]);
    // Nobody long enough to learn from.
    for clip in ["0", "1", "2", "3"] {
        rewrite(&folder, clip, |frame, time| (frame < 5).then_some(time));
    }
    check(&folder, &forecast(&[]), 1, &["no motion long enough to learn from", "0.2 s"]);
}

#[test]
fn parameters_far_beyond_the_clips_make_no_panic() {
    let folder = clips(3);
    let extreme = [
        ["forecast.simplex_dimensions=4", "forecast.averaged=1000", "forecast.neighbours=1000"],
        ["forecast.dimensions=1000", "forecast.smoothing=1", "forecast.ridge_penalty=1e6"],
        ["forecast.dimensions=1", "forecast.simplex_dimensions=2", "forecast.averaged=1"],
        ["forecast.velocity_weight=1e3", "forecast.ridge_penalty=1e-9", "forecast.smoothing=0"],
        [
            "forecast.velocity_weight=1e-3",
            "forecast.velocity_window=0.001",
            "forecast.neighbours=1",
        ],
        ["forecast.joint_damping=1e3", "forecast.root_damping=1e-3", "forecast.averaged=2"],
    ];
    for settings in extreme {
        let more = settings.map(|setting| ["--set", setting]).concat();
        let found = check_json(&folder, &forecast(&[&["--json"], &more[..]].concat()), 0);
        let figures = found["summary"].as_object().unwrap().values();
        let finite = |summary: &Value| summary["mean"].as_f64().is_some_and(f64::is_finite);
        for figures in figures {
            assert!(figures["joint_cm"].as_array().unwrap()[..3].iter().all(finite), "{figures}");
        }
    }
    let past = ["--set", "forecast.velocity_window=10"];
    check(&folder, &forecast(&past), 1, &["none lasts 10.1 s"]);
}
