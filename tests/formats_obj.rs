//! OBJ files: what is read and written, and what is wrong named with its line, all of it together.

#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "helpers of tests fail by panicking")]

use std::path::PathBuf;

use handover_mesh::Point;
use handover_mesh::formats::obj::{Difference, Obj};
use handover_mesh::formats::{Place, ReadError, Reason};
use handover_mesh::geometry::{Vector, is_finite};
use proptest::prelude::*;

/// A cube of 2 m around the origin, with whatever else a file may hold; every face looks outwards.
const CUBE: &str = "\
# a cube, drawn in C:\\shapes\\
mtllib cube.mtl
o cube
v -1 -1 -1
v 1 -1 -1 1.0
v 1 1 -1 0.5 0.25 1
v -1 1 -1\t# the last one below
v -1 -1 1
v 1 -1 1
v 1 1 1
v -1 1 1
vt 0 0
vt 1 0
vt 1 1
vn 0 0 -1
vn 0 0 1
vn 0 -1 0
vn 0.5 0.5 0.5
usemtl wood
s off
f 1//1 4//1 3//1 2//1
f 5//2 6//2 7//2 8//2
g sides
f 1/1/3 2/2/3 6/3/3 \\
  5/1/3
f 2/1 3/2 7/3 6/1
f -5/1 -1/2 -2/3 -6/1
f 1 5 8
f 1 8 4
l 1 2 3
";

fn read(text: &str) -> Obj {
    Obj::read(text.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
}

fn written(obj: &Obj, positions: &[Point]) -> String {
    String::from_utf8(obj.write(positions)).unwrap()
}

/// All that is wrong, a line each.
#[track_caller]
fn check_broken(text: &str, expected: &[&str]) {
    let error = Obj::read(text.as_bytes()).unwrap_err();
    assert_eq!(error.to_string().lines().collect::<Vec<_>>(), expected);
}

/// The cube's text with a line in place of another.
fn with(line: &str, other: &str) -> String {
    assert!(CUBE.contains(line), "{line}");
    CUBE.replacen(line, other, 1)
}

#[test]
fn a_shape_reads_with_polygons_as_fans() {
    let cube = read(CUBE);
    assert_eq!((cube.positions().len(), cube.face_count()), (8, 7));
    assert_eq!(cube.positions()[2], Point::new(1.0, 1.0, -1.0));
    let triangles = cube.triangles();
    assert_eq!(triangles.len(), 12);
    assert_eq!(triangles[..4], [[0, 3, 2], [0, 2, 1], [4, 5, 6], [4, 6, 7]]);
    assert_eq!(triangles[4..6], [[0, 1, 5], [0, 5, 4]], "a line that goes on");
    assert_eq!(triangles[8..10], [[3, 7, 6], [3, 6, 2]], "counted backwards");
    // Every face looks outwards.
    let at = |vertex: u32| cube.positions()[vertex as usize].coords;
    let volumes = triangles.iter().map(|t| at(t[0]).dot(&at(t[1]).cross(&at(t[2]))) / 6.0);
    assert_eq!(volumes.sum::<f64>(), 8.0);
}

#[test]
fn negative_indices_count_from_where_the_face_stands() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf -4 -3 -1\nf 1 2 4\n";
    assert_eq!(read(text).triangles(), [[0, 1, 2], [0, 1, 3], [0, 1, 3]]);
    let early = "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
    assert_eq!(read(early).triangles(), [[0, 1, 2]], "vertices that come later");
    let early = "f -1 -2 -3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let error = Obj::read(early.as_bytes()).unwrap_err();
    assert_eq!(error.violations().len(), 3, "{error}");
}

#[test]
fn all_but_places_and_used_normals_keeps_its_bytes() {
    let cube = read(CUBE);
    let same = written(&cube, cube.positions());
    assert_eq!(same, CUBE, "1 is written as it was, and the last normal is used by no face");
    let flatter = |p: &Point| Point::new(p.x, p.y, 0.1 * p.z);
    let text = written(&cube, &cube.positions().iter().map(flatter).collect::<Vec<_>>());
    let mut expected = CUBE.to_owned();
    for place in ["-1 -1", "1 -1", "1 1", "-1 1"] {
        for z in ["-1", "1"] {
            let short = z.replace('1', "0.1");
            expected = expected.replace(&format!("v {place} {z}"), &format!("v {place} {short}"));
        }
    }
    assert_eq!(text, expected, "the cube's normals stay");
    let strange = CUBE.replace('\n', "\r\n").replace("wood", "caf\u{e9}");
    let mut strange = [b"\xef\xbb\xbf", strange.as_bytes()].concat();
    let end = strange.len() - 3;
    strange[end] = b'\xff';
    let obj = Obj::read(&strange).unwrap();
    assert_eq!(obj.positions(), cube.positions());
    assert_eq!(obj.write(obj.positions()), strange);
}

#[test]
fn normals_are_means_weighed_by_area() {
    // Two walls of a corner, the second three times as long.
    let text = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 1 3 0\nv 1 3 1\nvn 9 9 9\nvn 1 2 3\n\
        f 1 2//1 3//1 4\nf 2//1 5//2 6//2 3//1\n";
    let wall = read(text);
    let found = written(&wall, wall.positions());
    let normal = |line: &str| -> Vec<f64> {
        line.strip_prefix("vn ").unwrap().split(' ').map(|n| n.parse().unwrap()).collect()
    };
    let normals: Vec<Vec<f64>> =
        found.lines().filter(|line| line.starts_with("vn")).map(normal).collect();
    let expected = [Vector::new(3.0, -1.0, 0.0).normalize(), Vector::x()];
    for (found, expected) in normals.iter().zip(expected) {
        let distance = (Vector::from_column_slice(found) - expected).norm();
        assert!(distance < 1e-15, "{found:?} instead of {expected}");
    }
    let flat = vec![Point::origin(); 6];
    assert!(written(&wall, &flat).contains("vn 9 9 9\nvn 1 2 3\n"), "no area, no normal");
    for size in [1e-300, 1e300] {
        let scaled: Vec<Point> = wall.positions().iter().map(|p| p * size).collect();
        let text = written(&wall, &scaled);
        assert!(text.contains("vn 1 0 0\n"), "{size}: {text}");
    }
}

#[test]
fn broken_obj_lines_are_named() {
    check_broken("", &["a vertex (v x y z) is missing", "a face (f 1 2 3) is missing"]);
    check_broken("# nothing\nv 1 2 3\n", &["a face (f 1 2 3) is missing"]);
    let there = "there are 8, counted from 1, or from -1 backwards";
    let text = with("v 1 -1 -1 1.0", "v 1 -1")
        .replace("v 1 1 1\n", "v 1,0 NaN inf\n")
        .replace("vt 1 1", "vt")
        .replace("vn 0 0 1", "vn 0 zero 1")
        .replace("5//2 6//2 7//2 8//2", "5//2 9//5 0//2 -9//2")
        .replace("2/1 3/2 7/3 6/1", "2/1 3/2 7/4 x 6/1/1/1 / 1e0")
        .replace("f 1 5 8", "f 5 8")
        .replace("f 1 8 4", "f 1 8 4 8 -4");
    check_broken(
        &text,
        &[
            "line 5: expected 3 fields, got 2",
            "line 10: field 'v.x': '1,0' is not a number",
            "line 10: field 'v.y': 'NaN' is not finite",
            "line 10: field 'v.z': 'inf' is not finite",
            "line 14: expected 1 fields, got 0",
            "line 16: field 'vn.y': 'zero' is not a number",
            &format!("line 22: no vertex 9: {there}"),
            &format!("line 22: no vertex 0: {there}"),
            &format!("line 22: no vertex -9: {there}"),
            "line 26: no texture coordinate 4: there are 3, counted from 1, or from -1 backwards",
            "line 26: 'x' is no corner of a face such as 1, 1/2, 1//3 or 1/2/3",
            "line 26: '6/1/1/1' is no corner of a face such as 1, 1/2, 1//3 or 1/2/3",
            "line 26: '/' is no corner of a face such as 1, 1/2, 1//3 or 1/2/3",
            "line 26: '1e0' is no corner of a face such as 1, 1/2, 1//3 or 1/2/3",
            "line 28: a face has three corners or more, got 2",
            "line 29: the face names vertex 8 twice",
        ],
    );
    let error = Obj::read(with("f 1 5 8", "f 5//7 8 4").as_bytes()).unwrap_err();
    let reason = Reason::NoSuchIndex { what: "normal", index: 7, there: 4 };
    assert_eq!(
        (&error.violations()[0].place, &error.violations()[0].reason),
        (&Place::Line(28), &reason)
    );
    let far = format!("f 1 2 {}\n", i64::MIN);
    assert!(Obj::read(with("f 1 5 8\n", &far).as_bytes()).is_err());
}

#[test]
fn violations_are_counted_and_only_some_kept() {
    let text = CUBE.to_owned() + &"f 1 2 9\n".repeat(50_000);
    let error = Obj::read(text.as_bytes()).unwrap_err();
    assert_eq!(error.violations().len(), ReadError::MOST);
    assert_eq!(error.more(), 50_000 - ReadError::MOST);
    let text = format!("{CUBE}f{}\n", " 9".repeat(50_000));
    assert_eq!(Obj::read(text.as_bytes()).unwrap_err().more(), 50_000 - ReadError::MOST);
}

#[test]
fn objs_cost_a_small_multiple_of_their_size() {
    let vertices = "v 0 0 0\n".repeat(20_000);
    let faces = "f 1 2 3\n".repeat(20_000);
    let round: String = (1..=20_000).map(|vertex| format!(" {vertex}")).collect();
    let joined = "f 1 2 3 \\\n".repeat(20_000);
    let corners = format!("{vertices}f{}\n", " 1".repeat(50_000));
    for text in [vertices.clone() + &faces, format!("{vertices}f{round}\n"), joined, corners] {
        let size = text.len() as u64;
        let used = allocation_counter::measure(|| drop(Obj::read(text.as_bytes())));
        assert!(used.bytes_max < 20 * size, "{} bytes for {size}", used.bytes_max);
    }
}

#[test]
fn what_differs_is_told() {
    let cube = read(CUBE);
    assert_eq!(cube.difference(&cube), None);
    let other = read(&CUBE.replace("v -1", "v -1.5").replace("/1/3", "").replace("//2", ""));
    assert_eq!(cube.difference(&other), None, "places, textures and normals may differ");
    let more = read(&with("v -1 1 1\n", "v -1 1 1\nv 0 0 0\n"));
    let vertices = Difference::Vertices { counts: [8, 9] };
    assert_eq!(cube.difference(&more), Some(vertices));
    assert_eq!(vertices.to_string(), "8 vertices and 9");
    let turned = read(&with("f 1 5 8", "f 8 1 5").replace("# a cube", "#\n# a cube"));
    let face = Difference::Face { number: 6, lines: [28, 29] };
    assert_eq!(cube.difference(&turned), Some(face));
    assert_eq!(face.to_string(), "face 6 has other vertices (lines 28 and 29)");
    let fewer = read(&with("f 1 8 4\n", ""));
    assert_eq!(fewer.difference(&cube), Some(Difference::Faces { counts: [6, 7] }));
}

/// Whatever reads can be written, and reads back as it was.
fn check_any(bytes: &[u8]) {
    let Ok(obj) = Obj::read(bytes) else { return };
    assert!(obj.positions().iter().all(is_finite));
    let count = obj.positions().len() as u32;
    assert!(obj.triangles().iter().flatten().all(|vertex| *vertex < count));
    let written = obj.write(obj.positions());
    let again = Obj::read(&written).unwrap();
    assert_eq!((again.positions(), again.triangles()), (obj.positions(), obj.triangles()));
    assert_eq!(again.difference(&obj), None);
}

/// Bytes that such files are made of, and some that they are not.
fn letter() -> impl Strategy<Value = u8> {
    prop_oneof![4 => prop::sample::select(&b"0123 -.e/\n\\\r#vtnf"[..]), 1 => any::<u8>()]
}

fn piece() -> impl Strategy<Value = String> {
    let lines: Vec<String> = CUBE.lines().map(|line| line.to_owned() + "\n").collect();
    prop_oneof![
        prop::sample::select(lines),
        "(v|vn|vt|f|\\\\|-?[0-9]{1,20}|[1-9](/[1-9]?){0,3}| )*\n?"
    ]
}

proptest! {
    #[test]
    fn any_obj_bytes_never_panic(bytes in prop::collection::vec(letter(), 0..300)) {
        check_any(&bytes);
        check_any(&[CUBE.as_bytes(), &bytes].concat());
    }

    #[test]
    fn obj_lines_in_any_order_never_panic(pieces in prop::collection::vec(piece(), 0..60)) {
        check_any(pieces.concat().as_bytes());
        check_any((CUBE.to_owned() + &pieces.concat()).as_bytes());
    }

    #[test]
    fn flipped_obj_bytes_never_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), letter()), 0..6),
    ) {
        let mut bytes = CUBE.as_bytes().to_vec();
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        check_any(&bytes);
    }

    #[test]
    fn any_places_of_an_obj_read_back_to_the_bit(
        numbers in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO, 24),
    ) {
        let places: Vec<Point> = numbers.chunks(3).map(|n| Point::new(n[0], n[1], n[2])).collect();
        let found = Obj::read(&read(CUBE).write(&places)).unwrap();
        let bits = |points: &[Point]| -> Vec<u64> {
            points.iter().flat_map(|p| [p.x, p.y, p.z]).map(f64::to_bits).collect()
        };
        prop_assert_eq!(bits(found.positions()), bits(&places));
    }
}

/// The development meshes, which are no part of this package.
fn lions() -> Option<PathBuf> {
    let shared = std::env::var_os("HANDOVER_DATA").map(PathBuf::from);
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = shared.unwrap_or_else(beside).join("meshes");
    if !folder.is_dir() {
        eprintln!("SKIPPED: no meshes at {}", folder.display());
        return None;
    }
    Some(folder)
}

#[test]
fn real_lions_read_and_are_poses_of_one_shape() {
    let Some(folder) = lions() else { return };
    let lion = |name: &str| Obj::read(&std::fs::read(folder.join(name)).unwrap()).unwrap();
    let [reference, posed] = ["lion-reference.obj", "lion-04.obj"].map(lion);
    assert_eq!((reference.positions().len(), reference.face_count()), (5000, 9996));
    assert_eq!(reference.difference(&posed), None);
    let larger = ["lion26k-reference.obj", "lion26k-04.obj"].map(lion);
    assert_eq!((larger[0].positions().len(), larger[0].triangles().len()), (13_002, 26_000));
    assert_eq!(larger[0].difference(&larger[1]), None);
    let counts = [5000, 13_002];
    assert_eq!(reference.difference(&larger[0]), Some(Difference::Vertices { counts }));
    // The normals of the file are those that are made anew, but for its rounding.
    let normals = |bytes: &[u8]| -> Vec<Vector> {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let lines = text.lines().filter_map(|line| line.strip_prefix("vn "));
        let numbers = lines.map(|line| line.split_ascii_whitespace().map(|n| n.parse().unwrap()));
        numbers.map(Vector::from_iterator).collect()
    };
    let given = normals(&std::fs::read(folder.join("lion-04.obj")).unwrap());
    let made = normals(&posed.write(posed.positions()));
    let mut dots: Vec<f64> = given.iter().zip(&made).map(|(a, b)| a.normalize().dot(b)).collect();
    dots.sort_by(f64::total_cmp);

    assert!(dots[500] > 0.9, "{}", dots[500]);
}
