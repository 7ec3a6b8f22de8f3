//! Whatever the bytes are, a reader neither panics nor takes much time or memory.

use handover_mesh::Point;
use handover_mesh::formats::amc::{Asf, Motion};
use handover_mesh::formats::{ReadError, Reason};
use handover_mesh::geometry::is_finite;
use proptest::prelude::*;

use crate::{HEADER, SKELETON, check_lengths, motion, read, skeleton};

/// A skeleton that is one chain of bones, each with these degrees of freedom.
fn chain(count: usize, dofs: &str) -> String {
    let head = SKELETON.split_once(":bonedata").unwrap().0;
    let rest = format!("direction 0 1 0\nlength 1\naxis 0 0 0 XYZ\ndof {dofs}\nend\n");
    let bones: String = (0..count).map(|at| format!("begin\nname b{at}\n{rest}")).collect();
    let links: String = (1..count).map(|at| format!("b{} b{at}\n", at - 1)).collect();
    format!("{head}:bonedata\n{bones}:hierarchy\nbegin\nroot b0\n{links}end\n")
}

#[test]
fn skeletons_have_bounds() {
    let longest = Asf::read(chain(Asf::MOST_BONES, "").as_bytes()).unwrap();
    let end = longest.positions_in_root(&[])[Asf::MOST_BONES - 1];
    assert!((end.z - 100.0).abs() < 1e-9, "{end}");
    let error = Asf::read(chain(Asf::MOST_BONES + 1, "").as_bytes()).unwrap_err();
    assert_eq!(error.violations()[0].reason, Reason::TooManyBones { most: 1000 });
    let many = SKELETON.replace("root hip", &format!("root{}", " hip".repeat(100_000)));
    assert!(Asf::read(many.as_bytes()).unwrap_err().to_string().contains("more than 1000 bones"));
    let many = SKELETON.replace("rx rz", &"rx ".repeat(100_000));
    assert!(Asf::read(many.as_bytes()).unwrap_err().more() > 90_000);
    let many = SKELETON.replace("(-inf inf)", &"(".repeat(100_000));
    assert!(Asf::read(many.as_bytes()).is_err());
}

#[test]
fn frames_without_values_cost_little() {
    let skeleton = Asf::read(chain(999, "rx").as_bytes()).unwrap();
    let numbers: String = (0..20_000).map(|frame| format!("{frame}\n")).collect();
    let error = Motion::read(format!("{HEADER}{numbers}").as_bytes(), &skeleton).unwrap_err();
    let first = "line 4: frame 0: without 'b0', 'b1', 'b2' and 997 more";
    assert_eq!(error.violations()[0].to_string(), first);
    assert_eq!(error.more(), 20_000 - ReadError::MOST);
}

#[test]
fn a_stranger_is_named_once() {
    let error = read(&motion().replace("shin", "tail 1\nshin")).unwrap_err();
    assert_eq!((error.violations().len(), error.more()), (1, 0));
    let strangers: String = (0..20_000).map(|at| format!("s{at} 1\n")).collect();
    let error = read(&format!("{}{strangers}", motion())).unwrap_err();
    assert_eq!(error.violations().len() + error.more(), 20_000);
}

/// Reads as either, and whatever reads has places for all its bones.
fn check_any(skeleton_bytes: &[u8], motion_bytes: &[u8]) {
    let skeleton = Asf::read(skeleton_bytes).unwrap_or_else(|_| skeleton());
    let Ok(motion) = Motion::read(motion_bytes, &skeleton) else { return };
    assert_eq!(motion.stamps().len(), motion.len());
    for frame in 0..motion.len() {
        for points in [motion.positions(frame), motion.positions_in_root(frame)] {
            assert_eq!(points.len(), skeleton.bones().len());
            assert!(points.iter().all(is_finite), "{points:?}");
        }
    }
}

type Flips = Vec<(prop::sample::Index, u8)>;

fn flips() -> impl Strategy<Value = Flips> {
    prop::collection::vec((any::<prop::sample::Index>(), letter()), 0..6)
}

fn flipped(text: &str, flips: &Flips) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for (at, value) in flips {
        let at = at.index(bytes.len());
        bytes[at] = *value;
    }
    bytes
}

/// Bytes that such files are made of, and some that they are not.
fn letter() -> impl Strategy<Value = u8> {
    prop_oneof![4 => prop::sample::select(&b"0123456789 -.e()\n:rxyz"[..]), 1 => any::<u8>()]
}

/// A line of either file, or words of one.
fn piece() -> impl Strategy<Value = String> {
    let lines: Vec<String> = [SKELETON, &motion()].concat().lines().map(str::to_owned).collect();
    prop_oneof![prop::sample::select(lines), "(root|hip|thigh|shin|begin|end|-?[0-9]{1,20}| )*"]
}

proptest! {
    #[test]
    fn any_acclaim_bytes_never_panic(bytes in prop::collection::vec(letter(), 0..400)) {
        check_any(&bytes, &bytes);
        let after_frames = [motion().as_bytes(), &bytes].concat();
        check_any(&[SKELETON.as_bytes(), &bytes].concat(), &after_frames);
    }

    #[test]
    fn acclaim_lines_in_any_order_never_panic(pieces in prop::collection::vec(piece(), 0..80)) {
        let text = pieces.join("\n");
        check_any(text.as_bytes(), text.as_bytes());
        check_any(text.as_bytes(), motion().as_bytes());
    }

    #[test]
    fn flipped_acclaim_bytes_never_panic(in_skeleton in flips(), in_motion in flips()) {
        check_any(&flipped(SKELETON, &in_skeleton), &flipped(&motion(), &in_motion));
    }

    #[test]
    fn any_angles_keep_every_bones_length(angles in prop::array::uniform3(-1e3..1e3)) {
        let skeleton = skeleton();
        check_lengths(&skeleton, &skeleton.positions_in_root(&angles), Point::origin());
    }
}
