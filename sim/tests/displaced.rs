//! The protocol `displaced` on made-up handovers, where everything is known.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic as tests do")]

use std::sync::Arc;

use handover_mesh::demonstration::{Demonstration, Observation};
use handover_mesh::evaluate::{
    ChangedTrial, Condition, Direction, EvaluateSettings, Figure, Figures, MethodSummaries, Trial,
    displaced,
};
use handover_mesh::geometry::yaw_isometry;
use handover_mesh::learn::LearnSettings;
use handover_mesh::predict::{Method, PredictSettings, Predictor};
use handover_mesh::{Part, Point, Recording, Role, Side, Vector};
use handover_sim::generate;
use handover_sim::sensor::{Sensor, SensorConfig};

/// What is measured where nobody knows what a human would have done.
const MEASURED: [Figure; 5] =
    [Figure::Gap, Figure::GapAtContact, Figure::Timing, Figure::Bone, Figure::Jerk];

fn demonstration(recording: Recording) -> Arc<Demonstration> {
    Arc::new(Demonstration::new(Arc::new(recording), "giver", "torso").unwrap())
}

fn clips(count: u64) -> Vec<Arc<Demonstration>> {
    let sensor = Sensor::new(SensorConfig::ideal(30.0)).unwrap();
    let clip = |index: u64| generate(3, index, &format!("clip_{index}"), &sensor).unwrap().truth;
    (0..count).map(|index| demonstration(clip(index))).collect()
}

fn learnt(from: &[Arc<Demonstration>], smoothing: f64) -> Predictor {
    let settings = PredictSettings { smoothing, ..PredictSettings::default() };
    Predictor::fit(from.to_vec(), settings).unwrap()
}

fn get(figures: &Figures, figure: Figure) -> f64 {
    figures.get(figure).unwrap_or_else(|| panic!("{figure:?} is undefined"))
}

#[test]
fn displaced_by_nothing_the_gap_is_that_of_leave_one_out() {
    let clips = clips(6);
    let predictor = learnt(&clips[1..], 0.05);
    let trial = Trial::new(&clips[0], &predictor, None, &[]).unwrap();
    let nothing = [Condition::Displaced(Direction::Left, 0.0), Condition::Scaled(1.0)];
    for condition in nothing {
        let changed = trial.under(condition).unwrap();
        for method in Method::ALL {
            let (recorded, known) = trial.run(method).unwrap();
            let (predicted, figures) = changed.run(method).unwrap();
            let worst = recorded.iter().zip(&predicted).map(|(a, b)| (a - b).norm());
            assert!(worst.fold(0.0, f64::max) < 1e-9, "{}", method.name());
            for figure in Figure::ALL {
                if MEASURED.contains(&figure) {
                    let (a, b) = (get(&known, figure), get(&figures, figure));
                    assert!((a - b).abs() < 1e-6, "{} {figure:?}: {a}, {b}", method.name());
                } else {
                    assert_eq!(figures.get(figure), None, "no truth: {figure:?}");
                }
            }
        }
    }
}

/// A clip that learns from itself alone knows moment and gap exactly, so what is missed is the
/// displacement.
#[test]
fn attach_follows_a_displacement_and_replay_misses_by_it() {
    let clips = clips(1);
    // Who is nearer is not later: the time alignment is to look at the pose alone.
    let settings = PredictSettings { distance_weight: 0.0, smoothing: 0.0, ..Default::default() };
    let predictor = Predictor::fit(clips.clone(), settings).unwrap();
    let trial = Trial::new(&clips[0], &predictor, None, &[]).unwrap();
    let (held, _) = trial.run(Method::Hold).unwrap();
    for (direction, metres) in [
        (Direction::Up, 0.1),
        (Direction::Up, 0.2),
        (Direction::Nearer, 0.1),
        (Direction::Nearer, 0.2),
    ] {
        let changed = trial.under(Condition::Displaced(direction, metres)).unwrap();
        let missed = |method: Method| get(&changed.run(method).unwrap().1, Figure::GapAtContact);
        let replayed = missed(Method::Replay);
        // Nearer, the line between moving bases turns a little, and the replayed robot with it.
        let turned = if direction == Direction::Up { 1e-6 } else { 0.1 };
        assert!((replayed - 100.0 * metres).abs() < turned, "{direction:?} {metres}: {replayed}");
        assert_eq!(changed.run(Method::Hold).unwrap().0, held, "who looks at nobody stays");
        if direction == Direction::Nearer {
            assert!(missed(Method::Attach) < 1e-6, "{metres}: {}", missed(Method::Attach));
            assert!(missed(Method::Mesh) < 0.4 * missed(Method::None), "{metres}");
        }
    }
    // To the sides the replayed robot turns with the line between the people: it misses by less.
    for direction in [Direction::Left, Direction::Right] {
        let changed = trial.under(Condition::Displaced(direction, 0.2)).unwrap();
        let (_, figures) = changed.run(Method::Replay).unwrap();
        let missed = get(&figures, Figure::GapAtContact);
        assert!((2.0..20.0).contains(&missed), "{direction:?}: {missed}");
    }
}

#[test]
fn directions_are_those_of_a_robot_that_looks_at_its_partner() {
    let clips = clips(3);
    let predictor = learnt(&clips[1..], 0.05);
    let trial = Trial::new(&clips[0], &predictor, None, &[]).unwrap();
    let under = |direction| trial.under(Condition::Displaced(direction, 0.1)).unwrap();
    let moved = |direction| under(direction).displacement();
    assert_eq!(moved(Direction::Up), Vector::new(0.0, 0.0, 0.1));
    assert!((moved(Direction::Left) + moved(Direction::Right)).norm() < 1e-12);
    let apart = |changed: &ChangedTrial<'_>, observation: &Observation| {
        let contact = changed.scene().contact();
        (observation.partner_place(contact) - observation.base[contact]).xy()
    };
    let recorded = apart(&under(Direction::Up), &clips[0].observation());
    let nearer = under(Direction::Nearer);
    let now = apart(&nearer, nearer.scene().observation());
    assert!((recorded.norm() - now.norm() - 0.1).abs() < 1e-9, "nearer by 0.1 m");
    let left = moved(Direction::Left);
    assert!(
        left.z == 0.0 && left.xy().dot(&recorded).abs() < 1e-9 && (left.norm() - 0.1).abs() < 1e-9
    );
    assert!(recorded.perp(&left.xy()) > 0.0, "left of who looks at the partner");

    // One base above the other: the partner steps the way it faces.
    let mut stacked = clips[0].observation();
    stacked.base = (0..stacked.len()).map(|k| stacked.partner_place(k)).collect();
    let step = Condition::Displaced(Direction::Nearer, 0.2).displacement(&stacked, 5);
    let faces = stacked.partner.heading(5);
    assert!((step - 0.2 * Vector::new(faces.cos(), faces.sin(), 0.0)).norm() < 1e-9);
}

#[test]
fn a_scaled_robot_has_scaled_bones_on_the_same_floor() {
    let clips = clips(4);
    let predictor = learnt(&clips[1..], 0.0);
    let truth = &clips[0];
    let trial = Trial::new(truth, &predictor, None, &[]).unwrap();
    let hold = get(&trial.run(Method::Hold).unwrap().1, Figure::Bone);
    let skeleton = truth.robot().skeleton();
    let own = truth.robot().bone_lengths();
    for scale in [0.8, 1.2] {
        let changed = trial.under(Condition::Scaled(scale)).unwrap();
        assert_eq!(changed.displacement(), Vector::zeros());
        let (predicted, figures) = changed.run(Method::Mesh).unwrap();
        assert!(get(&figures, Figure::Bone) < 1e-6, "against the scaled bones");
        for (k, pose) in predicted.chunks_exact(skeleton.len()).enumerate() {
            for (bone, length) in skeleton.bones().zip(&own) {
                let found = (pose[bone.child.index()] - pose[bone.parent.index()]).norm();
                assert!((found - scale * length).abs() < 1e-9, "{found}, not {scale} × {length}");
            }
            let base = truth.robot().position(k, truth.robot_base());
            let expected = Vector::new(base.x, base.y, scale * base.z);
            assert!((pose[truth.robot_base().index()].coords - expected).norm() < 1e-9);
        }
        // What a pose that is kept is off by, scales with it.
        let (pose, figures) = changed.run(Method::Hold).unwrap();
        assert!((get(&figures, Figure::Bone) - scale * hold).abs() < 1e-6);
        let lowest = |pose: &[Point]| pose.iter().map(|p| p.z).fold(f64::MAX, f64::min);
        let stood = lowest(&truth.robot().frames()[0].positions);
        assert!((lowest(&pose[..skeleton.len()]) - scale * stood).abs() < 1e-9, "feet stay down");
    }
}

#[test]
fn reach_is_the_way_along_the_skeleton() {
    let clip = &clips(1)[0];
    let skeleton = clip.robot().skeleton();
    let length = |part: Part| {
        let lengths = clip.robot().bone_lengths();
        let mut bones = skeleton.bones().zip(lengths);
        bones.find(|(bone, _)| skeleton.part_of(bone.child) == Some(part)).unwrap().1
    };
    let arm = [Part::Shoulder, Part::Elbow, Part::Hand].map(|part| length(part(Side::Left)));
    let arm: f64 = arm.iter().sum();
    let hand = skeleton.part(Part::Hand(Side::Left)).unwrap();
    #[track_caller]
    fn check(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
    }
    check(clip.observation().reach(hand), length(Part::Neck) + arm);
    // From the head down to the neck and out: not by the torso.
    let from_head = Demonstration::new(clip.recording().clone(), "giver", "head").unwrap();
    check(from_head.observation().reach(hand), length(Part::Head) + arm);
    check(
        from_head.observation().with_robot_scaled(0.5).reach(hand),
        0.5 * (length(Part::Head) + arm),
    );
}

#[test]
fn out_of_reach_a_scaled_robot_has_no_figures() {
    let mut clips = clips(4);
    // Nobody's arm is as long: this partner offers from three metres farther away.
    let truth = &clips[0];
    let away = truth.observation().partner_place(0) - truth.observation().base[0];
    let away = 3.0 * Vector::new(away.x, away.y, 0.0).normalize();
    let partner = truth.partner().transformed(&yaw_isometry(0.0, away));
    clips[0] = demonstration(truth.recording().with_motion(Role::Second, partner).unwrap());
    let groups: Vec<String> = clips.iter().map(|d| d.recording().name().to_owned()).collect();
    let settings = EvaluateSettings {
        methods: vec![Method::Hold, Method::Attach],
        folds: 10,
        ignored_joints: Vec::new(),
        predict: PredictSettings::default(),
        learn: LearnSettings::default(),
        causal: None,
    };
    let found = displaced(&clips, &groups, &settings, || ()).unwrap();
    assert!(found.failures.is_empty(), "that is no failure: {:?}", found.failures);
    for clip in &found.clips {
        let scaled = matches!(clip.condition, Condition::Scaled(_));
        let undefined = scaled && clip.name == "clip_0";
        assert_eq!(clip.reachable, !undefined, "{} {}", clip.name, clip.condition.name());
        for (_, figures) in &clip.methods {
            assert_eq!(*figures == Figures::default(), undefined);
        }
    }
    let n = |methods: &MethodSummaries| methods[0].1[Figure::Gap as usize].unwrap().n;
    assert_eq!((n(&found.summary), n(&found.scaled)), (4 * 8, 3 * 2));
}

#[test]
fn turning_the_scene_changes_no_displaced_figure() {
    let clips = clips(6);
    let predictor = learnt(&clips[1..], 0.05);
    let turn = yaw_isometry(2.2, Vector::new(1.5, -0.7, 0.0));
    let turned = demonstration(clips[0].recording().transformed(&turn));
    let [here, there] = [&clips[0], &turned].map(|d| Trial::new(d, &predictor, None, &[]).unwrap());
    for condition in Condition::ALL {
        let [here, there] = [&here, &there].map(|trial| trial.under(condition).unwrap());
        let expected = turn * here.displacement();
        assert!((there.displacement() - expected).norm() < 1e-9, "{}", condition.name());
        for method in Method::ALL {
            let [a, b] = [&here, &there].map(|trial| trial.run(method).unwrap().1);
            for figure in MEASURED {
                let (a, b) = (get(&a, figure), get(&b, figure));
                let name = format!("{} {} {figure:?}", condition.name(), method.name());
                assert!((a - b).abs() < 1e-6 * a.abs().max(1.0), "{name}: {a}, {b}");
            }
        }
    }
}
