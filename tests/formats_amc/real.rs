//! Walks of the CMU database: their frames, their values and where their feet are.

use std::path::PathBuf;

use handover_mesh::Point;
use handover_mesh::formats;
use handover_mesh::formats::amc::{Asf, Motion};

use crate::check_lengths;

/// One walk: its name, its text and what was read.
struct Walk {
    name: &'static str,
    text: String,
    motion: Motion,
}

/// The development recordings, which are no part of this package.
fn walks() -> Option<(Asf, [Walk; 4])> {
    let shared = std::env::var_os("HANDOVER_DATA").map(PathBuf::from);
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = shared.unwrap_or_else(beside).join("cmu/35");
    if !folder.is_dir() {
        eprintln!("SKIPPED: no motions at {}", folder.display());
        return None;
    }
    let skeleton = Asf::read(&std::fs::read(folder.join("35.asf")).unwrap());
    let skeleton = skeleton.unwrap_or_else(|error| panic!("35.asf: {error}"));
    let walks = ["35_07", "35_08", "35_13", "35_16"].map(|name| {
        let text = std::fs::read_to_string(folder.join(format!("{name}.amc"))).unwrap();
        let motion = Motion::read(text.as_bytes(), &skeleton);
        let motion = motion.unwrap_or_else(|error| panic!("{name}: {error}"));
        Walk { name, text, motion }
    });
    Some((skeleton, walks))
}

/// Two of these walks are cut, as their README says: both between frames, so they read as they
/// are, and one starts late.
#[test]
fn real_walks_have_the_frames_and_channels_they_should() {
    let Some((skeleton, walks)) = walks() else { return };
    assert_eq!((skeleton.bones().len(), skeleton.channel_count()), (30, 56));
    let names = skeleton.channel_names();
    assert_eq!(names[..4], ["lfemur.rx", "lfemur.ry", "lfemur.rz", "ltibia.rx"]);
    let found = walks.each_ref().map(|walk| {
        let motion = &walk.motion;
        assert_eq!(6 + motion.angles(motion.len() - 1).len(), 62);
        assert_eq!(formats::rate(motion.stamps()).map(f64::round), Some(120.0));
        (walk.name, motion.first_number(), motion.len())
    });
    let expected = [("35_07", 1, 360), ("35_08", 1, 445), ("35_13", 80, 321), ("35_16", 1, 443)];
    assert_eq!(found, expected);
}

/// Every value against the text, found there by other means.
#[test]
fn real_values_are_those_of_the_text() {
    let Some((skeleton, walks)) = walks() else { return };
    for Walk { name, text, motion } in &walks {
        let mut lines = text.lines().skip(3);
        for frame in 0..motion.len() {
            let number: u64 = lines.next().unwrap().parse().unwrap();
            assert_eq!(number, motion.first_number() + frame as u64, "{name}");
            for line in lines.by_ref().take(29) {
                let (bone, values) = line.split_once(' ').unwrap();
                let values: Vec<f64> = values.split(' ').map(|v| v.parse().unwrap()).collect();
                let radians: Vec<f64> = values.iter().map(|v| v.to_radians()).collect();
                if let Some(bone) = skeleton.bone(bone) {
                    let found = &motion.angles(frame)[skeleton[bone].channels()];
                    assert_eq!(found, radians, "{name}: {line}");
                    continue;
                }
                let root = motion.root(frame);
                assert_eq!(root.rotation, radians[3..], "{name}: {line}");
                for (value, metres) in values.iter().zip(&root.translation) {
                    assert!((value / 0.45 * 0.0254 - metres).abs() < 1e-12, "{name}: {line}");
                }
            }
        }
        assert_eq!(lines.next(), None);
    }
}

/// Places `[m]` that a slow program of its own, with matrices of three by three, worked out.
#[test]
fn real_places_are_those_of_an_independent_computation() {
    let Some((skeleton, walks)) = walks() else { return };
    let check = |walk: &Walk, number: u64, bone: &str, expected: [f64; 3]| {
        let frame = (number - walk.motion.first_number()) as usize;
        let end = walk.motion.positions(frame)[skeleton.bone(bone).unwrap().index()];
        // The file's directions have length one to six digits only; ours are exactly that long.
        assert!((end - Point::from(expected)).norm() < 3e-6, "{bone}: {end}");
    };
    let [first, _, third, _] = &walks;
    check(first, 100, "head", [0.006696, -0.084619, 1.637318]);
    check(first, 100, "ltoes", [0.051006, 0.144572, 0.048028]);
    check(first, 100, "rfingers", [-0.229811, -0.087732, 0.733916]);
    check(first, 100, "lthumb", [0.314644, -0.310501, 0.886962]);
    check(third, 200, "head", [0.034583, -0.217999, 1.657206]);
    check(third, 200, "lthumb", [0.281763, -0.286636, 0.830941]);
}

#[test]
fn real_walkers_stand_on_the_floor_with_bones_of_one_length() {
    let Some((skeleton, walks)) = walks() else { return };
    let index = |name| skeleton.bone(name).unwrap().index();
    let feet = ["lfoot", "ltoes", "rfoot", "rtoes"].map(index);
    for Walk { name, motion, .. } in &walks {
        for frame in 0..motion.len() {
            let ends = motion.positions(frame);
            let world_from_root = skeleton.world_from_root(motion.root(frame));
            check_lengths(&skeleton, &ends, world_from_root * Point::origin());
            let lowest = feet.iter().map(|foot| ends[*foot].z).fold(f64::INFINITY, f64::min);
            assert!((-0.05..0.1).contains(&lowest), "{name}, {frame}: lowest foot {lowest} m");
            let head = ends[index("head")].z;
            assert!((1.5..1.8).contains(&head), "{name}, {frame}: head {head} m");
            for (end, in_root) in ends.iter().zip(motion.positions_in_root(frame)) {
                assert!((world_from_root * in_root - end).norm() < 1e-12);
            }
        }
        let travelled = motion.root(motion.len() - 1).translation - motion.root(0).translation;
        assert!(travelled.norm() > 2.5, "{name}: {travelled}");
    }
}
