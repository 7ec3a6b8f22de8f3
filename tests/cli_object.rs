//! `handover import --object-mesh` and what is done with its points, as a user meets them: the real
//! process, its files, its exit code and its words.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

#[expect(dead_code, reason = "what the figures are called is for other tests")]
#[path = "common/clips.rs"]
mod clips;
mod common;
#[path = "common/object.rs"]
mod object;

use std::fs;

use common::{check, check_json};
use handover_mesh::formats::{self, UpAxis};
use handover_mesh::{Recording, Vector};
use object::clips_with_object;
use serde_json::Value;
use tempfile::TempDir;

/// `import clips out` with a cube of ten centimetres.
const IMPORT: [&str; 7] =
    ["import", "clips", "out", "--object-mesh", "cube.obj", "--object-scale", "0.01"];
const ATTACH: [&str; 2] = ["--set", "object.attach=true"];

/// A cube of ten units far from its own origin, and a vertex of no face.
fn cube() -> String {
    let corner = |k: u32| [k & 1, k >> 1 & 1, k >> 2].map(|bit| 500 + 10 * bit);
    let corners: String = (0..8).map(corner).map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    format!(
        "{corners}v -900 0 0\nf 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
    )
}

/// `clips` with an object but for the first `without`, and `cube.obj`.
fn scene(count: u32, without: u32) -> TempDir {
    let folder = clips_with_object(count, without);
    fs::write(folder.path().join("cube.obj"), cube()).unwrap();
    folder
}

fn with<'a>(arguments: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [arguments, more].concat()
}

fn read(folder: &TempDir, path: &str) -> Recording {
    formats::read(&fs::read(folder.path().join(path)).unwrap(), "clip", UpAxis::Z).unwrap()
}

/// The names of the points that an imported recording's object has, and where each is from the
/// place that the object had, which stays their mean, in every frame.
fn points_around(before: &Recording, after: &Recording) -> (Vec<String>, Vec<Vector>) {
    assert_eq!(before.people(), after.people());
    assert_eq!(before.metadata(), after.metadata());
    let cup = &before.object().unwrap().points[0];
    let points = &after.object().unwrap().points;
    let around = |stamp| {
        let cup = cup.place(stamp).unwrap();
        points.iter().map(|p| p.place(stamp).unwrap() - cup).collect::<Vec<Vector>>()
    };
    let first = around(before.stamps().next().unwrap());
    for stamp in before.stamps() {
        let now = around(stamp);
        assert!(now.iter().sum::<Vector>().norm() < 1e-12, "{now:?}");
        assert!(now.iter().zip(&first).all(|(a, b)| (a - b).norm() < 1e-12), "not turned");
    }
    (points.iter().map(|point| point.name.clone()).collect(), first)
}

#[test]
fn a_mesh_becomes_points_around_the_objects_place() {
    let folder = scene(2, 0);
    let note = "note: cube.obj is 0.100 x 0.100 x 0.100 m; 8 points of it";
    check(&folder, &IMPORT, 0, &["out/0.csv", "out/1.csv", note]);
    let (names, corners) =
        points_around(&read(&folder, "clips/1.csv"), &read(&folder, "out/1.csv"));
    assert_eq!(names, ["p00", "p01", "p02", "p03", "p04", "p05", "p06", "p07"]);
    for (k, corner) in corners.iter().enumerate() {
        let side = |axis: usize| if k >> axis & 1 == 1 { 0.05 } else { -0.05 };
        assert!((corner - Vector::new(side(0), side(1), side(2))).norm() < 1e-12, "{corners:?}");
    }
    // As many as may be, and those that lie far apart.
    let two = ["import", "clips/1.csv", "two.csv", "--object-mesh", "cube.obj"];
    let two = with(&two, &["--object-scale", "0.01", "--set", "object.points=2"]);
    check(&folder, &two, 0, &["2 points of it"]);
    let (names, ends) = points_around(&read(&folder, "clips/1.csv"), &read(&folder, "two.csv"));
    assert_eq!(names, ["p00", "p01"]);
    assert!(((ends[0] - ends[1]).norm() - 0.1 * 3.0_f64.sqrt()).abs() < 1e-12);
}

#[test]
fn its_points_ride_on_the_carriers_hand_in_all_that_follows() {
    let folder = scene(4, 0);
    check(&folder, &with(&IMPORT, &["--quiet"]), 0, &[]);
    let learn = ["learn", "out", "-o", "m.safetensors", "--set", "learn.references=1"];
    let few = ["--set", "learn.steps=2", "--set", "learn.tolerance=0", "--json"];
    let found = check_json(&folder, &[&learn[..], &few, &ATTACH].concat(), 0);
    // Nine joints and the cube's eight corners in the giver's hand, nine joints of the receiver.
    assert_eq!(found["candidates"], 17 * 9);
    check(&folder, &["check", "m.safetensors"], 0, &["object.attach"]);
    let replayed = check_json(&folder, &["replay", "m.safetensors", "out/3.csv", "--json"], 0);
    assert!(replayed["gap_cm"].is_number(), "{replayed}");
    let evaluate = ["evaluate", "--protocol", "leave_one_out", "--methods", "hold,mesh", "--json"];
    let measured = |clips: &str, more: &[&str]| -> Value {
        check_json(&folder, &[&evaluate[..], &[clips], more].concat(), 0)["summary"].take()
    };
    let (on, off) = (measured("out", &ATTACH), measured("out", &[]));
    assert_eq!(off, measured("clips", &[]), "nobody looks at it unless asked to");
    assert_eq!(on["hold"], off["hold"]);
    assert_ne!(on["mesh"], measured("clips", &ATTACH)["mesh"], "eight points are not one");
    // More than are taken: what to do about it.
    let fewer = ["evaluate", "--protocol", "leave_one_out", "out", "--set", "object.points=7"];
    let hint = "left out: out/0.csv: object.attach: the object has 8 points, at most 7 are taken \
                (hint: object.points=8 takes all of them)";
    check(&folder, &with(&fewer, &ATTACH), 1, &[hint, "no recording is left"]);
}

#[test]
fn what_no_mesh_goes_around_is_named_and_left_out() {
    let folder = scene(3, 1);
    let nothing = "clips/0.csv: --object-mesh: no object was tracked";
    check(&folder, &IMPORT, 3, &[nothing, "out/1.csv", "out/2.csv", "2 written, 1 left out"]);
    let found = check_json(&folder, &with(&IMPORT, &["--json"]), 3);
    assert_eq!(found["written"].as_array().unwrap().len(), 2);
    assert_eq!(found["failed"][0]["file"], "clips/0.csv");
    let one = |source, out| ["import", source, out, "--object-mesh", "cube.obj"];
    let scale = ["--object-scale", "0.01"];
    check(&folder, &with(&one("clips/0.csv", "x.csv"), &scale), 1, &[nothing]);
    let several =
        "out/1.csv: --object-mesh: the object has 8 points already, a mesh goes around one";
    check(&folder, &with(&one("out/1.csv", "x.csv"), &scale), 1, &[several]);
    for bag in ["x.mcap", "x.bag", "x/"] {
        let words = [&format!("{bag}: a bag holds one point of an object")[..], "ending in .csv"];
        check(&folder, &with(&one("clips/1.csv", bag), &scale), 2, &words);
    }
    // Ten metres, as nobody said that the file is in centimetres.
    let large = "cube.obj is 10.000 x 10.000 x 10.000 m, more than the 3 m";
    check(&folder, &one("clips/1.csv", "x.csv"), 1, &[large, "--object-scale 0.001"]);
    assert!(!["x.csv", "x.mcap", "x.bag", "x"].iter().any(|x| folder.path().join(x).exists()));
}

#[test]
fn wrong_meshes_and_scales_are_named() {
    let folder = scene(1, 0);
    fs::write(folder.path().join("bad.obj"), "v 0 0 0\nv 1 0 zero\nf 1 2 3\n").unwrap();
    fs::write(folder.path().join("far.obj"), "v 0 0 -1e308\nv 1 0 0\nv 0 1 1e308\nf 1 2 3\n")
        .unwrap();
    let import = |mesh| ["import", "clips", "out", "--object-mesh", mesh];
    let words = ["bad.obj: line 2: field 'v.z': 'zero'", "bad.obj: line 3: "];
    check(&folder, &import("bad.obj"), 1, &words);
    check(&folder, &import("nowhere.obj"), 1, &["nowhere.obj: "]);
    check(&folder, &import("far.obj"), 1, &["far.obj is ", "--object-scale"]);
    assert!(!folder.path().join("out").exists());
    for scale in ["0", "-1", "NaN", "inf", "wide"] {
        let scale = ["--object-scale", scale];
        check(&folder, &with(&import("cube.obj"), &scale), 2, &["no finite number above 0"]);
    }
    check(&folder, &["import", "clips", "out", "--object-scale", "1"], 2, &["--object-mesh"]);
    // What lies as far apart as numbers go, at a scale that brings it into a hand.
    let tiny = ["--object-scale", "1e-309"];
    check(&folder, &with(&import("far.obj"), &tiny), 1, &["far.obj is "]);
}
