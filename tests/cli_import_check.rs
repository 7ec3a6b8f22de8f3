//! `handover import` and `handover check` as a user meets them: the real process, its exit code
//! and its words.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

mod common;

use std::fs;

use common::{check, check_json, folder};
use serde_json::Value;
use tempfile::TempDir;

const HEADER: &str = "frame,time_s,person,joint,x,y,z";

fn good_csv() -> String {
    let mut text = format!("{HEADER}\n");
    for frame in 0..4 {
        for (person, x) in [("giver", 0.0), ("receiver", 1.0 - 0.2 * f64::from(frame))] {
            for joint in ["head", "torso", "right_hand"] {
                text += &format!("{frame},0.{frame},{person},{joint},{x:.1},0,1\n");
            }
        }
    }
    text
}

fn sbu_text() -> String {
    let line = |frame: u32| format!("{frame}{}\r\n", ",0.5".repeat(90));
    (1..4).map(line).collect()
}

fn names(folder: &TempDir, below: &str) -> Vec<String> {
    let entries = fs::read_dir(folder.path().join(below)).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn check_says_what_a_good_file_holds() {
    let clips = folder(&[("a.csv", &good_csv())]);
    let words = [
        "a.csv: CSV, giver (3 joints) and receiver (3 joints), 4 frames, 10.0 Hz, 0.30 s",
        "hands closest: 0.400 m, giver/right_hand and receiver/right_hand, at 0.300 s (frame 3)",
    ];
    check(&clips, &["check", "a.csv"], 0, &words);
    let found = &check_json(&clips, &["check", "--json", "a.csv"], 0)["files"][0];
    assert_eq!((&found["frames"], &found["rate_hz"]), (&Value::from(4), &Value::from(10.0)));
    assert_eq!(found["errors"], Value::Array(Vec::new()));
    assert_eq!(found["closest_hands"]["frame"], 3);
}

#[test]
fn check_names_file_line_and_reason() {
    let bad = good_csv().replace("2,0.2,giver,head,0.0", "2,0.2,giver,head,wide");
    let clips = folder(&[("a.csv", &good_csv()), ("b.csv", &bad), ("c.csv", "")]);
    let words =
        ["b.csv: BAD\n  line 14: field 'x': 'wide' is not a number", "2 of 3 files are bad"];
    check(&clips, &["check", "a.csv", "b.csv", "c.csv"], 3, &words);
    check(&clips, &["check", "b.csv"], 1, &["line 14"]);
    check(&clips, &["check", "c.csv"], 1, &["c.csv: BAD\n  line 1: the file is empty"]);
    let found = check_json(&clips, &["check", ".", "--json"], 3);
    let error = &found["files"][1]["errors"][0];
    assert_eq!(
        (&error["line"], &found["files"][1]["good"]),
        (&Value::from(14), &Value::from(false))
    );
}

#[test]
fn what_is_not_there_is_exit_1_and_wrong_usage_exit_2() {
    let clips = folder(&[("a.csv", &good_csv()), ("empty/.keep", "")]);
    check(&clips, &["check", "nowhere.csv"], 1, &["nowhere.csv: no such file or folder"]);
    check(&clips, &["import", "nowhere", "out"], 1, &["nowhere: no such file or folder"]);
    check(
        &clips,
        &["check", "empty"],
        1,
        &["empty: no recording (.csv, .txt, .mcap, .db3, .zstd)"],
    );
    check(&clips, &["check", ".", "--filter", "z*"], 1, &["matches the filter"]);
    check(&clips, &["check"], 2, &["FILE"]);
    check(&clips, &["check", "a.csv", "--up", "x"], 2, &["--up"]);
    check(&clips, &["check", "a.csv", "--filter", "[a"], 2, &["--filter"]);
    check(&clips, &["check", "a.csv", "--jobs", "0"], 2, &["--jobs"]);
    check(&clips, &["fly"], 2, &["fly"]);
    check(&clips, &["--help"], 0, &["import", "check"]);
}

#[test]
fn import_refuses_an_out_it_cannot_write() {
    let clips = folder(&[("a.csv", &good_csv()), ("d/a.csv", &good_csv())]);
    check(
        &clips,
        &["import", "a.csv", "b.db3"],
        2,
        &["b.db3: cannot write '.db3'", ".csv, .mcap or .bag"],
    );
    check(&clips, &["import", "a.csv", "b"], 2, &["there is none"]);
    check(&clips, &["import", "a.csv", "d"], 2, &["d is a folder"]);
    check(&clips, &["import", "d", "out.csv"], 2, &["out.csv names a file"]);
    check(&clips, &["import", "d", "a.csv"], 2, &["a.csv names a file"]);
    check(&clips, &["import", "a.csv", "no/b.csv"], 1, &["cannot write no/b.csv"]);
    assert_eq!(names(&clips, "."), ["a.csv", "d"]);
}

#[test]
fn import_of_a_file_writes_one_that_reads_back() {
    let clips = folder(&[("a.csv", &good_csv())]);
    check(&clips, &["import", "a.csv", "b.csv", "--up", "y"], 0, &["b.csv"]);
    let text = fs::read_to_string(clips.path().join("b.csv")).unwrap();
    assert!(text.contains("\n0,0,giver,head,0,-1,0\n"), "{text}");
    check(&clips, &["check", "b.csv"], 0, &["10.0 Hz"]);
    let cut = &good_csv()[..good_csv().len() - 12];
    fs::write(clips.path().join("cut.csv"), cut).unwrap();
    let words = ["cut.csv: line 25: expected 7 fields, got 4", "0 written, 1 left out"];
    check(&clips, &["import", "cut.csv", "c.csv"], 1, &words);
    assert_eq!(names(&clips, "."), ["a.csv", "b.csv", "cut.csv"]);
}

#[test]
fn import_of_a_folder_goes_on_and_names_every_violation() {
    let bad = good_csv().replace("giver,torso,0.0", "giver,torso,NaN");
    let clips = folder(&[
        ("raw/s03s01/07/001/skeleton_pos.txt", &sbu_text()),
        ("raw/s03s01/05/002/skeleton_pos.txt", &sbu_text()),
        ("raw/x/a.csv", &good_csv()),
        ("raw/y/a.csv", &good_csv()),
        ("raw/bad.csv", &bad),
    ]);
    let words = [
        "raw/bad.csv: line 3: field 'x': 'NaN' is not finite",
        "raw/bad.csv: line 21: field 'x': 'NaN' is not finite",
        "4 written, 1 left out",
    ];
    check(&clips, &["import", "raw", "out"], 3, &words);
    let written = ["s03s01_05_002.csv", "s03s01_07_001.csv", "x_a.csv", "y_a.csv"];
    assert_eq!(names(&clips, "out"), written);
    let text = fs::read_to_string(clips.path().join("out/s03s01_07_001.csv")).unwrap();
    let head = "# class=07\n# ordered_pair=s03s01\n# pair=s01s03\n# take=001\nframe,";
    assert!(text.starts_with(head), "{text}");
    // The class survives the import, and chooses among SBU folders and CSVs alike.
    check(&clips, &["check", "out", "raw", "--class", "07"], 0, &["class=07", "SBU text"]);
    let found = check_json(&clips, &["check", "raw", "--class", "05", "--json"], 0);
    assert_eq!(found["files"][0]["name"], "s03s01/05/002");
    assert_eq!(found["files"][0]["metadata"]["pair"], "s01s03");
    let found = check_json(&clips, &["import", "raw", "out2", "--json", "--quiet"], 3);
    assert_eq!(found["written"].as_array().unwrap().len(), 4);
    assert_eq!(found["failed"][0]["errors"][0]["line"], 3);
    let only = ["import", "raw", "out3", "--filter", "s0*/07/*"];
    check(&clips, &only, 0, &["out3/s03s01_07_001.csv"]);
}

#[test]
fn up_y_is_refused_for_sbu() {
    let clips = folder(&[("skeleton_pos.txt", &sbu_text()), ("a.csv", &good_csv())]);
    check(&clips, &["check", "skeleton_pos.txt", "--up", "z"], 0, &[]);
    let words = ["skeleton_pos.txt: line 1: SBU text has fixed axes"];
    check(&clips, &["import", ".", "out", "--up", "y"], 3, &words);
}

#[test]
fn nothing_good_is_exit_1() {
    let clips = folder(&[("raw/a.csv", "hello\n"), ("raw/b.txt", "\u{1}\u{2}")]);
    check(&clips, &["import", "raw", "out"], 1, &["a.csv: line 1: neither CSV", "b.txt: line 1"]);
    check(&clips, &["check", "raw"], 1, &["raw/a.csv: BAD"]);
}

#[test]
fn threads_change_nothing() {
    let files: Vec<(String, String)> =
        (0..30).map(|k| (format!("raw/{k}.csv"), good_csv())).collect();
    let files: Vec<(&str, &str)> = files.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let clips = folder(&files);
    let one = check(&clips, &["check", "raw", "--jobs", "1"], 0, &[]);
    let four = check(&clips, &["check", "raw", "--jobs", "4"], 0, &[]);
    assert_eq!(one.stdout, four.stdout);
}
