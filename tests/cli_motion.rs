//! `handover motion` as a user meets it: the real process, its exit code, its words and its JSON.

#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "helpers of tests fail by panicking")]

#[path = "common/clips.rs"]
#[allow(dead_code, reason = "what the figures are called is for other tests")]
mod clips;
mod common;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use clips::{FRAMES, clips, keys};
use common::{check, check_json, folder};
use serde_json::Value;
use tempfile::TempDir;

const COLUMNS: [&str; 3] = ["knn", "delaunay", "k_delaunay"];

/// A leg of four angles.
const SKELETON: &str = "\
:version 1.10
:name leg
:units
  mass 1.0
  length 0.45
  angle deg
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name thigh
     direction 0 -1 0
     length 7
     axis 0 0 20 XYZ
    dof rx rz
    limits (-160.0 20.0)
           (-70.0 60.0)
  end
  begin
     id 2
     name shin
     direction 0 -1 0
     length 7
     axis 0 0 20 XYZ
    dof rx
    limits (-10.0 170.0)
  end
  begin
     id 3
     name foot
     direction 0 -0.3 1
     length 2
     axis 0 0 0 XYZ
    dof rx
    limits (-45.0 90.0)
  end
:hierarchy
  begin
    root thigh
    thigh shin
    shin foot
  end
";

/// Steps on the spot; every `number` is a little different.
fn steps(number: u32) -> String {
    let mut text = "#!OML:ASF leg.ASF\n:FULLY-SPECIFIED\n:DEGREES\n".to_owned();
    let number = f64::from(number);
    for frame in 1..=60 + 4 * number as u32 {
        let turn = 0.2 * f64::from(frame) + number;
        let size = 30.0 + 0.7 * number;
        let angles = [size * turn.sin(), 4.0 * turn.cos(), size * (1.0 + turn.cos())];
        let foot = 8.0 * (2.0 * turn).sin() + 0.3 * number;
        let _ = write!(
            text,
            "{frame}\nroot 0 17 {frame} 0 0 0\nthigh {} {}\nshin {}\nfoot {foot}\n",
            angles[0], angles[1], angles[2]
        );
    }
    text
}

/// `walk/leg.asf` and `walk/0.amc` and so on.
fn walk(count: u32) -> TempDir {
    let folder = folder(&[("walk/leg.asf", SKELETON)]);
    for number in 0..count {
        fs::write(folder.path().join(format!("walk/{number}.amc")), steps(number)).unwrap();
    }
    folder
}

#[test]
fn the_table_stands_beside_the_papers() {
    let folder = walk(4);
    let words = [
        "motion: 4 sequences, 264 frames, 4 folds",
        "2 dimensions explain",
        "graph knn",
        "strongly connected component(s)",
        "in the latent space [rad]",
        "error A",
        "error F",
        "(w1)",
        "k_delaunay",
        "0.749",
    ];
    let output = check(&folder, &["motion", "walk"], 0, &words);
    let text = String::from_utf8(output.stdout).unwrap();
    let rows = text.lines().skip_while(|line| !line.contains("(w1)")).skip(1);
    let rows: Vec<Vec<&str>> = rows.map(|row| row.split_whitespace().collect()).collect();
    assert_eq!(rows.len(), 6, "{text}");
    assert_eq!(
        (&rows[1][..1], &rows[1][2..]),
        (&["delaunay"][..], &["0.023", "0.073", "0.749", "0.068", "0.068"][..],)
    );
    assert_eq!(rows[5][2..], ["-"; 5], "the paper has no figures of its future work");
    assert!(rows.iter().flatten().any(|word| word.parse::<f64>().is_ok_and(|x| x < 0.1)));
}

#[test]
fn the_json_has_the_promised_shape_in_the_file_too() {
    let folder = walk(5);
    let found = check_json(&folder, &["motion", "walk", "--json", "--out", "m.json"], 0);
    assert_eq!(keys(&found), ["dims", "folds", "error_a", "error_f", "unit"]);
    assert_eq!((&found["dims"], &found["unit"]), (&2.into(), &"rad".into()));
    assert_eq!(found["folds"].as_array().unwrap().len(), 4);
    let first = &found["folds"][0];
    assert_eq!(keys(first), ["dims", "explained", "poses", "edges", "components", "sequences"]);
    let names: Vec<&Value> =
        first["sequences"].as_array().unwrap().iter().map(|s| &s["name"]).collect();
    assert_eq!(names, ["0", "4"]);
    for error in ["error_a", "error_f"] {
        assert_eq!(keys(&found[error]), COLUMNS);
        assert!(found[error].as_object().unwrap().values().all(Value::is_number));
    }
    let written = fs::read(folder.path().join("m.json")).unwrap();
    assert_eq!(serde_json::from_slice::<Value>(&written).unwrap(), found);
    check(&folder, &["motion", "walk", "--out", "m.txt"], 2, &["m.txt", ".json"]);
}

#[test]
fn jobs_change_no_byte_of_made_up_motions() {
    let folder = walk(5);
    let run = |jobs| check(&folder, &["motion", "walk", "--json", "--jobs", jobs], 0, &[]).stdout;
    assert_eq!(run("1"), run("3"));
}

#[test]
fn one_neighbourhood_is_one_column() {
    let folder = walk(3);
    for column in COLUMNS {
        let arguments = ["motion", "walk", "--neighbourhood", column, "--json"];
        let found = check_json(&folder, &arguments, 0);
        assert_eq!(keys(&found["error_a"]), [column]);
        assert_eq!(found["folds"].as_array().unwrap().len(), 3);
    }
}

#[test]
fn dimensions_are_counted_or_follow_from_the_variance() {
    let folder = walk(3);
    let dims = |more: &[&str]| {
        check_json(&folder, &[&["motion", "walk", "--json"], more].concat(), 0)["dims"].clone()
    };
    assert_eq!(dims(&["--dims", "3"]), 3);
    assert_eq!(dims(&["--set", "motion.dimensions=3"]), 3);
    assert_eq!(dims(&["--variance", "0.2", "--neighbourhood", "knn"]), 1);
    assert_eq!(dims(&["--variance", "1", "--neighbourhood", "knn"]), 4);
    assert_eq!(dims(&["--folds", "2"]), 2);
}

#[test]
fn usage_errors_name_the_option() {
    let folder = walk(2);
    let usage = |more: &[&str], words: &[&str]| {
        check(&folder, &[&["motion", "walk"], more].concat(), 2, words);
    };
    usage(&["--dims", "0"], &["--dims", "0 is not in 1..=1000"]);
    usage(&["--neighbourhood", "some"], &["some", "knn, delaunay, k_delaunay, all"]);
    usage(&["--dims", "2", "--variance", "0.9"], &["--dims", "--variance"]);
    for share in ["0", "1.01", "nan", "much"] {
        usage(&["--variance", share], &["--variance"]);
    }
    usage(&["--folds", "1"], &["--folds", "2..=1000"]);
    check(&folder, &["motion"], 2, &["SEQUENCE"]);
    check(&folder, &["motion", "nowhere"], 1, &["nowhere: no such file"]);
}

#[test]
fn what_has_no_triangulation_names_the_nearest_neighbours() {
    let folder = walk(3);
    let run = |dims, neighbourhood, code, words: &[&str]| {
        let arguments = ["motion", "walk", "--dims", dims, "--neighbourhood", neighbourhood];
        check(&folder, &arguments, code, words);
    };
    for neighbourhood in ["delaunay", "k_delaunay", "all"] {
        for (dims, not) in [("1", "not 1"), ("6", "not 6")] {
            run(dims, neighbourhood, 1, &[not, "neighbourhood knn takes any"]);
        }
    }
    run("1", "knn", 0, &["1 dimensions explain"]);
    run("6", "knn", 1, &["without 0", "span 4", "hint: fewer dimensions"]);
    // No triangulation of as many dimensions as follow from the variance.
    let clips = clips(4);
    let share = ["motion", "clips", "--variance", "1", "--neighbourhood"];
    check(&clips, &[&share[..], &["knn"]].concat(), 0, &["5 dimensions explain"]);
    let words = ["not 5", "neighbourhood knn takes any"];
    check(&clips, &[&share[..], &["delaunay"]].concat(), 1, &words);
}

#[test]
fn a_broken_motion_is_named_and_the_rest_goes_on() {
    let folder = walk(4);
    let path = |number: u32| folder.path().join(format!("walk/{number}.amc"));
    let cut = steps(3);
    fs::write(path(3), &cut[..cut.rfind("shin").unwrap()]).unwrap();
    fs::write(path(2), steps(2).replacen("thigh ", "thigh x", 1)).unwrap();
    let words = ["3.amc: line ", "2.amc: line 6", "2 sequences"];
    check(&folder, &["motion", "walk"], 3, &words);
    fs::remove_file(path(0)).unwrap();
    check(&folder, &["motion", "walk"], 1, &["1 sequence(s)", "needs one"]);
    fs::remove_file(path(1)).unwrap();
    check(&folder, &["motion", "walk"], 1, &["no sequence is left to work with"]);
}

#[test]
fn a_motion_takes_the_only_skeleton_beside_it() {
    let folder = walk(3);
    let skeleton = folder.path().join("walk/leg.asf");
    fs::copy(&skeleton, folder.path().join("walk/other.ASF")).unwrap();
    check(&folder, &["motion", "walk"], 1, &["0.amc: which skeleton?", "leg.asf", "other.ASF"]);
    fs::remove_file(folder.path().join("walk/other.ASF")).unwrap();
    fs::write(&skeleton, SKELETON.replace("length 2", "length two")).unwrap();
    check(&folder, &["motion", "walk"], 1, &["leg.asf: line 36", "'two'"]);
    fs::remove_file(&skeleton).unwrap();
    check(&folder, &["motion", "walk"], 1, &["0.amc: no skeleton (.asf) beside it"]);
}

#[test]
fn of_a_recording_the_partner_is_taken() {
    let folder = clips(4);
    let found =
        |role: &[&str]| check_json(&folder, &[&["motion", "clips", "--json"], role].concat(), 0);
    let giver = found(&["--role", "giver"]);
    assert_eq!(found(&[]), giver, "the robot gives, unless told otherwise");
    assert_ne!(found(&["--role", "receiver"])["folds"], giver["folds"]);
    assert_eq!(giver["unit"], "m");
    assert_eq!(giver["folds"][0]["sequences"][0]["frames"], FRAMES);
    let nobody = ["motion", "clips", "--role", "waiter"];
    check(&folder, &nobody, 1, &["nobody is called 'waiter'", "giver and receiver"]);
}

#[test]
fn of_two_kinds_the_rarer_is_left_out_by_name() {
    let folder = clips(2);
    fs::write(folder.path().join("clips/leg.asf"), SKELETON).unwrap();
    for number in 0..3 {
        fs::write(folder.path().join(format!("clips/walk {number}.amc")), steps(number)).unwrap();
    }
    let words = ["left out: 0", "left out: 1", "other channels than most", "3 sequences", "[rad]"];
    check(&folder, &["motion", "clips"], 3, &words);
}

#[test]
fn real_motions_are_as_well_made_up_by_both_kinds_of_neighbours() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/cmu/35");
    if !data.is_dir() {
        eprintln!("SKIPPED: no motions at {}", data.display());
        return;
    }
    let here = folder(&[]);
    let data = data.to_string_lossy();
    for dims in ["2", "3"] {
        let found = check_json(&here, &["motion", &data, "--dims", dims, "--json"], 0);
        for error in ["error_a", "error_f"] {
            let of = |column: &str| found[error][column].as_f64().unwrap();
            let (knn, both) = (of("knn"), of("k_delaunay"));
            assert!(both.is_finite() && both <= 1.05 * knn, "{dims}, {error}: {both} {knn}");
        }
    }
}

#[test]
fn a_recording_of_another_rate_is_named_and_left_out() {
    let folder = clips(4);
    // The first one's frames, three times as far apart.
    let text = fs::read_to_string(folder.path().join("clips/0.csv")).unwrap();
    let slower = |line: &str| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        if let Some(Ok(seconds)) = fields.get(1).map(|seconds| seconds.parse::<f64>()) {
            fields[1] = (3.0 * seconds).to_string();
        }
        fields.join(",") + "\n"
    };
    let slow: String = text.lines().map(slower).collect();
    fs::write(folder.path().join("clips/slow.csv"), slow).unwrap();
    let words = ["left out: slow: ", " Hz, where most have about ", "motion: 4 sequences"];
    check(&folder, &["motion", "clips"], 3, &words);
}

#[test]
fn a_skeleton_among_the_motions_is_none() {
    let folder = walk(3);
    let skeleton = fs::read_dir(folder.path().join("walk")).unwrap();
    let skeleton = skeleton.map(|entry| entry.unwrap().path());
    let skeleton = skeleton.filter(|path| path.extension().is_some_and(|ending| ending == "asf"));
    let skeleton = skeleton.last().unwrap().to_string_lossy().into_owned();
    check(&folder, &["motion", "walk", &skeleton], 0, &["motion: 3 sequences"]);
    check(&folder, &["motion", &skeleton], 1, &["read with the .amc beside it"]);
}
