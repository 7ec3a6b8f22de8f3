//! Bags: what is written reads back, what a robot recorded is two people, and what is damaged gives
//! what is whole.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

#[path = "../common/python.rs"]
mod common_python;
mod hostile;
mod live;
mod python;
mod scenes;
mod sqlite;
#[path = "../common/sqlite.rs"]
mod sqlite_bags;

use std::collections::BTreeMap;

use handover_mesh::formats::bag::{self, File, WriteError};
use handover_mesh::formats::{self, Format, UpAxis};
use handover_mesh::{ObjectTrack, Point, PointTrack, Recording, Role, Stamp};
use proptest::prelude::*;
use scenes::{people, read, recording, skeleton};

#[test]
fn a_recording_reads_back_with_all_that_is_known_of_it() {
    let metadata = [("class", "07"), ("scene", "a: \"b\"\n#"), ("", "~")];
    let metadata = metadata.map(|(key, value)| (key.to_owned(), value.to_owned()));
    let before = recording(40, metadata.into());
    let written = bag::write(&before, "clip_0.mcap").unwrap();
    let found = read(&written.mcap).unwrap();
    assert_eq!((found.recording, found.format), (before.clone(), Format::Mcap));
    assert_eq!((found.losses, found.notes), (Vec::new(), Vec::new()));
    // By its bytes alone it is known as well; and twice written it is the same.
    assert_eq!(formats::read(&written.mcap, "clip", UpAxis::Z).unwrap(), before);
    assert_eq!(bag::write(&before, "clip_0.mcap").unwrap(), written);
    assert_eq!(bag::file_names(&written.metadata).unwrap(), ["clip_0.mcap"]);
}

#[test]
fn the_order_of_people_survives_whoever_sorts_the_topics() {
    let [first, second] = people(8, ["zoe", "adam"]);
    let before = Recording::new("clip", [first, second], None, BTreeMap::new()).unwrap();
    let written = bag::write(&before, "clip_0.mcap").unwrap();
    let file = File { name: "clip_0.mcap", bytes: Some(&written.mcap) };
    let mut messages = Vec::new();
    bag::messages(&[file], |raw| {
        messages.push((
            raw.topic.to_owned(),
            raw.type_name.to_owned(),
            raw.time,
            raw.data.to_vec(),
        ));
    })
    .unwrap();
    messages.sort_by(|a, b| (&a.0, a.2).cmp(&(&b.0, b.2)));
    let sorted = scenes::bag_of(&messages);
    let found = bag::read(
        &[File { name: "sorted", bytes: Some(&sorted) }],
        Some(&written.metadata),
        "clip",
        UpAxis::Z,
    );
    assert_eq!(found.unwrap().recording, before);
}

#[test]
fn y_up_turns() {
    let written = bag::write(&recording(8, BTreeMap::new()), "clip_0.mcap").unwrap();
    let file = File { name: "clip_0.mcap", bytes: Some(&written.mcap) };
    let [up, turned] =
        [UpAxis::Z, UpAxis::Y].map(|up| bag::read(&[file], None, "clip", up).unwrap().recording);
    let place = |r: &Recording| r.person(Role::Second).motion.frames()[3].positions[4];
    let p = place(&up);
    assert_eq!(place(&turned), Point::new(p.x, -p.z, p.y));
}

#[test]
fn what_a_bag_cannot_hold_is_refused() {
    let good = recording(8, BTreeMap::new());
    let refused = |recording: &Recording| bag::write(recording, "a.mcap").unwrap_err();
    for name in ["", "the giver", "1st", "a/b", "ä"] {
        let [mut first, second] = good.people().clone();
        first.name = name.into();
        let named = Recording::new("clip", [first, second], None, BTreeMap::new()).unwrap();
        assert_eq!(refused(&named), WriteError::Name { name: name.into() });
    }
    let late = Stamp(i64::MAX);
    let object = ObjectTrack::of_point("cup", vec![(late, Point::origin())]);
    let far = Recording::new("clip", good.people().clone(), Some(object), BTreeMap::new());
    assert_eq!(refused(&far.unwrap()), WriteError::Stamp { stamp: late });
    let point = |name: &str| PointTrack { name: name.into(), places: Vec::new() };
    let object = ObjectTrack { points: vec![point("base"), point("rim")] };
    let two = Recording::new("clip", good.people().clone(), Some(object), BTreeMap::new());
    assert_eq!(refused(&two.unwrap()), WriteError::ObjectPoints { points: 2 });
    let key = "handover_mesh.people".to_owned();
    let words = good.with_metadata([(key.clone(), "[]".to_owned())].into());
    assert_eq!(refused(&words), WriteError::Metadata { key });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn what_is_written_into_a_bag_reads_back_to_the_bit(
        which in 0..3_usize,
        steps in prop::collection::vec(30_000_000_i64..40_000_000, 0..12),
        coordinates in prop::collection::vec(
            prop_oneof![-1e3..1e3, -1e-9..1e-9, Just(-0.0), Just(1e3), Just(f64::MIN_POSITIVE)],
            97,
        ),
        object in prop::collection::vec(any::<bool>(), 12),
        metadata in prop::collection::btree_map(".{0,6}", ".{0,6}", 0..4),
    ) {
        let before =
            scenes::any_recording(&skeleton(which), &steps, &coordinates, &object, metadata);
        let written = bag::write(&before, "clip_0.mcap").unwrap();
        let after = read(&written.mcap).unwrap();
        // Zeros of both signs are equal, but not the same bits.
        let bits = |r: &Recording| {
            let frames = r.people().iter().flat_map(|person| person.motion.frames());
            let points = frames.flat_map(|frame| frame.positions.to_vec());
            points.flat_map(|p| [p.x, p.y, p.z].map(f64::to_bits)).collect::<Vec<_>>()
        };
        prop_assert_eq!(bits(&after.recording), bits(&before));
        prop_assert_eq!(after.recording, before);
        prop_assert!(after.notes.is_empty() && after.losses.is_empty());
    }
}
