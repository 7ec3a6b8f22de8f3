//! `./run` as a user meets it: the real script and the real program, but nothing is built and
//! nothing is written beside the sources.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

#[path = "common/clips.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod clips;
#[allow(dead_code, reason = "other tests use the rest")]
mod common;
#[path = "common/sqlite.rs"]
mod sqlite;

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Command, Output};

use clips::{clips, keys};
use handover_mesh::formats::{UpAxis, bag, csv};
use serde_json::Value;
use tempfile::TempDir;

/// Clips; beside them the script, with a cargo that builds nothing and the program of the tests.
fn checkout(count: u32) -> TempDir {
    let folder = clips(count);
    let sources = Path::new(env!("CARGO_MANIFEST_DIR"));
    for path in ["run", ".ci/prepare", ".ci/ros"] {
        let copy = folder.path().join(path);
        fs::create_dir_all(copy.parent().unwrap()).unwrap();
        fs::copy(sources.join(path), copy).unwrap();
    }
    let target = folder.path().join("target").display().to_string();
    let cargo = format!(
        "#!/bin/sh\n[ \"$1\" != metadata ] || echo '{{\"target_directory\":\"{target}\"}}'\n"
    );
    let handover = format!("#!/bin/sh\nexec '{}' \"$@\"\n", env!("CARGO_BIN_EXE_handover"));
    for (path, text) in [("bin/cargo", cargo), ("target/release/handover", handover)] {
        let path = folder.path().join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, text).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    }
    folder
}

/// Runs the script, and checks its exit code and words of what it says.
#[track_caller]
fn run(folder: &TempDir, arguments: &[&str], code: i32, words: &[&str]) -> Output {
    let path = std::env::var("PATH").unwrap();
    let output = Command::new("bash")
        .arg("run")
        .args(arguments)
        .current_dir(folder.path())
        .env("PATH", format!("{}:{path}", folder.path().join("bin").display()))
        .env("NO_ROS", if folder.path().join("bin/python").exists() { "0" } else { "1" })
        .output()
        .unwrap();
    let said = [&output.stdout[..], &output.stderr].concat();
    let said = String::from_utf8(said).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    for word in words {
        assert!(said.contains(word), "{arguments:?}: no '{word}' in: {said}");
    }
    output
}

fn json(folder: &TempDir) -> Value {
    let text = fs::read(folder.path().join("build/run/evaluation.json")).unwrap();
    serde_json::from_slice(&text).unwrap()
}

#[test]
fn every_option_of_evaluate_takes_a_value_or_none() {
    let folder = checkout(1);
    let help = Command::new(env!("CARGO_BIN_EXE_handover")).args(["evaluate", "-h"]).output();
    let help = String::from_utf8(help.unwrap().stdout).unwrap();
    let mut seen = 0;
    for line in help.lines() {
        let words = line.split_whitespace().map(|word| word.trim_end_matches(','));
        let words: Vec<&str> = words.collect();
        let Some(at) = words.iter().take(2).position(|word| word.starts_with("--")) else {
            continue;
        };
        // The help of one goes no further, and some are chosen by the script.
        let option = words[at];
        if ["--help", "--json", "--protocol", "--out"].contains(&option) {
            continue;
        }
        seen += 1;
        // Refused for two folders, and only that: so neither of these was taken for a value.
        let two = "one DIR only, not one two";
        if words.get(at + 1).is_some_and(|word| word.starts_with('<')) {
            run(&folder, &["one", option, "value", "two"], 2, &[two]);
            run(&folder, &["one", &format!("{option}=value"), "two"], 2, &[two]);
            run(&folder, &["one", option], 2, &[&format!("{option} takes a value")]);
        } else {
            run(&folder, &["one", option, "two"], 2, &[two]);
        }
    }
    assert!(seen > 12, "{seen} options in: {help}");
    run(&folder, &["--casual", "one"], 2, &["unknown option '--casual'"]);
}

#[test]
fn a_run_that_fails_leaves_the_last_results() {
    let folder = checkout(3);
    run(&folder, &["clips", "--methods", "hold", "-q"], 0, &["replayed clip   "]);
    let results = || {
        let entries = fs::read_dir(folder.path().join("build/run")).unwrap();
        let files = entries.map(|entry| entry.unwrap().path());
        files.map(|path| (path.clone(), fs::read(path).unwrap())).collect::<BTreeMap<_, _>>()
    };
    let last = results();
    assert_eq!(last.len(), 5, "{:?}", last.keys());
    run(&folder, &["clips", "--methods", "foo"], 2, &["foo"]);
    run(&folder, &["none"], 1, &["none: no such file or folder"]);
    assert!(last == results());
    run(&folder, &["clips", "--methods", "knn", "-q"], 0, &[]);
    let new = results();
    assert!(last != new && last.keys().eq(new.keys()), "{:?}", new.keys());
}

#[test]
fn bags_are_replayed_as_clips_are() {
    let folder = checkout(3);
    for ending in ["mcap", "bag", "db3"] {
        let bags = folder.path().join(ending);
        fs::create_dir(&bags).unwrap();
        for number in 0..3 {
            let name = format!("{ending}/{number}.{ending}");
            let clip = format!("clips/{number}.csv");
            if ending != "db3" {
                common::check(&folder, &["import", &clip, &name], 0, &[]);
                continue;
            }
            let bytes = fs::read(folder.path().join(clip)).unwrap();
            let recording = csv::read(&bytes, "clip", UpAxis::Z).unwrap();
            let written = bag::write(&recording, "clip_0.mcap").unwrap();
            sqlite::sqlite_of(&written.mcap, &written.metadata, &folder.path().join(name));
        }
        let words = format!("replay.jsonl, from {ending}/0.{ending}");
        run(&folder, &[ending, "--methods", "hold", "-q"], 0, &[&words]);
        let trace = fs::read(folder.path().join("build/run/replay.jsonl")).unwrap();
        assert!(trace.len() > 10_000, "{ending}");
    }
}

#[test]
fn without_ros_it_says_so_and_goes_on() {
    let folder = checkout(3);
    let words = ["SKIPPED: all of ROS 2: NO_ROS=1", "ROS 2           left out", "figures   "];
    run(&folder, &["clips", "--methods", "hold", "-q"], 0, &words);
    // The option wins over a ROS 2 that is there.
    with_ros(&folder, "exit 1");
    run(&folder, &["--no-ros", "clips", "--methods", "hold", "-q"], 0, &words);
}

#[test]
fn the_handover_on_topics_comes_last_and_counts() {
    let folder = checkout(3);
    with_ros(&folder, "echo \"talked about $3 as $5\"");
    let arguments = ["clips", "--methods", "hold", "-q"];
    run(&folder, &arguments, 0, &["on ROS 2 topics (sourced):", "model.safetensors as giver"]);
    let said = fs::read_to_string(folder.path().join("build/run/ros.txt")).unwrap();
    assert!(said.starts_with("talked about "), "{said}");
    // What failed there is no result: the last ones are back.
    with_ros(&folder, "echo \"error: no target\" >&2; exit 1");
    run(&folder, &arguments, 1, &["error: no target"]);
    assert_eq!(fs::read_to_string(folder.path().join("build/run/ros.txt")).unwrap(), said);
}

/// Puts a ROS 2 into the checkout whose Python is a line of shell, a simulator that makes up the
/// clips that are there, and a cargo that was asked for the node.
fn with_ros(folder: &TempDir, python: &str) {
    let ros = "ros=; [ \"$NO_ROS\" = 1 ] && echo \"SKIPPED: all of ROS 2: NO_ROS=1\" >&2 ||\n\
               { ros=sourced; ros_python=$root/bin/python; }\n";
    fs::write(folder.path().join(".ci/ros"), ros).unwrap();
    let python = format!("#!/bin/sh\n{python}\n");
    let clips = folder.path().join("clips").display().to_string();
    let simulator = format!(
        "#!/bin/sh\nwhile [ $# -gt 1 ]; do shift; done\nmkdir -p \"$1\"\ncp -r '{clips}' \"$1/measured\"\n"
    );
    for (path, text) in [("bin/python", python), ("target/release/handover_sim", simulator)] {
        let path = folder.path().join(path);
        fs::write(&path, text).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    }
}

#[test]
fn the_folder_behind_an_option_without_a_value_is_evaluated() {
    let folder = checkout(3);
    run(&folder, &["--causal", "clips", "--methods", "hold"], 0, &["recordings      clips"]);
    let found = json(&folder);
    assert_eq!(found["clips"].as_array().unwrap().len(), 3);
    assert_eq!(keys(&found["summary"]), ["hold"]);
}
