//! `handover evaluate --protocol displaced` as a user meets it: the real process, its table and its
//! JSON.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

#[path = "common/clips.rs"]
mod clips;
mod common;

use std::fs;

use clips::{FIGURES, FRAMES, METHODS, clips, keys};
use common::{check, check_json};
use serde_json::{Value, json};

const CONDITIONS: [&str; 10] = [
    "up_0.1",
    "up_0.2",
    "left_0.1",
    "left_0.2",
    "right_0.1",
    "right_0.2",
    "nearer_0.1",
    "nearer_0.2",
    "scale_0.8",
    "scale_1.2",
];
/// What has no truth where nobody was.
const UNKNOWN: [&str; 4] = ["joint_cm", "hand_cm", "contact_cm", "reach_ms"];

fn displaced<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let arguments = ["evaluate", "clips", "--protocol", "displaced"];
    arguments.into_iter().chain(more.iter().copied()).collect()
}

/// A summary of every method, over this many clips and conditions.
#[track_caller]
fn check_summary(summary: &Value, n: usize) {
    assert_eq!(keys(summary), METHODS);
    for figures in summary.as_object().unwrap().values() {
        assert_eq!(keys(figures), FIGURES);
        for (figure, summary) in figures.as_object().unwrap() {
            if UNKNOWN.contains(&figure.as_str()) {
                assert!(summary.is_null(), "{figure}: {summary}");
            } else {
                assert_eq!(keys(summary), ["mean", "median", "low", "high", "n"]);
                assert_eq!(summary["n"], n, "{figure}");
            }
        }
    }
}

#[test]
fn the_displaced_json_has_the_promised_shape() {
    let folder = clips(3);
    let found = check_json(&folder, &displaced(&["--json"]), 0);
    let about = ["protocol", "role", "causal", "methods"];
    let figures = ["clips", "summary", "scaled", "conditions"];
    assert_eq!(keys(&found), [&about[..], &figures, &["group", "changes"]].concat());
    assert_eq!((&found["causal"], &found["group"]), (&json!(false), &json!(null)));
    assert_eq!((&found["protocol"], &found["role"]), (&json!("displaced"), &json!("giver")));
    let clips = found["clips"].as_array().unwrap();
    let entries = clips.iter().map(|clip| (&clip["name"], &clip["condition"]));
    let expected = ["0", "1", "2"].map(|name| CONDITIONS.map(|one| (json!(name), json!(one))));
    let expected = expected.concat();
    assert!(entries.eq(expected.iter().map(|(name, condition)| (name, condition))));
    for clip in clips {
        let shape = ["name", "frames", "condition", "displacement_m", "scale", "methods"];
        assert_eq!(keys(clip), shape);
        assert_eq!(clip["frames"], FRAMES);
        assert_eq!(keys(&clip["methods"]), METHODS);
        for figures in clip["methods"].as_object().unwrap().values() {
            assert_eq!(keys(figures), FIGURES);
            for (figure, value) in figures.as_object().unwrap() {
                assert_eq!(value.is_null(), UNKNOWN.contains(&figure.as_str()), "{figure}");
            }
        }
    }
    // The receiver stands at +x and is looked at along it.
    let at = |condition: &str| {
        let at = CONDITIONS.iter().position(|one| *one == condition).unwrap();
        (&clips[at]["displacement_m"], &clips[at]["scale"])
    };
    let near = |found: &Value, expected: [f64; 3]| {
        let found = found.as_array().unwrap().iter().map(|x| x.as_f64().unwrap());
        found.zip(expected).all(|(a, b)| (a - b).abs() < 1e-9)
    };
    for (condition, displacement, scale) in [
        ("up_0.2", [0.0, 0.0, 0.2], 1.0),
        ("left_0.1", [0.0, 0.1, 0.0], 1.0),
        ("right_0.2", [0.0, -0.2, 0.0], 1.0),
        ("nearer_0.1", [-0.1, 0.0, 0.0], 1.0),
        ("scale_0.8", [0.0; 3], 0.8),
        ("scale_1.2", [0.0; 3], 1.2),
    ] {
        assert!(near(at(condition).0, displacement), "{condition}: {}", at(condition).0);
        assert_eq!(at(condition).1, scale, "{condition}");
    }
    check_summary(&found["summary"], 3 * 8);
    check_summary(&found["scaled"], 3 * 2);
    assert_eq!(keys(&found["conditions"]), CONDITIONS);
    for condition in CONDITIONS {
        check_summary(&found["conditions"][condition], 3);
    }
    // Pooled: the mean of the conditions' means, as each has as many clips.
    let gap = |summary: &Value| summary["mesh"]["gap_cm"]["mean"].as_f64().unwrap();
    let eight = &CONDITIONS[..8];
    let mean = eight.iter().map(|one| gap(&found["conditions"][one])).sum::<f64>() / 8.0;
    assert!((gap(&found["summary"]) - mean).abs() < 1e-9);
}

#[test]
fn threads_change_no_byte_of_displaced() {
    let folder = clips(3);
    let run = |jobs: &str| {
        check(&folder, &displaced(&["--json", "--jobs", jobs, "-o", "e.json"]), 0, &["e.json"])
    };
    let (one, two) = (run("1"), run("2"));
    assert_eq!(one.stdout, two.stdout);
    assert_eq!(fs::read(folder.path().join("e.json")).unwrap(), one.stdout, "the same in the file");
}

#[test]
fn the_displaced_tables_show_what_is_known() {
    let folder = clips(3);
    let words = [
        "displaced: 3 clips (72 frames) × 8 displacements, the robot is giver",
        "scaled: 3 clips × 2 sizes of the robot",
        "6 of these 6 within reach",
    ];
    let found = check(&folder, &displaced(&["--methods", "hold,mesh"]), 0, &words);
    let text = String::from_utf8(found.stdout).unwrap();
    let rows = |start: &str| -> Vec<Vec<&str>> {
        let rows = text.lines().filter(|line| line.starts_with(start));
        rows.map(|row| row.split_whitespace().skip(1).collect()).collect()
    };
    for method in ["hold", "mesh"] {
        let [pooled, conditions, scaled] = &rows(method)[..] else { panic!("{text}") };
        for row in [pooled, scaled] {
            assert!(row[..4].iter().all(|cell| *cell == "-"), "{row:?}");
            assert_eq!(row.len(), 4 + 3 * 3 + 1 + 2 * 3, "mean / median of five figures: {row:?}");
        }
        assert_eq!(conditions.len(), CONDITIONS.len());
        assert!(conditions.iter().all(|cell| cell.parse::<f64>().is_ok()), "{conditions:?}");
    }
    assert!(!text.contains("(human)") && text.lines().any(|l| l.split_whitespace().eq(CONDITIONS)));
}

#[test]
fn displaced_fails_and_loses_as_leave_one_out_does() {
    let folder = clips(2);
    let only = ["--filter", "0.csv"];
    check(&folder, &displaced(&only), 1, &["1 group", "learns from the others and needs two"]);
    check(&folder, &displaced(&["--set", "evaluate.ignored_joints=[tail]"]), 1, &["'tail'"]);
    let unanchored = displaced(&[
        "--methods",
        "hold,none",
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
    let named = ["not predicted: 0 up_0.1, none", "not predicted: 1 scale_1.2, none"];
    check(&folder, &unanchored, 3, &named);
}
