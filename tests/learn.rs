//! What learning finds: the edge that a made-up movement needs, and nothing that makes it worse.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::collections::BTreeMap;
use std::sync::Arc;

use handover_mesh::demonstration::Demonstration;
use handover_mesh::learn::{LearnError, LearnMethod, LearnSettings, Lessons, Move, Search};
use handover_mesh::mesh::{Edge, Kernel, Pair};
use handover_mesh::predict::{PredictSettings, Predictor};
use handover_mesh::retarget::{RetargetSettings, Transform};
use handover_mesh::{
    Frame, JointId, Person, Point, Recording, Role, Sequence, Skeleton, Stamp, Vector,
};

#[path = "common/standing.rs"]
mod standing;
use standing::STANDING;

const FRAMES: i64 = 20;

/// Two people face each other, their right hands a hand's breadth apart at contact: `to` the side
/// and up `[m]`. Nothing else moves, so nothing but each other's hand tells where a hand belongs.
fn meeting(name: &str, to: Vector) -> Arc<Demonstration> {
    let skeleton = Skeleton::nite();
    let person = |name: &str, sign: f64, origin: f64| {
        let frames = (0..FRAMES).map(|frame| {
            let share = (std::f64::consts::PI * frame as f64 / (FRAMES - 1) as f64).sin();
            let mut positions: Vec<Point> = STANDING
                .iter()
                .map(|p| Point::new(sign * p[0] + origin, sign * p[1], p[2]))
                .collect();
            let met = Point::new(0.5 - 0.05 * sign, 0.0, 1.2) + to;
            let (elbow, hand) = (positions[7], positions[8]);
            positions[8] = hand + (met - hand) * share;
            positions[7] = elbow + (met - hand) * (0.5 * share);
            Frame {
                stamp: Stamp::from_seconds(frame as f64 / 30.0).unwrap(),
                positions: positions.into(),
            }
        });
        let motion = Sequence::new(skeleton.clone(), frames.collect()).unwrap();
        Person { name: name.into(), motion }
    };
    let people = [person("giver", 1.0, 0.0), person("receiver", -1.0, 1.0)];
    let recording = Recording::new(name, people, None, BTreeMap::new()).unwrap();
    Arc::new(Demonstration::new(Arc::new(recording), "giver", "torso").unwrap())
}

fn hands() -> Edge {
    let pair = Pair::new([Skeleton::nite(), Skeleton::nite()]);
    let hand = Skeleton::nite().joint("right_hand").unwrap();
    Edge::new(pair.vertex(Role::First, hand), pair.vertex(Role::Second, hand))
}

fn predict(transform: Transform) -> PredictSettings {
    PredictSettings {
        // The reference must not know the gap: the edge has to bring it.
        contact_fade: 1e-3,
        smoothing: 0.0,
        kernel: Kernel::InverseDistance { scale: 30.0, power: 4.0, reference: 0.1, minimum: 0.05 },
        retarget: RetargetSettings { transform, ..RetargetSettings::default() },
        ..PredictSettings::default()
    }
}

fn lessons(predict: PredictSettings, settings: &LearnSettings) -> Lessons {
    let places = [[0.0, 0.0], [0.2, 0.1], [-0.2, 0.0], [0.1, 0.25]];
    let clips: Vec<Arc<Demonstration>> = places
        .iter()
        .enumerate()
        .map(|(at, [side, up])| meeting(&format!("clip {at}"), Vector::new(0.0, *side, *up)))
        .collect();
    let groups: Vec<String> = clips.iter().map(|c| c.recording().name().to_owned()).collect();
    let predictor = Predictor::fit(clips, predict).unwrap();
    Lessons::of(&predictor, &groups, &[], settings).unwrap()
}

fn settings(method: LearnMethod) -> LearnSettings {
    LearnSettings { method, references: 3, ..LearnSettings::default() }
}

#[test]
fn the_first_edge_grown_joins_the_hands_that_meet() {
    for transform in [Transform::None, Transform::Implicit, Transform::LocalGlobal] {
        let settings = settings(LearnMethod::Grow);
        let mut search = Search::new(lessons(predict(transform), &settings), settings).unwrap();
        let first = search.step(|| ()).unwrap().unwrap();
        assert_eq!(first.change, Move::Add(hands()), "{transform:?}");
        assert!(first.distance < 0.85 * search.initial(), "{transform:?}: {first:?}");
        // The reference held out, of a place that no lesson shows, gains as well.
        let untrained = lessons(predict(transform), search.settings()).held_out_distance();
        let trained = search.lessons().held_out_distance().unwrap().unwrap();
        assert!(trained < 0.9 * untrained.unwrap().unwrap(), "{transform:?}");
    }
}

#[test]
fn every_method_ends_nearer_than_it_starts_and_falls_at_every_step() {
    let mut ends = Vec::new();
    for method in [LearnMethod::Grow, LearnMethod::Prune, LearnMethod::GrowPrune] {
        let settings = settings(method);
        let lessons = lessons(predict(Transform::None), &settings);
        let mut search = Search::new(lessons, settings.clone()).unwrap();
        let mut last = search.initial();
        while let Some(step) = search.step(|| ()).unwrap() {
            let adds = matches!(step.change, Move::Add(_));
            assert!(method != LearnMethod::Grow || adds);
            assert!(method != LearnMethod::Prune || !adds);
            assert!((step.before - last).abs() < 1e-9 * last);
            assert!(step.distance < (1.0 - settings.tolerance) * step.before, "{step:?}");
            last = step.distance;
        }
        // Pruning may find nothing to take away; the others have an edge to find.
        assert!(last < search.initial() || method == LearnMethod::Prune, "{method:?}");
        let edges = search.edges().unwrap();
        let joined = edges.edges().iter().any(|learned| learned.edge == hands());
        assert!(joined || method == LearnMethod::Prune, "{method:?}");
        ends.push(last);
    }
    // What grow_prune may do besides growing it does only where it gains.
    assert!(ends[2] <= ends[0] * (1.0 + 1e-9));
}

/// The gradient finds the hands, and few edges besides.
fn check_gradient(transform: Transform, phases: usize, steps: usize, most: f64) {
    let settings = LearnSettings { phases, steps, ..settings(LearnMethod::Gradient) };
    let lessons = lessons(predict(transform), &settings);
    let mut search = Search::new(lessons, settings).unwrap();
    search.run().unwrap();
    let edges = search.edges().unwrap();
    assert_eq!(edges.phases(), phases);
    let hand = edges.edges().iter().find(|learned| learned.edge == hands()).unwrap();
    assert!(hand.factors.iter().any(|factor| *factor > 0.1), "{hand:?}");
    assert!(edges.edges().len() < 60, "{}", edges.edges().len());
    let trained = search.lessons().distance().unwrap();
    assert!(trained < most * search.initial(), "{trained}");
}

#[test]
fn the_gradient_finds_the_hands() {
    check_gradient(Transform::None, 1, 40, 0.7);
}

#[test]
fn the_gradient_finds_the_hands_phase_by_phase() {
    check_gradient(Transform::None, 3, 40, 0.7);
}

#[test]
fn the_gradient_finds_the_hands_through_turning_neighbourhoods() {
    check_gradient(Transform::Implicit, 1, 7, 1.0);
}

#[test]
fn a_joint_that_is_ignored_changes_no_distance() {
    let settings = settings(LearnMethod::None);
    let of = |ignored: &[JointId]| {
        let clips =
            vec![meeting("one", Vector::zeros()), meeting("two", Vector::new(0.0, 0.2, 0.1))];
        let groups = ["one", "two"].map(String::from);
        let predictor = Predictor::fit(clips, predict(Transform::None)).unwrap();
        let lessons = Lessons::of(&predictor, &groups, ignored, &settings).unwrap();
        lessons.distance().unwrap()
    };
    let skeleton = Skeleton::nite();
    let moving = ["right_elbow", "right_hand"].map(|name| skeleton.joint(name).unwrap());
    assert!(of(&[]) > 1.0);
    assert!(of(&moving) < 0.2 * of(&[]), "{} {}", of(&moving), of(&[]));
}

#[test]
fn one_group_teaches_nothing() {
    let clips = vec![meeting("one", Vector::zeros()), meeting("two", Vector::zeros())];
    let predictor = Predictor::fit(clips, predict(Transform::None)).unwrap();
    let same = ["scene", "scene"].map(String::from);
    let found = Lessons::of(&predictor, &same, &[], &settings(LearnMethod::Grow));
    assert!(matches!(found, Err(LearnError::NoLessons)));
}

#[test]
fn local_global_has_no_gradient_and_says_so() {
    let settings = settings(LearnMethod::Gradient);
    let lessons = lessons(predict(Transform::LocalGlobal), &settings);
    let error = Search::new(lessons, settings).unwrap_err().to_string();
    assert!(error.contains("retarget.transform is local_global"), "{error}");
}
