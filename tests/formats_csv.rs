//! CSV: what is written reads back, and what is wrong is named with its line.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::collections::BTreeMap;
use std::sync::Arc;

use handover_mesh::formats::csv::{self, HEADER, WriteError};
use handover_mesh::formats::{self, Place, ReadError, UpAxis};
use handover_mesh::{
    Frame, ObjectTrack, Person, Point, PointTrack, Recording, Role, Sequence, Skeleton, Stamp,
};
use proptest::prelude::*;

const EIGHT: &str =
    "head torso left_shoulder left_elbow left_hand right_shoulder right_elbow right_hand";
const THIRTEEN: &str =
    "head neck chest ab hip LShoulder LUArm LFArm LHand RShoulder RUArm RFArm RHand";

fn skeleton(which: usize) -> Arc<Skeleton> {
    let names = |text: &str| text.split(' ').map(String::from).collect();
    match which {
        0 => Skeleton::nite(),
        1 => Arc::new(Skeleton::from_names(names(EIGHT)).unwrap()),
        _ => Arc::new(Skeleton::from_names(names(THIRTEEN)).unwrap()),
    }
}

/// Rows of `frames` frames at 10 Hz: `giver` and `receiver` with two joints each.
fn small(frames: usize) -> Vec<String> {
    let mut lines = vec![HEADER.to_string()];
    for frame in 0..frames {
        for (person, x) in [("giver", 0.0), ("receiver", 1.0)] {
            for (joint, z) in [("neck", 1.7), ("right_hand", 1.0)] {
                let time = frame as f64 / 10.0;
                lines.push(format!("{frame},{time:.1},{person},{joint},{x},0,{z}"));
            }
        }
    }
    lines
}

fn read(text: &str) -> Result<Recording, ReadError> {
    formats::read(text.as_bytes(), "clip", UpAxis::Z)
}

#[track_caller]
fn check(lines: &[String], expected: &str) {
    match read(&lines.join("\n")) {
        Ok(recording) => assert_eq!(expected, "good", "{recording:?}"),
        Err(error) => assert_eq!(error.to_string(), expected),
    }
}

/// `small(3)` with one line (counted from 1) changed.
#[track_caller]
fn check_line(line: usize, change: impl Fn(&str) -> String, expected: &str) {
    let mut lines = small(3);
    lines[line - 1] = change(&lines[line - 1]);
    check(&lines, expected);
}

#[test]
fn a_plain_file_reads() {
    let text = format!("\u{feff}# class=07\r\n\r\n{}\r\n", small(3).join("\r\n"));
    let recording = read(&text).unwrap();
    assert_eq!((recording.name(), recording.len()), ("clip", 3));
    assert_eq!(recording.metadata()["class"], "07");
    let receiver = recording.person(Role::Second);
    assert_eq!(receiver.name, "receiver");
    assert_eq!(receiver.motion.skeleton().names(), ["neck", "right_hand"]);
    assert_eq!(receiver.motion.frames()[2].positions[1], Point::new(1.0, 0.0, 1.0));
    assert_eq!(recording.stamps().last(), Some(Stamp(200_000_000)));
}

#[test]
fn joint_order_is_canonical_and_y_up_turns() {
    let mut lines = small(2);
    lines.swap(1, 2);
    lines.insert(3, "0,0.0,object,baton,1,2,3".into());
    let recording = formats::read(lines.join("\n").as_bytes(), "clip", UpAxis::Y).unwrap();
    let giver = &recording.person(Role::First).motion;
    assert_eq!(giver.skeleton().names(), ["neck", "right_hand"]);
    assert_eq!(giver.frames()[0].positions[0], Point::new(0.0, -1.7, 0.0));
    let object = recording.object().unwrap();
    let [baton] = &object.points[..] else { panic!("one point") };
    assert_eq!(baton.name, "baton");
    assert_eq!(baton.places, [(Stamp(0), Point::new(1.0, -3.0, 2.0))]);
}

#[test]
fn broken_rows_are_named() {
    check_line(4, |_| "0,0.0,receiver".into(), "line 4: expected 7 fields, got 3");
    check_line(4, |l| l.replace(",0,", ",0,0,"), "line 4: expected 7 fields, got 8");
    check_line(6, |l| l.replace("1.7", "abc"), "line 6: field 'z': 'abc' is not a number");
    check_line(6, |l| l.replace("1.7", "nan"), "line 6: field 'z': 'nan' is not finite");
    check_line(6, |l| l.replace("1.7", "-inf"), "line 6: field 'z': '-inf' is not finite");
    let far = "line 6: field 'z': 1700 m is farther than 1000 m (hint: are these millimetres?)";
    check_line(6, |l| l.replace("1.7", "1700"), far);
    let number = "line 6: field 'frame': '-1' is not a whole number from 0 on";
    check_line(6, |l| l.replacen('1', "-1", 1), number);
    check_line(3, |l| l.replace("giver", ""), "line 3: field 'person' is empty");
    let late = "line 3: field 'time_s': '9e99' s is beyond ±292 years";
    check_line(3, |l| l.replace("0.0", "9e99"), late);
    check_line(2, |l| l.replacen("0.0", "x", 1), "line 2: field 'time_s': 'x' is not a number");
}

#[test]
fn a_row_may_have_several_faults() {
    let expected = "line 6: field 'frame': 'one' is not a whole number from 0 on\n\
        line 6: field 'z': 'high' is not a number";
    check_line(6, |l| l.replacen('1', "one", 1).replace("1.7", "high"), expected);
}

#[test]
fn joints_missing_doubled_or_unknown_are_named() {
    let missing = "line 6: frame 1: 'right_hand' of 'giver' is missing";
    let mut lines = small(3);
    lines.remove(6);
    check(&lines, missing);
    let twice = "line 3: frame 0: 'neck' of 'giver' appears twice";
    let mut lines = small(3);
    lines.insert(2, lines[1].clone());
    check(&lines, twice);
    let mut lines = small(3);
    lines.insert(2, "0,0.0,giver,head,0,0,1.5".into());
    check(&lines, "line 3: 'head' of 'giver' is in 1 of 3 frames only");
    let mut lines = small(3);
    lines[1] = lines[1].replace("neck", "tail");
    let error = read(&lines.join("\n")).unwrap_err().to_string();
    assert!(error.starts_with("line 2: person 'giver': unknown joint 'tail'; known are: head"));
    assert_eq!(error.lines().count(), 1, "{error}");
    lines[3] = lines[3].replace("neck", "fin");
    let error = read(&lines.join("\n")).unwrap_err().to_string();
    assert!(error.ends_with("line 4: person 'receiver': unknown joint 'fin'"), "{error}");
}

#[test]
fn two_people_no_more_no_less() {
    let mut lines = small(3);
    lines.insert(5, "0,0.0,guest,neck,0,0,0".into());
    check(&lines, "line 6: a third person 'guest' beside 'giver' and 'receiver'");
    let one: Vec<_> = small(3).into_iter().filter(|l| !l.contains("receiver")).collect();
    check(&one, "line 2: two people are needed, found only 'giver'");
    let object = [HEADER.to_string(), "0,0.0,object,ball,0,0,0".into()];
    check(&object, "line 2: two people are needed, found none");
    let mut lines = small(3);
    lines.drain(7..9);
    let hint = "(hint: were the two recorded at different rates?)";
    check(&lines, &format!("line 6: frame 1 lacks 'receiver' {hint}"));
    let mut lines = small(3);
    lines.extend((0..70).map(|k| format!("2,0.2,object,vertex_{k},0,0,0")));
    check(&lines, "line 78: the object has more than 64 points");
}

#[test]
fn frames_and_times_must_rise() {
    let renumbered = |from: &str, to: &str| -> Vec<String> {
        let change = |line: String| match line.strip_prefix(from) {
            Some(rest) => format!("{to}{rest}"),
            None => line,
        };
        small(3).into_iter().map(change).collect()
    };
    check(&renumbered("2,0.2", "0,0.2"), "line 10: frame 0 comes after frame 1");
    let back = "line 10: frame 2: time 0.1000 s is not after 0.1000 s";
    check(&renumbered("2,0.2", "2,0.1"), back);
    let differs = "line 7: frame 1: time 0.1500 s differs from 0.1000 s earlier in the same frame";
    check_line(7, |l| l.replace("0.1", "0.15"), differs);
}

#[test]
fn mixed_rates_are_named_and_dropped_frames_are_not() {
    let timed = |milliseconds: &[i64]| -> Vec<String> {
        let mut lines = vec![HEADER.to_string()];
        for (frame, ms) in milliseconds.iter().enumerate() {
            for row in &small(1)[1..] {
                let rest = row.strip_prefix("0,0.0").unwrap();
                lines.push(format!("{frame},{}{rest}", *ms as f64 / 1000.0));
            }
        }
        lines
    };
    let drops: Vec<i64> = (0..30).filter(|k| k % 7 != 3).map(|k| k * 33).collect();
    check(&timed(&drops), "good");
    let change = |k: i64| if k < 10 { k * 33 } else { 330 + (k - 10) * 66 };
    let expected = "line 42: mixed rates: 15.2 Hz from here on, 30.3 Hz in most of the file";
    check(&timed(&(0..20).map(change).collect::<Vec<_>>()), expected);
}

#[test]
fn files_that_are_none_say_so() {
    check(&["".into()], "line 1: the file is empty");
    check(&[HEADER.into()], "line 1: no frames: nothing follows the header");
    check(&["# a=b".into()], "line 1: no frames: nothing follows the header");
    let header = HEADER.replace(",z", "");
    let wrong = format!("line 2: the header must be '{HEADER}', got '{header}'");
    check(&["".into(), header, "0,0,a,neck,1,2".into()], &wrong);
    let mut bytes = small(3).join("\n").into_bytes();
    let at = bytes.len() - 5;
    bytes[at] = 0xff;
    let error = formats::read(&bytes, "clip", UpAxis::Z).unwrap_err();
    assert_eq!(error.to_string(), "line 13: not UTF-8 text");
}

#[test]
fn twenty_violations_are_kept_and_the_rest_counted() {
    let mut lines = small(20);
    for line in lines.iter_mut().skip(1).take(50) {
        line.push('x');
    }
    let error = read(&lines.join("\n")).unwrap_err();
    assert_eq!((error.violations().len(), error.more()), (ReadError::MOST, 30));
    let places = [0, 19].map(|at| &error.violations()[at].place);
    assert_eq!(places, [&Place::Line(2), &Place::Line(21)]);
    assert!(error.to_string().ends_with("\n... and 30 more"));
}

#[test]
fn quoted_fields_count_lines_rightly() {
    let mut lines = small(2);
    for line in &mut lines[1..] {
        *line = line.replace("giver", "\"gi\n\nver\"");
    }
    let recording = read(&lines.join("\n")).unwrap();
    assert_eq!(recording.person(Role::First).name, "gi\n\nver");
    lines.push("1,0.1".into());
    check(&lines, "line 18: expected 7 fields, got 2");
}

/// Two people of one skeleton, a step `[ns]` between frames, places taken from `coordinates`.
fn recording(
    which: usize,
    steps: &[i64],
    coordinates: &[f64],
    object: &[bool],
    metadata: BTreeMap<String, String>,
) -> Recording {
    let skeleton = skeleton(which);
    let mut coordinates = coordinates.iter().copied().cycle();
    let mut point = || {
        let mut next = || coordinates.next().unwrap();
        Point::new(next(), next(), next())
    };
    let mut stamps = vec![Stamp(-70_000_001)];
    for step in steps {
        stamps.push(Stamp(stamps[stamps.len() - 1].0 + step));
    }
    let mut person = |name: &str| {
        let mut frames = Vec::new();
        for stamp in &stamps {
            let positions = (0..skeleton.len()).map(|_| point()).collect();
            frames.push(Frame { stamp: *stamp, positions });
        }
        Person { name: name.into(), motion: Sequence::new(skeleton.clone(), frames).unwrap() }
    };
    let people = [person("the, \"giver\""), person("B")];
    let mut track = |name: &str, known: &dyn Fn(usize) -> bool| {
        let known = stamps.iter().enumerate().filter(|(at, _)| object[*at] && known(*at));
        let places: Vec<_> = known.map(|(_, stamp)| (*stamp, point())).collect();
        PointTrack { name: name.into(), places }
    };
    // Of two points one is known more often.
    let mut points = vec![track("base", &|at| at % 2 == 0), track("rim", &|_| true)];
    points.retain(|point| !point.places.is_empty());
    let object = (!points.is_empty()).then_some(ObjectTrack { points });
    Recording::new("clip", people, object, metadata).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_is_written_reads_back_to_the_bit(
        which in 0..3_usize,
        steps in prop::collection::vec(30_000_000_i64..40_000_000, 0..12),
        coordinates in prop::collection::vec(
            prop_oneof![-1e3..1e3, -1e-9..1e-9, Just(-0.0), Just(1e3), Just(f64::MIN_POSITIVE)],
            97,
        ),
        object in prop::collection::vec(any::<bool>(), 12),
        metadata in prop::collection::btree_map(".{0,6}", ".{0,6}", 0..4),
    ) {
        let before = recording(which, &steps, &coordinates, &object, metadata);
        let text = csv::write(&before).unwrap();
        let after = read(&text).unwrap();
        prop_assert_eq!(&after, &before);
        prop_assert_eq!(csv::write(&after).unwrap(), text);
    }

    #[test]
    fn flipped_bytes_never_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let mut bytes = format!("# class=07\n{}\n", small(3).join("\n")).into_bytes();
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Err(error) = formats::read(&bytes, "clip", UpAxis::Y) {
            prop_assert!(!error.violations().is_empty());
            prop_assert!(error.violations().len() <= ReadError::MOST);
        }
    }

    #[test]
    fn any_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = csv::read(&bytes, "clip", UpAxis::Z);
        let _ = csv::metadata(&bytes);
        let _ = formats::read(&bytes, "clip", UpAxis::Z);
    }
}

#[test]
fn a_file_cut_anywhere_is_refused_except_after_a_whole_frame() {
    let text = format!("# class=07\n{}\n", small(3).join("\n"));
    for cut in 0..text.len() {
        if read(&text[..cut]).is_ok() {
            // Of a last number cut short nobody can tell.
            let line = text[..cut].lines().last().unwrap();
            assert!(line.contains("receiver,right_hand,1,0,1"), "{cut}: {line}");
        }
    }
}

#[test]
fn what_a_csv_cannot_hold_is_refused() {
    let good = recording(0, &[33_000_000], &[0.5; 97], &[true, true], BTreeMap::new());
    let with_object = |places| {
        let object = ObjectTrack::of_point("baton", places);
        Recording::new("clip", good.people().clone(), Some(object), BTreeMap::new()).unwrap()
    };
    let between = with_object(vec![(Stamp(5), Point::origin())]);
    assert_eq!(csv::write(&between), Err(WriteError::ObjectBetweenFrames { time: Stamp(5) }));
    let after = with_object(vec![(Stamp(i64::MAX), Point::origin())]);
    assert!(matches!(csv::write(&after), Err(WriteError::ObjectBetweenFrames { .. })));
    let [mut giver, receiver] = good.people().clone();
    giver.name = "object".into();
    let misnamed = Recording::new("clip", [giver, receiver], None, BTreeMap::new()).unwrap();
    assert!(matches!(csv::write(&misnamed), Err(WriteError::PersonName { .. })));
}
