//! What is wrong with a skeleton or a motion is named with its line, all of it together.

use handover_mesh::formats::Reason;
use handover_mesh::formats::amc::{Asf, Motion};

use crate::{HEADER, SKELETON, frame, motion, read};

#[track_caller]
fn check_skeleton(from: &str, to: &str, expected: &str) {
    assert!(SKELETON.contains(from), "{from}");
    let error = Asf::read(SKELETON.replacen(from, to, 1).as_bytes()).unwrap_err();
    assert_eq!(error.to_string(), expected);
}

#[test]
fn broken_skeletons_are_named() {
    let check = check_skeleton;
    let sections = ":version, :name, :documentation, :units, :root, :bonedata, :hierarchy";
    let unknown = format!("line 8: section ':skin' is not known (known are: {sections})");
    check(":documentation", ":skin", &unknown);
    check(":name leg", ":units", "line 4: section ':units' appears twice");
    check("length 0.254", "length 0", "line 6: field 'length': 0 must be above 0");
    check(
        "length 0.254",
        "length 1e-30",
        "line 4: field 'length': 25400000000000000000000000000 m is farther than 1000 m (hint: are these millimetres?)",
    );
    check(
        "length 0.254",
        "breadth 2",
        "line 4: 'length' is missing\nline 6: unit 'breadth' is not known (known are: mass, length, angle)",
    );
    check("angle deg", "angle grad", "line 7: angle 'grad' is not known (known are: deg, rad)");
    check("RY RZ", "RY", "line 11: expected 6 fields, got 5");
    check("RY RZ", "RY RY", "line 11: 'RY' appears twice");
    check(
        "axis XYZ",
        "axis XXZ",
        "line 12: order of axes 'XXZ' is not known (known are: XYZ, XZY, YXZ, YZX, ZXY, ZYX)",
    );
    check("position 0 0 0", "position 0 inf 0", "line 13: field 'position y': 'inf' is not finite");
    check("   position 0 0 0\n", "", "line 10: 'position' is missing");
    check(
        "name shin",
        "name hip",
        "line 25: bone 'hip' appears twice\nline 46: bone 'shin' is not in the skeleton",
    );
    check(
        "name shin",
        "name root",
        "line 16: bone 'root' appears twice\nline 46: bone 'shin' is not in the skeleton",
    );
    check("id 3", "id 2", "line 32: bone id 2 appears twice");
    check("id 3", "id -3", "line 17: field 'id': '-3' is not a whole number from 0 on");
    check(
        "direction 0 -2 0",
        "direction 0 -0 0",
        "line 16: bone 'shin': its direction has no length",
    );
    check("direction 0 -2 0", "direction 0 -2", "line 19: expected 3 fields, got 2");
    check(
        "direction 0 -2 0",
        "direction 0 down NaN",
        "line 19: field 'direction y': 'down' is not a number\nline 19: field 'direction z': 'NaN' is not finite",
    );
    check("length 4", "length -4", "line 20: field 'length': -4 must be 0 or more");
    check("     length 4\n", "", "line 16: 'length' of bone 'shin' is missing");
    check(
        "length 4",
        "length 4e9",
        "line 16: field 'length of shin': 399999999.99999994 m is farther than 1000 m (hint: are these millimetres?)",
    );
    check("axis 0 0 0 XYZ", "axis 0 0 0", "line 21: expected 4 fields, got 3");
    check(
        "dof rx rz",
        "dof rx tx l",
        "line 38: degree of freedom 'tx' is not known (known are: rx, ry, rz)\nline 38: degree of freedom 'l' is not known (known are: rx, ry, rz)",
    );
    check("dof rx rz", "dof rx rx", "line 38: 'rx' appears twice");
    check("dof rx rz", "dof rx rz ry", "line 39: values of 'limits of thigh': expected 3, got 2");
    check(
        "(-10.0 170.0)",
        "(10.0 -170.0)",
        "line 23: '(10.0 -170.0)' is no pair of limits such as (-10 20)",
    );
    check("(-inf inf)", "(-inf inf", "line 40: '(-inf inf' is no pair of limits such as (-10 20)");
    check(
        "    dof rx\n",
        "    dofs rx\n",
        "line 22: key of a bone 'dofs' is not known (known are: id, name, direction, length, axis, dof, limits, bodymass, cofmass)\nline 23: values of 'limits of shin': expected 0, got 1",
    );
    check("hip thigh", "shin thigh", "line 16: bone 'shin' hangs from itself");
    check(
        "thigh shin",
        "thigh shin hip",
        "line 46: the place of bone 'hip' in the hierarchy appears twice",
    );
    check("    thigh shin\n", "", "line 16: the place of bone 'shin' in the hierarchy is missing");
    check("thigh shin\n  end", "thigh shin", "line 43: the 'end' of this 'begin' is missing");
}

#[test]
fn a_skeleton_without_anything_says_all_that_is_missing() {
    let error = Asf::read(b"#\n:version 1.10\n:root\n").unwrap_err().to_string();
    let expected = "\
        line 1: section ':units' is missing\n\
        line 1: section ':bonedata' is missing\n\
        line 1: section ':hierarchy' is missing\n\
        line 3: 'order' is missing\n\
        line 3: 'axis' is missing\n\
        line 3: 'position' is missing\n\
        line 3: 'orientation' is missing";
    assert_eq!(error, expected);
    assert_eq!(Asf::read(b" \r\n").unwrap_err().violations()[0].reason, Reason::Empty);
    let error = Asf::read(b"HIERARCHY\nROOT Hips\n:bonedata\n").unwrap_err();
    let told = error.to_string();
    assert!(told.contains("line 1: section 'HIERARCHY' is not known"), "{told}");
    assert!(told.ends_with("line 3: a bone is missing"), "{told}");
}

#[track_caller]
fn check_motion(from: &str, to: &str, expected: &str) {
    let text = motion();
    assert!(text.contains(from), "{from}");
    assert_eq!(read(&text.replacen(from, to, 1)).unwrap_err().to_string(), expected);
}

/// Lines of the small motion: 4 to 7 are frame 80, 8 to 11 frame 81, 12 to 15 frame 82.
#[test]
fn broken_motions_are_named() {
    let check = check_motion;
    let first = "before the first frame, is missing";
    check(":DEGREES\n", "", &format!("line 3: ':DEGREES' or ':RADIANS', {first}"));
    check(":FULLY-SPECIFIED\n", "", &format!("line 3: ':FULLY-SPECIFIED', {first}"));
    let known = "is not known (known are: :FULLY-SPECIFIED, :DEGREES, :RADIANS)";
    check("80\n", ":FRAMES 3\n80\n", &format!("line 4: section ':FRAMES 3' {known}"));
    check("81\n", ":RADIANS\n81\n", "line 8: the unit of angles appears twice");
    let number = "the number of the first frame, before its values, is missing";
    check("80\n", "", &format!("line 4: {number}"));
    check(
        "81\n",
        "80\n",
        "line 8: frame 80 comes after frame 80\n\
        line 12: frame 82 comes after frame 80: those between are missing",
    );
    check("82\n", "9\n", "line 12: frame 9 comes after frame 81");
    let gap = "line 12: frame 90 comes after frame 81: those between are missing";
    check("82\n", "90\n", gap);
    let whole = "is not a whole number from 0 on";
    let long = "99999999999999999999";
    check("82\n", &format!("{long}\n"), &format!("line 12: field 'frame': '{long}' {whole}"));
    check("81\n", "81.0\n", &format!("line 8: field 'frame': '81.0' {whole}"));
    check("81\n", "-81\n", &format!("line 8: field 'frame': '-81' {whole}"));
    let skin = "line 4: frame 80: without 'shin'\nline 7: bone 'skin' is not in the skeleton";
    check("shin", "skin", skin);
    check("shin 3e1\n", "", "line 4: frame 80: without 'shin'");
    check("root 0 80 0 0 0 0\n", "", "line 4: frame 80: without 'root'");
    check("shin", "thigh 0 0\nshin", "line 7: frame 80: 'thigh' appears twice");
    check("shin 3e1", "shin", "line 7: values of 'shin': expected 1, got 0");
    check("shin 3e1", "hip 3\nshin 3e1", "line 7: values of 'hip': expected 0, got 1");
    check("root 0 80", "root 80", "line 5: values of 'root': expected 6, got 5");
    check(
        "-10 20.5",
        "ten NaN",
        "line 6: field 'thigh.rx': 'ten' is not a number\n\
        line 6: field 'thigh.rz': 'NaN' is not finite",
    );
    let most = "line 7: field 'shin.rx': -2000000 must be an angle of at most a million";
    check("shin 3e1", "shin -2e6", most);
    check(
        "root 0 80",
        "root inf 80e4",
        "line 5: field 'root.tx': 'inf' is not finite\n\
        line 5: field 'root.ty': 80000 m is farther than 1000 m (hint: are these millimetres?)",
    );
}

#[test]
fn everything_wrong_with_a_motion_comes_together() {
    let text = motion()
        .replacen("81\n", "83\n", 1)
        .replacen("thigh -10 20.5", "foot 1", 1)
        .replace("root 0 81 0 0 0 0", "root 0 81 0 0 0")
        .replace("82\nroot", "84\n?\nroot");
    let text = text.strip_suffix("shin 3e1\n").unwrap();
    let expected = "\
        line 4: frame 80: without 'thigh'\n\
        line 6: bone 'foot' is not in the skeleton\n\
        line 8: frame 83 comes after frame 80: those between are missing\n\
        line 9: values of 'root': expected 6, got 5\n\
        line 12: frame 84: without 'shin' (hint: the file ends there)\n\
        line 13: bone '?' is not in the skeleton";
    assert_eq!(read(text).unwrap_err().to_string(), expected);
}

#[test]
fn no_frames_are_told_from_no_bytes() {
    let check = |text: &str, reason: Reason| {
        assert_eq!(read(text).unwrap_err().violations()[0].reason, reason, "{text}");
    };
    check("", Reason::Empty);
    check("\n \r\n", Reason::Empty);
    check(HEADER, Reason::NoFrames);
    check("# nothing", Reason::NoFrames);
}

/// A file that is cut between frames is a shorter motion: nothing in it tells how long it was.
#[test]
fn a_motion_cut_anywhere_but_between_frames_is_refused() {
    let text = motion();
    let ends = [1, 2, 3].map(|frames| HEADER.len() + frames * frame(80).len());
    for cut in 0..text.len() {
        let found = read(&text[..cut]);
        let frames = ends.iter().position(|end| *end == cut).map(|at| at + 1);
        assert_eq!(found.as_ref().ok().map(Motion::len), frames, "{cut}: {found:?}");
    }
    let cut = read(text.trim_end()).unwrap_err().to_string();
    assert!(cut.starts_with("line 15: the last line has no end: the file is cut"), "{cut}");
    let in_a_frame = read(&text[..ends[1] + 10]).unwrap_err().to_string();
    assert!(in_a_frame.contains("line 13: values of 'root': expected 6"), "{in_a_frame}");
    assert!(in_a_frame.contains("line 13: the last line has no end"), "{in_a_frame}");
}

#[test]
fn a_skeleton_cut_anywhere_is_refused() {
    let text = SKELETON.trim_end();
    for cut in 0..text.len() {
        assert!(Asf::read(&text.as_bytes()[..cut]).is_err(), "{cut}");
    }
}
