//! Acclaim skeletons and motions: what comes out is metres, radians and z up, and what is wrong
//! is named with its line, all of it together.

#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "helpers of tests fail by panicking")]

mod broken;
mod hostile;
mod real;

use std::num::NonZeroU32;

use handover_mesh::formats::amc::{Asf, Axis, Motion};
use handover_mesh::formats::{self, ReadError, UpAxis};
use handover_mesh::{Point, Stamp};

/// A leg that hangs down and a hip that cannot turn; the shin stands before what it hangs from.
const SKELETON: &str = "\
# made by hand
:version 1.10
:name leg
:units
  mass 1.0
  length 0.254
  angle deg
:documentation
   length 3 of nothing
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 3
     name shin
     direction 0 -2 0
     length 4
     axis 0 0 0 XYZ
    dof rx
    limits (-10.0 170.0)
  end
  begin
     id 1
     name hip
     direction 1 0 0
     length 1
     axis 0 0 0 XYZ
  end
  begin
     id 2
     name thigh
     direction 0 -1 0
     length 5
     axis 0 90 0 XYZ
    dof rx rz
    limits (-160.0 20.0)
           (-inf inf)
  end
:hierarchy
  begin
    root hip
    hip thigh
    thigh shin
  end
";

const HEADER: &str = "#!OML:ASF leg.ASF\n:FULLY-SPECIFIED\n:DEGREES\n";

/// Six lines of header and first frame, then three lines a frame: `root`, `thigh`, `shin`.
fn frame(number: u64) -> String {
    format!("{number}\nroot 0 {number} 0 0 0 0\nthigh -10 20.5\nshin 3e1\n")
}

fn motion() -> String {
    HEADER.to_owned() + &[80, 81, 82].map(frame).concat()
}

fn skeleton() -> Asf {
    Asf::read(SKELETON.as_bytes()).unwrap()
}

fn read(text: &str) -> Result<Motion, ReadError> {
    Motion::read(text.as_bytes(), &skeleton())
}

#[track_caller]
fn check_near(found: &[Point], expected: &[[f64; 3]], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        let distance = (found - Point::from(*expected)).norm();
        assert!(distance < tolerance, "{found} instead of {expected:?}");
    }
}

#[test]
fn a_skeleton_reads_in_metres_and_radians() {
    let skeleton = skeleton();
    assert_eq!(skeleton.name(), Some("leg"));
    assert!((skeleton.metres_per_unit() - 0.1).abs() < 1e-15);
    assert_eq!(skeleton.mass(), Some(1.0));
    assert_eq!(skeleton.channel_names(), ["shin.rx", "thigh.rx", "thigh.rz"]);
    let [shin, hip, thigh] = ["shin", "hip", "thigh"].map(|name| skeleton.bone(name).unwrap());
    assert_eq!([shin, hip, thigh].map(|bone| bone.index()), [0, 1, 2]);
    assert_eq!([shin, hip, thigh].map(|bone| skeleton[bone].id()), [Some(3), Some(1), Some(2)]);
    let parents = [shin, hip, thigh].map(|bone| skeleton[bone].parent());
    assert_eq!(parents, [Some(thigh), None, Some(hip)]);
    assert!((skeleton[shin].length() - 0.4).abs() < 1e-15);
    assert_eq!(skeleton[shin].direction(), -handover_mesh::Vector::y());
    assert_eq!(skeleton[thigh].channels(), 1..3);
    let [rx, rz] = skeleton[thigh].dofs() else { panic!("two") };
    assert_eq!((rx.axis, rz.axis), (Axis::X, Axis::Z));
    assert_eq!(rx.limits, Some([-160.0, 20.0].map(f64::to_radians)));
    assert_eq!(rz.limits, Some([f64::NEG_INFINITY, f64::INFINITY]));
    assert!(skeleton.bone("root").is_none() && skeleton[hip].dofs().is_empty());
}

#[test]
fn radians_and_degrees_mean_the_same() {
    let right_angle = std::f64::consts::FRAC_PI_2.to_string();
    let in_radians =
        SKELETON.replace("deg", "rad").replace("axis 0 90", &format!("axis 0 {right_angle}"));
    let skeleton = Asf::read(in_radians.as_bytes()).unwrap();
    let text = motion().replace(":DEGREES", ":RADIANS").replace("3e1", &right_angle);
    let found = Motion::read(text.as_bytes(), &skeleton).unwrap();
    assert_eq!(found.angles(0), [std::f64::consts::FRAC_PI_2, -10.0, 20.5]);
    let degrees = read(&motion().replace("3e1", "90").replace("-10 20.5", "0 0")).unwrap();
    let found = read(&text.replace("-10 20.5", "0 0")).unwrap();
    assert_eq!(found.positions(0), degrees.positions(0));
}

#[test]
fn a_motion_reads_with_the_root_kept_apart() {
    let motion = read(&motion()).unwrap();
    assert_eq!((motion.len(), motion.first_number()), (3, 80));
    assert_eq!(motion.rate(), Motion::USUAL_RATE);
    let stamps: Vec<Stamp> = motion.stamps().collect();
    assert_eq!(stamps, [Stamp(0), Stamp(8_333_333), Stamp(16_666_667)]);
    assert_eq!(motion.channel_names(), motion.skeleton().channel_names());
    assert_eq!(motion.angles(2), [30_f64, -10.0, 20.5].map(f64::to_radians));
    assert!((motion.root(2).translation.y - 8.2).abs() < 1e-12);
    assert_eq!(motion.root(2).rotation, [0.0; 3]);
    let rate = NonZeroU32::new(30).unwrap();
    let slower = Motion::read_at(self::motion().as_bytes(), &skeleton(), rate).unwrap();
    assert_eq!(slower.stamp(2), Stamp(66_666_667));
}

#[test]
fn positions_are_those_of_a_leg() {
    let at_rest = HEADER.to_owned() + "1\nroot 0 9 0 0 0 0\nshin 0\nthigh 0 0\n";
    let motion = read(&at_rest).unwrap();
    // x stays, and what points down in the file points down.
    check_near(&motion.positions(0), &[[0.1, 0., 0.], [0.1, 0., 0.9], [0.1, 0., 0.4]], 1e-12);
    let in_root = [[0.1, 0., -0.9], [0.1, 0., 0.], [0.1, 0., -0.5]];
    check_near(&motion.positions_in_root(0), &in_root, 1e-12);
    // The thigh's frame is turned about y: its x is the file's −z, so by +90 degrees about it the
    // thigh, from −y, comes to −x, and so does the shin. The shin's own x goes along with the
    // thigh, from x to −y; about it the shin turns from −x to z, which is −y where z is up.
    let bent = at_rest.replace("thigh 0 0", "thigh 90 0");
    let in_root = [[-0.8, 0., 0.], [0.1, 0., 0.], [-0.4, 0., 0.]];
    check_near(&read(&bent).unwrap().positions_in_root(0), &in_root, 1e-12);
    let bent = bent.replace("shin 0", "shin 90");
    let in_root = [[-0.4, 0.4, 0.], [0.1, 0., 0.], [-0.4, 0., 0.]];
    check_near(&read(&bent).unwrap().positions_in_root(0), &in_root, 1e-12);
    // The root turned about the vertical: x comes to −z of the file, which is y here.
    let turned = at_rest.replace("root 0 9 0 0 0 0", "root 10 9 0 0 90 0");
    let found = read(&turned).unwrap();
    check_near(&found.positions(0), &[[1., 0.1, 0.], [1., 0.1, 0.9], [1., 0.1, 0.4]], 1e-12);
}

#[test]
fn spelling_that_means_the_same_reads_the_same() {
    let usual = read(&motion()).unwrap();
    let text = format!("\u{feff}{}\n  \n# end\n", motion()).replace('\n', "\r\n");
    assert_eq!(read(&text.replace(":DEGREES", ":degrees")).unwrap(), usual);
    let text = motion().replace("thigh", "hip\n\tthigh  ").replace("3e1", " +30.0 ");
    assert_eq!(read(&text).unwrap(), usual);
    let text = SKELETON.replace('\n', " \r\n").replace("rx rz", "RX RZ").replace("XYZ", "xyz");
    assert_eq!(Asf::read(text.as_bytes()).unwrap(), skeleton());
}

#[test]
fn what_is_no_recording_says_what_takes_it() {
    let check = |text: &str, expected: &str| {
        let error = formats::read(text.as_bytes(), "clip", UpAxis::Z).unwrap_err();
        assert_eq!(error.to_string(), expected);
    };
    let rest = "of one person; a recording has two (hint: `handover motion` takes it)";
    check(&motion(), &format!("line 2: AMC motion {rest}"));
    check(SKELETON, &format!("line 2: ASF skeleton {rest}"));
}

/// Every bone is as long as the skeleton says.
#[track_caller]
fn check_lengths(skeleton: &Asf, ends: &[Point], root: Point) {
    for (bone, end) in skeleton.bones().iter().zip(ends) {
        let start = bone.parent().map_or(root, |parent| ends[parent.index()]);
        let length = (end - start).norm();
        assert!((length - bone.length()).abs() < 1e-12, "{}: {length}", bone.name());
    }
}
