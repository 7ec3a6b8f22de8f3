//! Model files: what is written reads back to the bit, also through Python, and what is no model is
//! refused by name.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

mod cli;
#[path = "../common/mod.rs"]
mod common;
#[path = "../common/python.rs"]
mod common_python;
mod files;
mod hostile;
mod memory;
mod parts;
mod python;

use std::collections::BTreeMap;

use handover_mesh::demonstration::Hands;
use handover_mesh::model::{Model, ModelError, Training};
use handover_mesh::predict::{EdgesError, LearnedEdges};
use handover_mesh::retarget::Start;
use handover_mesh::{Config, Side, Skeleton};
use proptest::prelude::*;

use parts::{
    Parts, edges_between, hash, model_parts, motion, parts, person, recording, skeleton, source,
};

#[track_caller]
fn check_same(read: &Model, model: &Model) {
    for (read, model) in read.demonstrations().iter().zip(model.demonstrations()) {
        assert_eq!(read.recording(), model.recording());
        assert_eq!(read.robot_role(), model.robot_role());
        assert_eq!(read.robot_base(), model.robot_base());
        // Zeros are equal whatever their sign; bits are not.
        let bits = |d: &handover_mesh::demonstration::Demonstration| {
            let frames = d.robot().frames().iter().chain(d.partner().frames());
            let points = frames.flat_map(|frame| frame.positions.to_vec());
            points.flat_map(|p| [p.x, p.y, p.z].map(f64::to_bits)).collect::<Vec<_>>()
        };
        assert_eq!(bits(read), bits(model));
    }
    assert_eq!(read.demonstrations().len(), model.demonstrations().len());
    assert_eq!(read.hashes(), model.hashes());
    assert_eq!(read.people(), model.people());
    assert_eq!(read.pair(), model.pair());
    assert_eq!(read.edges(), model.edges());
    assert_eq!(read.config(), model.config());
    assert_eq!(read.training(), model.training());
    assert_eq!(read.program_version(), model.program_version());
    assert_eq!(read.to_bytes(), model.to_bytes());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    #[test]
    fn any_model_reads_back_to_the_bit(parts in model_parts()) {
        let model = parts.model().unwrap();
        let bytes = model.to_bytes();
        prop_assert_eq!(&bytes, &model.clone().to_bytes());
        check_same(&Model::from_bytes(&bytes).unwrap(), &model);
    }
}

#[test]
fn the_same_model_has_the_same_bytes_with_sorted_keys() {
    let bytes = parts().model().unwrap().to_bytes();
    for _ in 0..20 {
        assert_eq!(bytes, parts().model().unwrap().to_bytes());
    }
    let file = files::File::of(&bytes);
    check_sorted(&file.header);
    check_sorted(&file.model());
    assert_eq!((bytes.len() - file.data.len()) % 8, 0, "numbers are aligned");
}

fn check_sorted(value: &serde_json::Value) {
    if let Some(object) = value.as_object() {
        assert!(object.keys().is_sorted(), "{:?}", object.keys().collect::<Vec<_>>());
    }
    let below = value.as_object().into_iter().flat_map(|object| object.values());
    below.chain(value.as_array().into_iter().flatten()).for_each(check_sorted);
}

#[test]
fn objects_are_not_kept() {
    let mut parts = parts();
    parts.sources[0].recording = recording("with", 0, true);
    let model = parts.model().unwrap();
    assert_eq!(model.demonstrations()[0].recording().object(), None);
    check_same(&Model::from_bytes(&model.to_bytes()).unwrap(), &model);
}

#[test]
fn a_uniform_kernel_and_no_edge_read_back() {
    let mut parts = parts();
    parts.edges = LearnedEdges::none(Hands { robot: Side::Left, partner: Side::Right });
    parts.config.predict.kernel = handover_mesh::mesh::Kernel::Uniform;
    parts.training.held_out_distance = None;
    let model = parts.model().unwrap();
    check_same(&Model::from_bytes(&model.to_bytes()).unwrap(), &model);
}

#[track_caller]
fn check_refused(change: impl FnOnce(&mut Parts), expected: &str) {
    let mut parts = parts();
    change(&mut parts);
    assert_eq!(parts.model().unwrap_err().to_string(), expected);
}

#[test]
fn parts_that_make_no_model_are_refused() {
    check_refused(|p| p.sources.clear(), "no demonstrations; a model has at least one");
    let names = "demonstration 0: first: no person 'guest', only 'giver' and 'receiver'";
    check_refused(|p| p.role = "guest".into(), names);
    let swapped = "demonstration 1 ('second'): person 'receiver' stands where the first \
        demonstration has 'giver', or has other joints; a model is of one pair";
    let swap = |p: &mut Parts| {
        let mut people = p.sources[1].recording.people().clone();
        people.swap(0, 1);
        p.sources[1] = source("second", people);
    };
    check_refused(swap, swapped);
    let joints = "demonstration 1 ('second'): person 'receiver' stands where the first \
        demonstration has 'receiver', or has other joints; a model is of one pair";
    let other = |p: &mut Parts| {
        let giver = p.sources[1].recording.people()[0].clone();
        let receiver = person("receiver", motion(skeleton(1), giver.motion.len(), 0.0));
        p.sources[1] = source("second", [giver, receiver]);
    };
    check_refused(other, joints);
    let hash = "demonstration 1: sha256 is '0A', must be 64 digits 0-9 and a-f";
    check_refused(|p| p.sources[1].sha256 = "0A".into(), hash);
    let capitals = "A".repeat(64);
    let expected = format!("demonstration 0: sha256 is '{}…', must be", &capitals[..60]);
    let mut with_capitals = parts();
    with_capitals.sources[0].sha256 = capitals;
    assert!(with_capitals.model().unwrap_err().to_string().starts_with(&expected));
    let far = "demonstration 1, frame 0, 'head' of 'giver': 1500.0 m is farther than 1000 m";
    let move_far = |p: &mut Parts| {
        let mut people = p.sources[1].recording.people().clone();
        people[0].motion = motion(Skeleton::nite(), people[0].motion.len(), 1500.0);
        p.sources[1] = source("second", people);
    };
    check_refused(move_far, far);
}

#[test]
fn learning_and_parameters_are_checked() {
    let set = |change: fn(&mut Training)| move |p: &mut Parts| change(&mut p.training);
    let text = "final_distance is NaN m, must be finite and >= 0";
    check_refused(set(|t| t.final_distance = f64::NAN), text);
    let text = "held_out_distance is -1.0 m, must be finite and >= 0";
    check_refused(set(|t| t.held_out_distance = Some(-1.0)), text);
    let text = "method 'a\\nb' must have 1 to 1024 bytes and no control characters";
    check_refused(set(|t| t.method = "a\nb".into()), text);
    let text = "method '' must have 1 to 1024 bytes and no control characters";
    check_refused(set(|t| t.method.clear()), text);
    let text = "parameters: mesh.time_weight is -1.0, must be a number from 0 to 1000\n\
        evaluate.folds is 0, must be a whole number from 2 to 1000";
    let wrong = |p: &mut Parts| {
        p.config.folds = 0;
        p.config.predict.time_weight = -1.0;
    };
    check_refused(wrong, text);
    let text = "the settings hold something that no parameter says, and so cannot be written";
    check_refused(|p| p.config.predict.retarget.start = Start::Aligned, text);
    let long = |p: &mut Parts| p.config.ignored_joints = vec!["x".repeat(100); 1000];
    let mut parts = parts();
    long(&mut parts);
    assert!(matches!(parts.model(), Err(ModelError::ConfigTooLong { .. })));
}

#[test]
fn a_header_that_could_not_be_read_is_not_written() {
    let mut parts = parts();
    let words = BTreeMap::from([("words".to_owned(), "x".repeat(Model::MOST_HEADER))]);
    let recording = parts.sources[0].recording.as_ref().clone().with_metadata(words);
    parts.sources[0].recording = recording.into();
    assert!(matches!(parts.model(), Err(ModelError::HeaderTooLarge { .. })));
}

#[test]
fn edges_of_other_people_are_refused() {
    let mut parts = parts();
    // Joint 29 of two NiTE skeletons; these have 8 + 8.
    parts.edges = edges_between(&[(0, 29)], 1);
    let people = |x: f64| ["giver", "receiver"].map(|name| person(name, motion(skeleton(1), 3, x)));
    parts.sources = vec![source("small", people(0.1))];
    let error = parts.model().unwrap_err();
    let expected = EdgesError::NotInterperson { a: 0, b: 29, vertices: 16 };
    assert_eq!(error, ModelError::Edges(expected));
    // Two skeletons without a left hand, and edges named for one.
    let names = ["torso", "right_hand"].map(String::from).to_vec();
    let one_hand = std::sync::Arc::new(Skeleton::from_names(names).unwrap());
    let people = ["giver", "receiver"].map(|n| person(n, motion(one_hand.clone(), 3, 0.0)));
    parts.sources = vec![source("one", people)];
    parts.edges = LearnedEdges::none(Hands { robot: Side::Left, partner: Side::Right });
    let text = "the edges are named for the left hand of 'giver', who has none";
    assert_eq!(parts.model().unwrap_err().to_string(), text);
}

#[test]
fn what_a_model_holds_is_told() {
    let model = parts().model().unwrap();
    assert_eq!(model.people(), ["giver", "receiver"]);
    assert_eq!((model.base_joint(), model.program_version()), ("torso", env!("CARGO_PKG_VERSION")));
    assert_eq!(model.hashes(), [hash(), hash()]);
    assert_eq!(model.config(), &Config { folds: 7, ..Config::default() });
}
