//! Who is left out when, what is reported of it, and what makes no cross-validation.

use std::sync::atomic::{AtomicUsize, Ordering};

use handover_mesh::evaluate::{
    MotionEvaluation, MotionEvaluationError, MotionProtocol, NamedSequence, cross_validate,
};
use handover_mesh::motion::{Dimensions, MotionError, Neighbourhood, Rows};
use serde_json::Value;

use crate::walks;

fn protocol() -> MotionProtocol {
    MotionProtocol {
        neighbourhoods: Neighbourhood::ALL.to_vec(),
        dimensions: Dimensions::Count(2),
        k: 5,
        folds: 4,
    }
}

fn named(sequences: Vec<Rows>) -> Vec<NamedSequence> {
    let name = |(at, poses)| NamedSequence { name: format!("walk {at}"), poses };
    sequences.into_iter().enumerate().map(name).collect()
}

/// Rounds in four channels, a little different each.
fn rounds(count: usize) -> Vec<NamedSequence> {
    let round = |at: usize| {
        let poses = (0..30 + at).flat_map(|k| {
            let turn = 0.3 * k as f64 + at as f64;
            let size = 1.0 + 0.03 * at as f64;
            [size * turn.cos(), size * turn.sin(), 0.1 * (2.0 * turn).cos(), 0.01 * turn.sin()]
        });
        Rows::new(4, poses.collect()).unwrap()
    };
    named((0..count).map(round).collect())
}

fn validate(sequences: &[NamedSequence], protocol: &MotionProtocol) -> MotionEvaluation {
    cross_validate(sequences, protocol, || ()).unwrap()
}

#[test]
fn five_sequences_are_dealt_into_four_folds() {
    let (sequences, done) = (rounds(5), AtomicUsize::new(0));
    let count = || {
        done.fetch_add(1, Ordering::Relaxed);
    };
    let found = cross_validate(&sequences, &protocol(), count).unwrap();
    assert_eq!((found.folds.len(), done.into_inner()), (4, 4));
    let names: Vec<Vec<&str>> = (found.folds.iter())
        .map(|fold| fold.left_out.iter().map(|left| left.name.as_str()).collect())
        .collect();
    assert_eq!(names, [vec!["walk 0", "walk 4"], vec!["walk 1"], vec!["walk 2"], vec!["walk 3"]]);
    let all: usize = sequences.iter().map(|sequence| sequence.poses.len()).sum();
    for fold in &found.folds {
        let left: usize = fold.left_out.iter().map(|left| left.frames).sum();
        assert_eq!((fold.points.len(), fold.dimensions), (all - left, 2));
        assert!(fold.explained > 0.9 && fold.explained <= 1.0);
        assert_eq!((fold.edges.len(), fold.components.len()), (3, 3));
        for left in &fold.left_out {
            assert_eq!(left.paths.len(), 3);
            for path in &left.paths {
                assert!(path.steps == left.frames - 1 && path.moving == path.steps);
                // Rounds that are 3 % apart in size; 1/D² of both sides.
                assert!(path.a < 0.3 && path.f < 0.4, "{path:?}");
            }
        }
    }
    // As many folds as there are sequences, at most.
    let many = MotionProtocol { folds: 50, ..protocol() };
    assert!(validate(&sequences, &many).folds.iter().all(|fold| fold.left_out.len() == 1));
}

#[test]
fn nobody_learns_from_who_is_left_out() {
    let mut sequences = rounds(4);
    let before = validate(&sequences, &protocol());
    // The fourth turned the other way: the folds that learn from it change, its own starts elsewhere
    // but from the same model.
    let count = sequences[3].poses.len();
    let backwards = (0..count).rev().flat_map(|row| sequences[3].poses.row(row).to_vec()).collect();
    sequences[3].poses = Rows::new(4, backwards).unwrap();
    let after = validate(&sequences, &protocol());
    let learned = |found: &MotionEvaluation| {
        let fold = &found.folds[3];
        (fold.points.len(), fold.edges.clone(), fold.components.clone(), fold.explained)
    };
    assert_eq!(learned(&before), learned(&after));
    assert_ne!(before.folds[0].left_out, after.folds[0].left_out);
}

#[test]
fn threads_change_nothing_of_made_up_motions() {
    let sequences = rounds(6);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| validate(&sequences, &protocol())).to_json().to_string()
    };
    assert_eq!(with(1), with(4));
}

#[test]
fn one_sequence_has_nobody_to_learn_from() {
    for count in [0, 1] {
        let error = cross_validate(&rounds(count), &protocol(), || ()).unwrap_err();
        assert_eq!(error, MotionEvaluationError::TooFew { sequences: count });
    }
}

#[test]
fn a_fold_without_a_model_names_who_is_left_out() {
    // Without the only one that moves in two dimensions, the others span one.
    let mut sequences = rounds(3);
    for sequence in &mut sequences[..2] {
        let flat = sequence.poses.iter().flat_map(|pose| [pose[0], 0.0, 0.0, 0.0]);
        sequence.poses = Rows::new(4, flat.collect()).unwrap();
    }
    let error = cross_validate(&sequences, &protocol(), || ()).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("without walk 2") && text.contains("span 1"), "{text}");

    // Of several folds that fail the first is named, whatever the threads do.
    let neighbourhoods = vec![Neighbourhood::Knn];
    let six = MotionProtocol { dimensions: Dimensions::Count(6), neighbourhoods, ..protocol() };
    for _ in 0..20 {
        let text = cross_validate(&rounds(6), &six, || ()).unwrap_err().to_string();
        assert!(text.contains("without walk 0, walk 4:"), "{text}");
    }

    let mut sequences = rounds(3);
    sequences[1].poses = Rows::new(4, vec![]).unwrap();
    let error = cross_validate(&sequences, &protocol(), || ()).unwrap_err();
    let left_out = "walk 1".to_owned();
    assert_eq!(error, MotionEvaluationError::Fold { left_out, error: MotionError::NoPoses });
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

#[test]
fn the_motion_json_has_the_promised_shape() {
    let columns = ["knn", "delaunay", "k_delaunay"];
    let found = validate(&rounds(5), &protocol());
    let json = found.to_json();
    assert_eq!(keys(&json), ["dims", "folds", "error_a", "error_f"]);
    assert_eq!(json["dims"], 2);
    let folds = json["folds"].as_array().unwrap();
    assert_eq!(folds.len(), 4);
    let mut errors = Vec::new();
    for fold in folds {
        let names = ["dims", "explained", "poses", "edges", "components", "sequences"];
        assert_eq!(keys(fold), names);
        assert_eq!(
            (keys(&fold["edges"]), keys(&fold["components"])),
            (columns.into(), columns.into())
        );
        for sequence in fold["sequences"].as_array().unwrap() {
            assert_eq!(
                keys(sequence),
                ["name", "frames", "error_a", "error_f", "steps", "moving", "outside"]
            );
            assert_eq!(keys(&sequence["error_a"]), columns);
            errors.push(sequence["error_a"]["delaunay"].as_f64().unwrap());
        }
    }
    errors.sort_by(f64::total_cmp);
    assert_eq!(keys(&json["error_a"]), columns);
    assert_eq!(json["error_a"]["delaunay"], errors[2], "the median of five");
    assert!(json["error_f"]["k_delaunay"].is_number());

    let share = MotionProtocol {
        dimensions: Dimensions::Share(0.9),
        neighbourhoods: vec![Neighbourhood::Knn],
        ..protocol()
    };
    let json = validate(&named(walks(3, &[40, 40, 40])), &share).to_json();
    assert_eq!(keys(&json["error_a"]), ["knn"]);
    let dims: Vec<&Value> = json["folds"].as_array().unwrap().iter().map(|f| &f["dims"]).collect();
    let same = dims.iter().all(|d| *d == dims[0]);
    assert_eq!(json["dims"], if same { dims[0].clone() } else { Value::Null });
}
