//! `handover blend` as a user meets it: the real process, its exit code, its words and its files.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

#[path = "common/clips.rs"]
#[allow(dead_code, reason = "clips are for other tests")]
mod clips;
mod common;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use clips::keys;
use common::{check, check_json, folder};
use handover_mesh::Point;
use handover_mesh::formats::obj::Obj;
use proptest::prelude::*;
use serde_json::{Value, json};
use tempfile::TempDir;

const RINGS: u32 = 9;
const SIDES: u32 = 6;

/// An arm of rings along x, 2 m long and closed by a polygon at either end, with groups, materials
/// and normals.
fn arm(place: impl Fn(Point) -> Point) -> String {
    let mut text = "# an arm\nmtllib skin.mtl\no arm\n".to_owned();
    let ring = |ring: u32| (0..SIDES).map(move |side| 1 + ring * SIDES + side);
    for x in 0..RINGS {
        for side in 0..SIDES {
            let turn = std::f64::consts::TAU * f64::from(side) / f64::from(SIDES);
            let [y, z] = [0.2 * turn.cos(), 0.2 * turn.sin()];
            let Point { coords, .. } = place(Point::new(0.25 * f64::from(x), y, z));
            let _ = writeln!(text, "v {} {} {}", coords.x, coords.y, coords.z);
        }
    }
    text += "vt 0.5 0.5\nvn 0 0 1\nvn 0 1 0\nusemtl skin\ng sides\n";
    for x in 1..RINGS {
        for side in 0..SIDES {
            let next = (side + 1) % SIDES;
            let at = |x: u32, side: u32| 1 + x * SIDES + side;
            let [a, b, c, d] = [at(x - 1, side), at(x, side), at(x, next), at(x - 1, next)];
            let _ = writeln!(text, "f {a} {c} {b}\nf {a} {d} {c}");
        }
    }
    let end: Vec<String> = ring(RINGS - 1).map(|v| format!("{v}/1/1")).collect();
    let start: Vec<String> = ring(0).map(|v| format!("{v}//2")).collect();
    let start: Vec<String> = start.into_iter().rev().collect();
    let _ = write!(text, "g ends\nf {}\nf {}\n", end.join(" "), start.join(" "));
    text
}

/// Bent to a quarter of a circle, upwards.
fn bent(point: Point) -> Point {
    let (sine, cosine) = (point.x * std::f64::consts::FRAC_PI_4).sin_cos();
    let radius = 4.0 / std::f64::consts::PI - point.y;
    Point::new(radius * sine, 4.0 / std::f64::consts::PI - radius * cosine, point.z)
}

/// Longer, thinner and elsewhere.
fn long(point: Point) -> Point {
    Point::new(1.5 * point.x + 3.0, 0.7 * point.y - 1.0, 0.8 * point.z)
}

/// `ref.obj`, `bent.obj` and `long.obj`.
fn arms() -> TempDir {
    let [straight, bent, long] = [arm(|p| p), arm(bent), arm(long)];
    folder(&[("ref.obj", &straight), ("bent.obj", &bent), ("long.obj", &long)])
}

fn read(folder: &TempDir, file: &str) -> Obj {
    Obj::read(&fs::read(folder.path().join(file)).unwrap()).unwrap()
}

/// The files of a folder, sorted.
fn files(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<String> = names.map(|name| name.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// How far the farthest vertex of two shapes is from where it should be `[m]`.
fn distance(one: &Obj, other: &Obj) -> f64 {
    assert_eq!(one.difference(other), None);
    let pairs = one.positions().iter().zip(other.positions());
    pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

const POSES: [&str; 4] = ["blend", "ref.obj", "bent.obj", "long.obj"];

/// The command with what follows the shapes, separated by blanks.
fn command(rest: &str) -> Vec<&str> {
    POSES.into_iter().chain(rest.split(' ')).collect()
}

#[test]
fn whole_weights_are_the_shapes_themselves() {
    for settings in ["", " --tetrisation face", " --tetrisation edge --rotation p"] {
        let folder = arms();
        let shapes = ["ref.obj", "bent.obj", "long.obj"];
        let rest = format!("-w 0,0 -w 1,0 -w 0,1 -o x.obj{settings}");
        check(&folder, &command(&rest), 0, &["2 poses of ref.obj", "tetrahedra over each"]);
        for (at, shape) in shapes.into_iter().enumerate() {
            let found = read(&folder, &format!("x_00{at}.obj"));
            let distance = distance(&found, &read(&folder, shape));
            assert!(distance < 1e-6, "{shape}{settings}: {distance} m");
        }
    }
}

#[test]
fn all_but_places_and_normals_is_the_references() {
    let folder = arms();
    check(&folder, &command("-w 0.5,0 -o half.obj"), 0, &["half.obj  weights 0.5,0"]);
    let rest = |file: &str| -> Vec<String> {
        let text = fs::read_to_string(folder.path().join(file)).unwrap();
        let lines = text.lines().filter(|line| !line.starts_with("v ") && !line.starts_with("vn"));
        lines.map(str::to_owned).collect()
    };
    assert_eq!(rest("half.obj"), rest("ref.obj"));
    assert!(rest("half.obj").contains(&"mtllib skin.mtl".to_owned()));
    // Half of a bend is a bend by half, as long as the arm: a plain mean of places is shorter.
    let half = read(&folder, "half.obj");
    let middle = |ring: usize| {
        let ring = &half.positions()[6 * ring..6 * ring + 6];
        ring.iter().fold(Point::origin(), |sum, point| sum + point.coords / 6.0)
    };
    let length: f64 = (1..9).map(|ring| (middle(ring) - middle(ring - 1)).norm()).sum();
    assert!((length - 2.0).abs() < 0.02, "{length} m long");
    let text = fs::read_to_string(folder.path().join("half.obj")).unwrap();
    let normal = text.lines().find(|line| line.starts_with("vn")).unwrap();
    let normal: Vec<f64> = normal[3..].split(' ').map(|number| number.parse().unwrap()).collect();
    // The normal of the far end.
    let turn = normal[1].atan2(normal[0]).to_degrees();
    assert!((turn - 45.0).abs() < 2.0 && normal[2].abs() < 0.01, "{normal:?}");
}

#[test]
fn the_json_says_what_was_made() {
    let folder = arms();
    let found = check_json(&folder, &command("-w -0.5,1.5 -o far.obj --json"), 0);
    let expected = [
        "init_ms",
        "solve_ms",
        "iterations",
        "flipped",
        "replaced",
        "free",
        "tetrahedra",
        "vertices",
        "triangles",
        "tetrisation",
        "energy",
        "rotation",
        "most_iterations",
        "tolerance",
        "at_rest",
        "shapes",
    ];
    assert_eq!(keys(&found), expected);
    assert!(
        found["init_ms"].as_f64().unwrap() >= 0.0 && found["solve_ms"].as_f64().unwrap() >= 0.0
    );
    let triangles = (RINGS - 1) * SIDES * 2 + 2 * (SIDES - 2);
    let counts = [&found["vertices"], &found["triangles"], &found["free"]];
    assert_eq!(counts, [&json!(RINGS * SIDES), &json!(triangles), &json!(0)]);
    let names = [&found["tetrisation"], &found["energy"], &found["rotation"]];
    assert_eq!(names, ["vertex", "t", "c"]);
    assert_eq!((&found["tolerance"], &found["most_iterations"]), (&Value::Null, &Value::Null));
    let shape = &found["shapes"][0];
    assert_eq!(keys(shape), ["file", "weights", "iterations", "energy", "change", "settled"]);
    assert_eq!((&shape["file"], &shape["weights"]), (&json!("far.obj"), &json!([-0.5, 1.5])));
    assert!(shape["energy"].as_f64().unwrap() >= 0.0);

    let rest = "-w 0.3,0.3 -w 1,1 --energy s --iterations 3 --tolerance 0 -o s.obj --json";
    let found = check_json(&folder, &command(rest), 0);
    assert_eq!((&found["iterations"], &found["shapes"][1]["iterations"]), (&json!(3), &json!(3)));
    assert_eq!((&found["at_rest"], &found["shapes"][1]["settled"]), (&json!(0.0), &json!(false)));
    assert_eq!((&found["tolerance"], &found["most_iterations"]), (&json!(0.0), &json!(3)));
    assert_eq!(found["shapes"][1]["file"], "s_001.obj");
}

/// Names in backquotes in the first column of the tables below a heading.
fn documented(heading: &str) -> Vec<String> {
    let document = include_str!("../docs/blend.md");
    let section = document.split("\n## ").find(|section| section.starts_with(heading)).unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    let first = rows.map(|row| row.split('|').nth(1).unwrap());
    first.flat_map(|cell| cell.split('`').skip(1).step_by(2)).map(str::to_owned).collect()
}

#[test]
fn what_is_documented_is_what_there_is() {
    let folder = arms();
    let found = check_json(&folder, &command("-w 0,0 -o x.obj --json"), 0);
    assert_eq!(documented("JSON"), keys(&found));
    let help = check(&folder, &["blend", "--help"], 0, &[]).stdout;
    let help: String = String::from_utf8(help).unwrap().split_whitespace().collect();
    let options = documented("Options");
    assert_eq!(options.len(), 9);
    for option in options.iter().filter(|option| option.starts_with("--")) {
        let (name, default) = option.split_once(' ').unwrap();
        let (_, said) = help.split_once(&format!("{name}<")).unwrap();
        let default = if default == "N" { String::new() } else { format!("[default:{default}]") };
        let next = said.find("--").unwrap_or(said.len());
        assert!(said[..next].contains(&default), "{option}: {said}");
    }
}

#[test]
fn what_did_not_converge_is_noted_and_no_loss() {
    let folder = arms();
    let rest = "-w 0.3,0.3 -w 1,1 --energy s --iterations 1 --tolerance 1e-12 -o s.obj";
    let words = [
        "note: 2 of 2 shapes took all of 1 iteration without coming to rest",
        "(hint: --iterations)",
    ];
    check(&folder, &command(rest), 0, &words);
    let quiet = check(&folder, &command(&format!("{rest} --quiet")), 0, &[]);
    assert!(quiet.stderr.is_empty());
    let done = check(&folder, &command("-w 0.3,0.3 -o t.obj"), 0, &["energy t, rotation c"]);
    assert!(done.stderr.is_empty(), "{}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn several_shapes_are_numbered() {
    let folder = arms();
    let made = |folder: &TempDir| -> Vec<String> {
        let poses = ["ref.obj", "bent.obj", "long.obj"];
        files(folder.path()).into_iter().filter(|name| !poses.contains(&name.as_str())).collect()
    };
    let found = check_json(&folder, &command("-w 1,0 -w -1,2 --frames 7 --json -o way.OBJ"), 0);
    let weights: Vec<&Value> =
        found["shapes"].as_array().unwrap().iter().map(|shape| &shape["weights"]).collect();
    let third = 1.0 / 3.0;
    let near = |found: &Value, expected: [f64; 2]| {
        let found: Vec<f64> =
            found.as_array().unwrap().iter().map(|w| w.as_f64().unwrap()).collect();
        assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-12), "{found:?}");
    };
    let way = [
        [0.0, 0.0],
        [third, 0.0],
        [2.0 * third, 0.0],
        [1.0, 0.0],
        [third, 2.0 * third],
        [-third, 4.0 * third],
        [-1.0, 2.0],
    ];
    assert_eq!(weights.len(), 7);
    weights.into_iter().zip(way).for_each(|(found, expected)| near(found, expected));
    assert_eq!(
        [&found["shapes"][3]["weights"], &found["shapes"][6]["weights"]],
        [&json!([1.0, 0.0]), &json!([-1.0, 2.0])]
    );
    let names: Vec<String> = (0..7).map(|number| format!("way_00{number}.OBJ")).collect();
    assert_eq!(made(&folder), names);

    let folder = arms();
    check(&folder, &command("-w 0,0.25 --frames 2 -o two.obj"), 0, &["median of 2"]);
    assert_eq!(made(&folder), ["two_000.obj", "two_001.obj"]);
    let folder = arms();
    check(&folder, &command("-w 0,0.25 -o one.obj"), 0, &[]);
    assert_eq!(made(&folder), ["one.obj"]);
}

#[test]
fn what_cannot_be_meant_is_wrong_usage() {
    let folder = arms();
    let before = files(folder.path());
    let original = fs::read(folder.path().join("bent.obj")).unwrap();
    for (rest, words) in [
        ("-w 1 -o x.obj", &["-w 1: 1 weight for 2 poses"][..]),
        ("-w 1,2,-3 -o x.obj", &["-w 1,2,-3: 3 weights for 2 poses"]),
        ("-w 0,0 -w 1 -o x.obj", &["-w 1: 1 weight"]),
        ("-w 1, -o x.obj", &["'' is no finite number"]),
        ("-w NaN,0 -o x.obj", &["'NaN' is no finite number"]),
        ("-w 1,inf -o x.obj", &["'inf' is no finite number"]),
        ("-w -o x.obj", &["no finite number"]),
        ("-o x.obj", &["--weights"]),
        ("-w 1,0", &["--out"]),
        ("-w 1,0 -o x.stl", &["x.stl: what is written here ends in .obj"]),
        ("-w 1,0 -o nowhere/x.obj", &["no folder nowhere"]),
        ("-w 1,0 -o bent.obj", &["bent.obj is an input and would be overwritten"]),
        ("-w 1,0 -o ./ref.obj", &["is an input and would be overwritten"]),
        ("-w 1,0 --frames 1 -o x.obj", &["--frames"]),
        ("-w 1,0 -w 0,1 --frames 2 -o x.obj", &["--frames 2", "2 -w", "3 frames"]),
        ("-w 1,0 --energy x -o x.obj", &["s_printed"]),
        ("-w 1,0 --iterations 9 -o x.obj", &["--iterations: the energy t is solved at once"]),
        ("-w 1,0 --energy t --tolerance 1 -o x.obj", &["--tolerance: the energy t"]),
        ("-w 1,0 --energy s --tolerance -1 -o x.obj", &["--tolerance"]),
        ("-w 1,0 --energy s --iterations 0 -o x.obj", &["--iterations"]),
    ] {
        check(&folder, &command(rest), 2, words);
    }
    check(&folder, &["blend", "ref.obj", "-w", "1", "-o", "x.obj"], 2, &["POSE"]);
    assert_eq!(files(folder.path()), before, "nothing was written");
    assert_eq!(fs::read(folder.path().join("bent.obj")).unwrap(), original);
    // A numbered file that is an input is one too.
    fs::rename(folder.path().join("bent.obj"), folder.path().join("x_001.obj")).unwrap();
    let poses = ["blend", "ref.obj", "x_001.obj", "-w", "1", "-w", "2", "-o", "x.obj"];
    check(&folder, &poses, 2, &["x_001.obj is an input"]);
}

#[test]
fn broken_shapes_are_named_with_file_and_line() {
    let folder = arms();
    let write = |file: &str, text: &str| fs::write(folder.path().join(file), text).unwrap();
    let before = files(folder.path());
    write("bent.obj", &arm(bent).replacen("f 1 8 7", "f 1 8 99", 1));
    write("long.obj", "v 1 2\nf 1 2 3\n");
    let words = [
        "bent.obj: line 63: no vertex 99: there are 54",
        "long.obj: line 1: expected 3 fields, got 2",
        "long.obj: line 2: no vertex 2",
    ];
    check(&folder, &command("-w 1,0 -o x.obj"), 1, &words);
    fs::remove_file(folder.path().join("long.obj")).unwrap();
    check(&folder, &command("-w 1,0 -o x.obj"), 1, &["long.obj: cannot be read"]);
    write("bent.obj", &arm(bent));
    write("long.obj", &arm(long).replacen("f 1 8 7", "f 1 7 8", 1));
    let words = [
        "ref.obj and long.obj are not the same shape: face 1 has other vertices (lines 63 and 63)",
    ];
    check(&folder, &command("-w 1,0 -o x.obj"), 1, &words);
    write("long.obj", &(arm(long) + "v 0 0 0\n"));
    check(&folder, &command("-w 1,0 -o x.obj"), 1, &["ref.obj and long.obj", "54 vertices and 55"]);
    assert_eq!(files(folder.path()), before, "nothing was written");
}

#[test]
fn weights_beyond_reason_write_nothing() {
    let folder = arms();
    let before = files(folder.path());
    check(&folder, &command("-w 1e308,-1e308 -o x.obj"), 1, &["-w 1", "not finite"]);
    assert_eq!(files(folder.path()), before);
}

/// Shapes that are no whole surface: what can be blended is, what cannot is refused by name.
#[test]
fn strange_shapes_blend_or_are_refused() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 5 5\n";
    let other = "v 0 0 0\nv 2 0 0\nv 0 1 0.5\nv 0 0 1\nv 6 5 5\n";
    let blend = |faces: &str, over: &str, refused: Option<&str>, noted: &str| {
        let [one, two] = [vertices, other].map(|vertices| vertices.to_owned() + faces);
        let folder = folder(&[("a.obj", &one), ("b.obj", &two)]);
        let rest = ["-w", "0", "-w", "1", "-w", "0.5", "-o", "x.obj", "--tetrisation", over];
        let arguments: Vec<&str> = ["blend", "a.obj", "b.obj"].into_iter().chain(rest).collect();
        if let Some(place) = refused {
            let hint = "--tetrisation face takes any triangles";
            check(&folder, &arguments, 1, &["cannot blend a.obj", "no surface", place, hint]);
            assert_eq!(files(folder.path()), ["a.obj", "b.obj"]);
            return;
        }
        check(&folder, &arguments, 0, &[noted]);
        for (at, shape) in ["a.obj", "b.obj"].into_iter().enumerate() {
            let found = read(&folder, &format!("x_00{at}.obj"));
            let distance = distance(&found, &read(&folder, shape));
            assert!(distance < 1e-6, "{faces}{over}: {distance} m");
        }
    };
    for (faces, over_edges, over_vertices) in [
        ("f 1 2 3\nf 1 2 4\n", Some("at edge 1-2"), Some("at edge 1-2")),
        ("f 1 2 3\nf 2 1 4\nf 1 2 5\n", Some("at edge 1-2"), Some("at edge 1-2")),
        ("f 1 2 3\nf 1 2 3\n", Some("at edge 1-2, 1-3, 2-3"), Some("at edge 1-2, 1-3, 2-3")),
        ("f 1 2 3\nf 1 4 5\n", None, Some("one fan at vertex 1")),
    ] {
        blend(faces, "face", None, "");
        blend(faces, "edge", over_edges, "2 triangles took the tetrahedron over the face");
        blend(faces, "vertex", over_vertices, "");
    }
    let free = "2 vertices are in no tetrahedron: the weighted mean of the shapes";
    for over in ["edge", "vertex"] {
        let lone = "1 triangle took the tetrahedron over the face";
        blend("f 1 2 3\n", over, None, lone);
        blend("f 1 2 3\n", over, None, free);
        // Folded onto itself: normals cancel out.
        let folded = "2 triangles took the tetrahedron over the face";
        blend("f 1 2 3\nf 1 3 2\n", over, None, folded);
    }
    let point = "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n";
    let folder = folder(&[("a.obj", point), ("b.obj", point)]);
    let words = ["cannot blend a.obj: no tetrahedron has a volume"];
    check(&folder, &["blend", "a.obj", "b.obj", "-w", "0.5", "-o", "x.obj"], 1, &words);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn any_obj_never_panics_the_command(
        lines in prop::collection::vec("(v|f)( -?[0-9]{1,2}(\\.[0-9])?(e[0-9]{1,3})?){3}\n", 0..40),
        weight in prop::num::f64::ANY,
    ) {
        let start = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let text = start.to_owned() + &lines.concat();
        let moved = text.replace("v 1", "v 3");
        let folder = folder(&[("a.obj", &text), ("b.obj", &moved)]);
        let weight = weight.to_string();
        let arguments = ["blend", "a.obj", "b.obj", "-w", &weight, "-o", "x.obj"];
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_handover"));
        let done = command.args(arguments).current_dir(folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        prop_assert!(matches!(done.status.code(), Some(0..=2)), "{said}");
        prop_assert!(!said.contains("panicked"), "{said}");
        prop_assert_eq!(folder.path().join("x.obj").exists(), done.status.success());
    }
}
