//! SBU text: what comes out is metres, z up, and what is wrong is named with its line.

#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "helpers of tests fail by panicking")]

use handover_mesh::formats::{self, ReadError, UpAxis};
use handover_mesh::{Part, Point, Recording, Role, Side, Stamp};
use proptest::prelude::*;

/// Places `[m]` of a standing person, facing along `facing` (±1) in x, as a line's fields.
fn person(x: f64, facing: f64) -> Vec<String> {
    // Facing +x the left is +y; in the order of the fifteen joints.
    let body: [[f64; 3]; 15] = [
        [0.0, 0.0, 1.7],
        [0.0, 0.0, 1.5],
        [0.0, 0.0, 1.2],
        [0.0, 0.2, 1.45],
        [0.0, 0.25, 1.2],
        [0.2, 0.25, 1.1],
        [0.0, -0.2, 1.45],
        [0.0, -0.25, 1.2],
        [0.4, -0.2, 1.1],
        [0.0, 0.1, 0.9],
        [0.0, 0.1, 0.5],
        [0.0, 0.1, 0.1],
        [0.0, -0.1, 0.9],
        [0.0, -0.1, 0.5],
        [0.0, -0.1, 0.1],
    ];
    let metres = body.map(|[forward, left, up]| [x + facing * forward, facing * left - 2.5, up]);
    let image = metres
        .map(|[x, y, z]| [(1.28 - x) / 2.56, (0.96 - z) / 1.92, y / -1.28].map(|v| v.to_string()));
    image.concat()
}

fn line(frame: u64) -> String {
    let fields = [vec![frame.to_string()], person(-0.5, 1.0), person(0.5, -1.0)].concat();
    fields.join(",")
}

fn small() -> String {
    [180, 181, 183].map(|frame| line(frame) + "\r\n").concat()
}

fn read(text: &str) -> Result<Recording, ReadError> {
    formats::read(text.as_bytes(), "clip", UpAxis::Z)
}

/// Whether the right shoulder is on the right of whoever looks at the partner, in most frames.
#[track_caller]
fn check_right_shoulders(recording: &Recording) {
    for role in [Role::First, Role::Second] {
        let (own, partner) = (recording.person(role), recording.person(role.partner()));
        let skeleton = own.motion.skeleton();
        let at = |motion: &handover_mesh::Sequence, frame, part| -> Point {
            motion.position(frame, skeleton.part(part).unwrap())
        };
        let is_right = |frame: &usize| {
            let torso = |motion| at(motion, *frame, Part::Torso);
            let forward = torso(&partner.motion) - torso(&own.motion);
            let right = forward.cross(&handover_mesh::Vector::z());
            let shoulder = |side| at(&own.motion, *frame, Part::Shoulder(side));
            (shoulder(Side::Right) - shoulder(Side::Left)).dot(&right) > 0.0
        };
        let count = (0..recording.len()).filter(is_right).count();
        assert!(2 * count > recording.len(), "{}, {}: {count}", recording.name(), own.name);
    }
}

#[test]
fn lines_become_metres_with_right_shoulders_on_the_right() {
    let recording = read(&small()).unwrap();
    let [a, b] = recording.people();
    assert_eq!((a.name.as_str(), b.name.as_str()), ("A", "B"));
    let stamps: Vec<Stamp> = recording.stamps().collect();
    assert_eq!(stamps, [Stamp(0), Stamp(66_666_667), Stamp(200_000_000)]);
    let hand = b.motion.skeleton().joint("right_hand").unwrap();
    assert!((b.motion.position(2, hand) - Point::new(0.1, -2.3, 1.1)).norm() < 1e-12);
    check_right_shoulders(&recording);
}

#[test]
fn broken_lines_are_named() {
    let check = |text: String, expected: &str| {
        assert_eq!(read(&text).unwrap_err().to_string(), expected);
    };
    let good = line(1);
    let short = line(2).rsplit_once(',').unwrap().0.to_string();
    check(format!("{good}\n{short}\n"), "line 2: expected 91 fields, got 90");
    let word = line(2).replacen(',', ",left", 1);
    let expected = "line 3: field 'A head x': 'left0.6953125' is not a number";
    check(format!("{good}\n\n{word}"), expected);
    let first = line(2).replacen('2', "2.5", 1);
    check(
        format!("{good}\n{first}"),
        "line 2: field 'frame': '2.5' is not a whole number from 0 on",
    );
    check(format!("{good}\n{good}"), "line 2: frame 1 comes after frame 1");
    let nan = format!("{},NaN", short);
    check(format!("{good}\n{nan}"), "line 2: field 'B right_foot z': 'NaN' is not finite");
    let far = format!("{},5000", short);
    let expected = "line 2: field 'B right_foot y': -6400 m is farther than 1000 m (hint: are these millimetres?)";
    check(format!("{good}\n{far}"), expected);
    let error = formats::read(good.as_bytes(), "clip", UpAxis::Y).unwrap_err().to_string();
    assert!(error.contains("up axis y does not apply"), "{error}");
}

#[test]
fn a_frame_number_beyond_time_is_no_panic() {
    let text = format!("{}\n{}", line(0), line(u64::MAX));
    assert!(read(&text).unwrap_err().to_string().contains("beyond ±292 years"));
}

#[test]
fn a_file_cut_anywhere_never_panics() {
    let text = small();
    for cut in 0..text.len() {
        let _ = read(&text[..cut]);
        let _ = formats::sbu::read(&text.as_bytes()[..cut], "clip");
    }
}

proptest! {
    #[test]
    fn flipped_bytes_never_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let mut bytes = small().into_bytes();
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        let _ = formats::read(&bytes, "clip", UpAxis::Z);
        let _ = formats::sbu::read(&bytes, "clip");
    }
}

/// Every file below `folder` whose name ends in `ending`.
fn files(folder: &std::path::Path, ending: &str) -> Vec<std::path::PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path, ending));
        } else if path.to_string_lossy().ends_with(ending) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The development recordings, which are no part of this package.
fn shared_data() -> Option<std::path::PathBuf> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    if !folder.is_dir() {
        eprintln!("SKIPPED: no recordings at {}", folder.display());
        return None;
    }
    Some(folder)
}

#[test]
fn every_real_sbu_clip_reads_with_right_shoulders_on_the_right() {
    let Some(folder) = shared_data() else { return };
    let clips = files(&folder.join("sbu/raw"), "skeleton_pos.txt");
    assert!(clips.len() > 100);
    for path in clips {
        let bytes = std::fs::read(&path).unwrap();
        let name = path.to_string_lossy();
        let recording = formats::read(&bytes, &name, UpAxis::Z);
        let recording = recording.unwrap_or_else(|error| panic!("{name}: {error}"));
        if name.contains("/07/") || name.contains("/05/") {
            check_right_shoulders(&recording);
        }
    }
}

#[test]
fn every_real_csv_reads() {
    let Some(folder) = shared_data() else { return };
    let sets = [
        ("dyn_handover/csv15", UpAxis::Z, 15, 30.0),
        ("buetepage", UpAxis::Y, 8, 31.0),
        ("kth_handover", UpAxis::Z, 13, 120.0),
    ];
    for (set, up, joints, hz) in sets {
        for path in files(&folder.join(set), ".csv") {
            let name = path.to_string_lossy();
            let recording = formats::read(&std::fs::read(&path).unwrap(), &name, up);
            let recording = recording.unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(recording.people()[0].motion.skeleton().len(), joints, "{name}");
            let rate = formats::rate(recording.stamps()).unwrap();
            assert!((rate / hz - 1.0).abs() < 0.05, "{name}: {rate}");
            check_heads_are_up(&recording);
        }
    }
}

#[track_caller]
fn check_heads_are_up(recording: &Recording) {
    for person in recording.people() {
        let skeleton = person.motion.skeleton();
        let (head, root) = (skeleton.part(Part::Head).unwrap(), skeleton.root());
        let up = person.motion.position(0, head) - person.motion.position(0, root);
        assert!(up.z > 0.7 * up.norm(), "{}", recording.name());
    }
}
