//! Sequences and recordings: refused where they are made, and changed only as promised.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::collections::BTreeMap;

use handover_mesh::geometry::{yaw_alignment, yaw_isometry};
use handover_mesh::{
    Frame, ObjectTrack, Part, Person, Point, PointTrack, Recording, RecordingError, Role, Sequence,
    SequenceError, Side, Skeleton, Stamp, Vector,
};
use proptest::prelude::*;

const STEP: i64 = 33_333_333;

/// An upright person facing x who reaches out with the right hand.
fn person(frames: usize) -> Sequence {
    let skeleton = Skeleton::nite();
    let frame = |k: usize| {
        let reach = (0.1 * k as f64).sin();
        let place = |joint: handover_mesh::JointId| match skeleton.part_of(joint).unwrap() {
            Part::Head => Point::new(0.0, 0.0, 1.65),
            Part::Neck => Point::new(0.0, 0.0, 1.45),
            Part::Shoulder(side) | Part::Elbow(side) => Point::new(0.05, left(side) * 0.2, 1.3),
            Part::Hand(Side::Right) => Point::new(0.1 + 0.4 * reach, -0.2, 1.0 + 0.2 * reach),
            Part::Hand(Side::Left) => Point::new(0.1, 0.22, 0.9),
            Part::Hip(side) | Part::Knee(side) => Point::new(0.0, left(side) * 0.1, 0.6),
            Part::Foot(side) => Point::new(0.0, left(side) * 0.12, 0.08),
            _ => Point::new(0.0, 0.0, 1.1),
        };
        let positions = skeleton.joints().map(place).collect();
        Frame { stamp: Stamp(k as i64 * STEP), positions }
    };
    Sequence::new(skeleton.clone(), (0..frames).map(frame).collect()).unwrap()
}

fn left(side: Side) -> f64 {
    if side == Side::Left { 1.0 } else { -1.0 }
}

fn named(name: &str, motion: Sequence) -> Person {
    Person { name: name.to_owned(), motion }
}

fn recording(
    first: Sequence,
    second: Sequence,
    object: Option<ObjectTrack>,
) -> Result<Recording, RecordingError> {
    let people = [named("giver", first), named("receiver", second)];
    Recording::new("clip", people, object, BTreeMap::new())
}

fn farthest(a: &Sequence, b: &Sequence) -> f64 {
    let frames = a.frames().iter().zip(b.frames());
    let pairs = frames.flat_map(|(a, b)| a.positions.iter().zip(&b.positions));
    pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

#[test]
fn what_is_no_sequence_is_refused_with_its_place() {
    let skeleton = Skeleton::nite();
    let new = |change: &dyn Fn(&mut Vec<Frame>)| {
        let mut frames = person(5).frames().to_vec();
        change(&mut frames);
        Sequence::new(skeleton.clone(), frames).unwrap_err()
    };
    assert_eq!(new(&|frames| frames.clear()), SequenceError::Empty);
    let short = new(&|frames| frames[2].positions = vec![Point::origin(); 14].into());
    assert_eq!(short, SequenceError::JointCount { frame: 2, expected: 15, got: 14 });
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = new(&|frames| frames[3].positions[8].y = bad);
        assert_eq!(error, SequenceError::NotFinite { frame: 3, joint: "right_hand".into() });
    }
    for stamp in [Stamp(0), Stamp(-1)] {
        let error = new(&|frames| frames[1].stamp = stamp).to_string();
        assert!(error.contains("frame 1") && error.contains("not after"), "{error}");
    }
}

#[test]
fn what_is_no_recording_is_refused() {
    let twin = Recording::new(
        "clip",
        [named("A", person(3)), named("A", person(3))],
        None,
        BTreeMap::new(),
    );
    assert_eq!(twin.unwrap_err(), RecordingError::SameName { name: "A".into() });
    let error = recording(person(3), person(4), None).unwrap_err();
    assert_eq!(error, RecordingError::FrameCount { first: 3, second: 4 });
    let late: Vec<Stamp> = [0, STEP, 2 * STEP + 1].map(Stamp).to_vec();
    let error = recording(person(3), person(3).resampled(&late).unwrap(), None).unwrap_err();
    assert!(matches!(error, RecordingError::StampsDiffer { frame: 2, .. }), "{error}");
    let track = |places: Vec<(Stamp, Point)>| Some(ObjectTrack::of_point("cup", places));
    let still = track(vec![(Stamp(0), Point::origin()); 2]);
    let error = recording(person(3), person(3), still).unwrap_err();
    assert!(matches!(error, RecordingError::ObjectStamps(_)), "{error}");
    let nowhere = track(vec![(Stamp(0), Point::new(0.0, f64::NAN, 0.0))]);
    let error = recording(person(3), person(3), nowhere).unwrap_err();
    assert_eq!(error, RecordingError::ObjectNotFinite { place: 0 });
    let points = |names: &[&str]| {
        let point = |name: &&str| PointTrack { name: (*name).to_owned(), places: Vec::new() };
        Some(ObjectTrack { points: names.iter().map(point).collect() })
    };
    let error = recording(person(3), person(3), points(&[])).unwrap_err();
    assert_eq!(error, RecordingError::ObjectWithoutPoints);
    let error = recording(person(3), person(3), points(&["rim", "base", "rim"])).unwrap_err();
    assert_eq!(error, RecordingError::SamePoint { name: "rim".into() });
    let sorted = recording(person(3), person(3), points(&["rim", "base"])).unwrap();
    assert_eq!(sorted.object().unwrap().points[0].name, "base");
}

#[test]
fn a_mirrored_right_hander_is_a_left_hander_and_twice_is_never() {
    let person = person(20);
    let image = person.mirrored();
    let [left, right] = Side::BOTH.map(|side| person.skeleton().part(Part::Hand(side)).unwrap());
    for k in 0..20 {
        let (hand, seen) = (person.position(k, right), image.position(k, left));
        assert_eq!([seen.x, seen.y, seen.z], [hand.x, -hand.y, hand.z]);
        assert!(image.heading(k).abs() < 1e-12, "the image faces where the person faces");
    }
    assert_eq!(image.mirrored(), person);

    let places = vec![(Stamp(0), Point::new(0.5, 0.2, 1.0))];
    let cup = Some(ObjectTrack::of_point("cup", places));
    let both = recording(person.clone(), person, cup).unwrap();
    assert_eq!(both.mirrored().object().unwrap().points[0].places[0].1, Point::new(0.5, -0.2, 1.0));
    assert_eq!(both.mirrored().mirrored(), both);
}

proptest! {
    #[test]
    fn resampling_is_exact_on_straight_paths_and_holds_beyond_them(
        stamps in prop::collection::btree_set(-STEP..12 * STEP, 1..20),
        velocity in prop::array::uniform3(-2.0f64..2.0),
    ) {
        let velocity = Vector::from(velocity);
        let at = |seconds: f64| vec![Point::from(velocity * seconds); 15].into();
        let frame = |k: i64| Frame { stamp: Stamp(k * STEP), positions: at(Stamp(k * STEP).seconds()) };
        let line = Sequence::new(Skeleton::nite(), (0..10).map(frame).collect()).unwrap();
        let stamps: Vec<Stamp> = stamps.into_iter().map(Stamp).collect();
        let resampled = line.resampled(&stamps).unwrap();
        prop_assert!(resampled.stamps().eq(stamps.iter().copied()));
        let last = Stamp(9 * STEP).seconds();
        for frame in resampled.frames() {
            let expected = velocity * frame.stamp.seconds().clamp(0.0, last);
            prop_assert!((frame.positions[7].coords - expected).norm() < 1e-9);
        }
        // On its own stamps nothing changes.
        let own: Vec<Stamp> = line.stamps().collect();
        prop_assert_eq!(line.resampled(&own).unwrap(), line);
    }

    #[test]
    fn a_yaw_alignment_undoes_any_placing_on_the_floor(
        yaw in -3.1f64..3.1,
        shift in prop::array::uniform3(-5.0f64..5.0),
    ) {
        let person = person(6);
        let there = person.transformed(&yaw_isometry(yaw, Vector::from(shift)));
        let frames = |s: &Sequence| s.frames().iter().flat_map(|f| f.positions.to_vec()).collect::<Vec<_>>();
        let (a, b) = (frames(&there), frames(&person));
        let back = there.transformed(&yaw_alignment(a.iter().zip(&b)));
        prop_assert!(farthest(&back, &person) < 1e-9);
        let turned = (there.heading(0) - person.heading(0) - yaw).rem_euclid(std::f64::consts::TAU);
        prop_assert!(turned.min(std::f64::consts::TAU - turned) < 1e-9);
        // Bones and gaps are the same from anywhere.
        let lengths = there.bone_lengths().into_iter().zip(person.bone_lengths());
        prop_assert!(lengths.into_iter().all(|(a, b)| (a - b).abs() < 1e-9));
        let both = recording(person.clone(), person, None).unwrap();
        let moved = both.transformed(&yaw_isometry(yaw, Vector::from(shift)));
        prop_assert!(farthest(&moved.person(Role::Second).motion, &there) < 1e-12);
    }
}
