//! The library's predictions and figures on made-up handovers, where everything is known.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic as tests do")]

use std::sync::Arc;

use handover_mesh::demonstration::{Demonstration, with_object_carried};
use handover_mesh::evaluate::{EvaluateSettings, Figure, Figures, Trial, leave_one_out};
use handover_mesh::learn::{LearnSettings, Lessons};
use handover_mesh::mesh::{Edge, InitialEdges};
use handover_mesh::predict::{Method, PredictSettings, Predictor};
use handover_mesh::{Frame, Part, Point, Recording, Role, Sequence, Side, Vector};
use handover_sim::generate;
use handover_sim::sensor::{Sensor, SensorConfig};

fn clips(count: u64) -> Vec<Arc<Demonstration>> {
    let sensor = Sensor::new(SensorConfig::ideal(30.0)).unwrap();
    let clip = |index: u64| {
        let name = format!("clip_{index}");
        let recording = generate(3, index, &name, &sensor).unwrap().truth;
        demonstration(recording, "giver")
    };
    (0..count).map(clip).collect()
}

fn demonstration(recording: Recording, role: &str) -> Arc<Demonstration> {
    Arc::new(Demonstration::new(Arc::new(recording), role, "torso").unwrap())
}

fn poses(motion: &Sequence) -> Vec<Point> {
    motion.frames().iter().flat_map(|frame| frame.positions.iter().copied()).collect()
}

#[test]
fn figures_measure_what_they_say() {
    let clips = clips(6);
    let settings = PredictSettings { smoothing: 0.0, ..PredictSettings::default() };
    let predictor = Predictor::fit(clips[1..].to_vec(), settings).unwrap();
    let truth = &clips[0];
    let trial = Trial::new(truth, &predictor, None, &[]).unwrap();
    let did = poses(truth.robot());
    #[track_caller]
    fn check(figures: &Figures, figure: Figure, expected: f64) {
        let found = figures.get(figure).unwrap();
        assert!((found - expected).abs() < 1e-6, "{figure:?}: {found}, not {expected}");
    }
    for figure in [Figure::Joint, Figure::Hand, Figure::Contact, Figure::Bone] {
        check(&trial.figures(&did), figure, 0.0);
    }
    // All joints 3 cm aside, the known base too: it must not count, and no bone changes.
    let aside: Vec<Point> = did.iter().map(|p| p + Vector::new(0.0, 0.03, 0.0)).collect();
    let figures = trial.figures(&aside);
    for figure in [Figure::Joint, Figure::Hand, Figure::Contact] {
        check(&figures, figure, 3.0);
    }
    check(&figures, Figure::Bone, 0.0);
    // One forearm longer by 2 cm in one frame: the hand is off there, and the bone.
    let hands = truth.robot().skeleton();
    let [hand, elbow] =
        [Part::Hand(Side::Right), Part::Elbow(Side::Right)].map(|part| hands.part(part).unwrap());
    let mut longer = did.clone();
    let frame = 7 * hands.len();
    let along = (did[frame + hand.index()] - did[frame + elbow.index()]).normalize();
    longer[frame + hand.index()] += 0.02 * along;
    check(&trial.figures(&longer), Figure::Bone, 20.0);
    // An ignored joint counts no more.
    let head = hands.joint("head").unwrap();
    let mut nodding = did.clone();
    nodding.iter_mut().skip(head.index()).step_by(hands.len()).for_each(|p| p.z += 0.5);
    assert!(trial.figures(&nodding).get(Figure::Joint).unwrap() > 1.0);
    let blind = Trial::new(truth, &predictor, None, &["head".to_owned()]).unwrap();
    check(&blind.figures(&nodding), Figure::Joint, 0.0);
    assert!(Trial::new(truth, &predictor, None, &["tail".to_owned()]).is_err());
}

/// What a method predicts does not change with what the person in the robot's role did, as long
/// as its base, its bones and its first pose are the same.
#[test]
fn no_method_sees_the_robots_truth() {
    let clips = clips(8);
    let settings = PredictSettings { smoothing: 0.0, ..PredictSettings::default() };
    let predictor = Predictor::fit(clips[1..].to_vec(), settings).unwrap();
    let truth = &clips[0];
    // A robot that stands still on its moving base.
    let base = truth.robot_base();
    let robot = truth.robot();
    let start = &robot.frames()[0];
    let frames = robot.frames().iter().map(|frame| {
        let shift = frame.positions[base.index()] - start.positions[base.index()];
        let mut positions: Box<[Point]> = start.positions.iter().map(|p| p + shift).collect();
        // Exactly, not up to rounding.
        positions[base.index()] = frame.positions[base.index()];
        Frame { stamp: frame.stamp, positions }
    });
    let still = Sequence::new(robot.skeleton().clone(), frames.collect()).unwrap();
    let idle = demonstration(truth.recording().with_motion(Role::First, still).unwrap(), "giver");
    assert!((idle.contact().distance - truth.contact().distance).abs() > 0.1, "truth did change");

    check_alike(&predictor, truth, &idle);
}

/// That no method tells an interaction from one in which the robot's role did something else.
#[track_caller]
fn check_alike(predictor: &Predictor, truth: &Demonstration, other: &Demonstration) {
    let bones = truth.robot().bone_lengths();
    let [mut with, mut without] = [truth, other].map(|d| predictor.observe(d));
    // Medians of constant bones differ by rounding.
    (with.bone_lengths, without.bone_lengths) = (bones.clone(), bones);
    let [seen, unseen] = [&with, &without].map(|o| predictor.align(o).unwrap());
    for method in Method::ALL {
        let a = predictor.predict(method, &with, &seen).unwrap();
        let b = predictor.predict(method, &without, &unseen).unwrap();
        assert_eq!(a, b, "{}", method.name());
    }
}

/// Handovers of right-handed givers with the object in the mesh: bare, and as demonstrations.
fn carried(count: usize) -> Vec<(Recording, Arc<Demonstration>)> {
    let sensor = Sensor::new(SensorConfig::ideal(30.0)).unwrap();
    let made = (0..).map(|index| {
        let bare = generate(3, index, &format!("clip_{index}"), &sensor).unwrap().truth;
        let carried = with_object_carried(&bare, 16).unwrap();
        (bare, demonstration(carried, "giver"))
    });
    let right = |(_, demonstration): &(_, Arc<Demonstration>)| {
        let skeleton = demonstration.robot().skeleton();
        let bone = skeleton.bones().last().unwrap();
        skeleton.name(bone.child) == "object" && skeleton.name(bone.parent) == "right_hand"
    };
    made.filter(right).take(count).collect()
}

/// Nor does it with the object in the mesh, wherever the object goes once it has been looked at
/// how it is held.
#[test]
fn no_method_sees_where_the_object_goes() {
    let clips = carried(6);
    let settings = PredictSettings { smoothing: 0.0, ..PredictSettings::default() };
    let known = clips[1..].iter().map(|(_, known)| known.clone()).collect();
    let predictor = Predictor::fit(known, settings).unwrap();
    let (made, truth) = &clips[0];
    // From the moment at which the hands meet, the object stays; the giver's motion is another
    // from the first half second on.
    let contact = truth.contact().frame;
    let mut object = made.object().unwrap().clone();
    for place in &mut object.points[0].places[contact..] {
        place.1 += Vector::new(0.3, -0.2, 0.5);
    }
    let people = made.people().clone();
    let other = Recording::new("other", people, Some(object), Default::default()).unwrap();
    let other = with_object_carried(&other, 16).unwrap();
    assert_eq!(other.people(), truth.recording().people(), "the rest of its way is not looked at");

    let giver = truth.robot();
    let own = giver.skeleton().own();
    assert_eq!((own, giver.skeleton().len()), (15, 16));
    let start = giver.frames()[20].positions.clone();
    let base = truth.robot_base();
    let frames = made.person(Role::First).motion.frames().iter().enumerate().map(|(at, frame)| {
        let mut positions = frame.positions.clone();
        if at > 20 {
            let shift = frame.positions[base.index()] - start[base.index()];
            positions.iter_mut().zip(&start).for_each(|(p, from)| *p = from + shift);
            positions[base.index()] = frame.positions[base.index()];
        }
        Frame { stamp: frame.stamp, positions }
    });
    let bare = made.person(Role::First).motion.skeleton().clone();
    let still = Sequence::new(bare, frames.collect()).unwrap();
    let hand = giver.skeleton().part(Part::Hand(truth.contact().hands.robot)).unwrap();
    let cup = giver.skeleton().attached().next().unwrap();
    let points = [("object".to_owned(), giver.position(0, cup))];
    let still = still.with_attached(hand, 0, &points).unwrap();
    let idle = demonstration(truth.recording().with_motion(Role::First, still).unwrap(), "giver");
    check_alike(&predictor, truth, &idle);
}

/// What rides on a hand changes nothing that methods without a mesh say of the people, nor what any
/// figure counts; the mesh has it.
#[test]
fn figures_count_people_only() {
    let (bare, carried): (Vec<_>, Vec<_>) = carried(6).into_iter().unzip();
    let bare: Vec<_> = bare.into_iter().map(|bare| demonstration(bare, "giver")).collect();
    let [a, b] = [&bare, &carried].map(|clips| {
        let settings = PredictSettings::default();
        Predictor::fit(clips[1..].to_vec(), settings).unwrap()
    });
    let [of_a, of_b] = [(&bare[0], &a), (&carried[0], &b)]
        .map(|(truth, predictor)| Trial::new(truth, predictor, None, &[]).unwrap());
    for method in Method::ALL.into_iter().filter(|method| *method != Method::Mesh) {
        let [(said, figures), (more, others)] = [&of_a, &of_b].map(|t| t.run(method).unwrap());
        if method != Method::None {
            let own = more.chunks_exact(16).flat_map(|pose| &pose[..15]);
            assert!(said.iter().eq(own), "{}", method.name());
            assert_eq!(figures, others, "{}", method.name());
        }
        // The object elsewhere is no error of the person's.
        let mut off = more.clone();
        off.chunks_exact_mut(16).for_each(|pose| pose[15] += Vector::new(1.0, 2.0, 3.0));
        assert_eq!(of_b.figures(&off), others, "{}", method.name());
    }
    let observation = b.observe(&carried[0]);
    let problem = b.problem(&observation, &b.align(&observation).unwrap());
    let topology = problem.topology(InitialEdges::BothPeople).unwrap();
    let pair = problem.pair();
    let object = pair.vertices(Role::First).nth(15).unwrap();
    assert_eq!(pair.name(object, ["giver", "receiver"]), "giver/object");
    assert!(topology.neighbours(object.index()).len() > 3, "more than its bone");
    // What is learned may end at it.
    let groups: Vec<String> = (0..5).map(|group| group.to_string()).collect();
    let settings = LearnSettings { references: 1, ..LearnSettings::default() };
    let lessons = Lessons::of(&b, &groups, &[], &settings).unwrap();
    let hand = pair.vertices(Role::Second).nth(8).unwrap();
    assert_eq!(lessons.candidates().len(), 16 * 15);
    assert!(lessons.candidates().contains(&Edge::new(object, hand)));
}

#[test]
fn the_mesh_meets_hands_and_keeps_bones() {
    // More than twenty are dealt into folds: learning once for each clip would take minutes.
    let clips = clips(21);
    let groups: Vec<String> = (0..21).map(|i| format!("{i:02}")).collect();
    let settings = EvaluateSettings {
        methods: Method::ALL.to_vec(),
        folds: 3,
        ignored_joints: Vec::new(),
        predict: PredictSettings::default(),
        learn: LearnSettings { references: 3, steps: 2, ..LearnSettings::default() },
        causal: None,
    };
    let evaluation = leave_one_out(&clips, &groups, &settings, || ()).unwrap();
    let median = |method: Method, figure: Figure| {
        let (_, summaries) = evaluation.summary.iter().find(|(m, _)| *m == method).unwrap();
        summaries[figure as usize].unwrap().median
    };
    for figure in [Figure::Contact, Figure::Gap] {
        let ours = median(Method::Mesh, figure);
        for other in [Method::Hold, Method::Replay, Method::Knn, Method::None] {
            assert!(ours < median(other, figure), "{figure:?}: {}", other.name());
        }
    }
    assert!(median(Method::Mesh, Figure::Bone) < 1e-6, "bones are exact");
    assert!(median(Method::Knn, Figure::Bone) > 5.0, "and a mean's are not");
}

#[test]
fn one_group_has_nobody_to_learn_from() {
    let clips = clips(3);
    let settings = EvaluateSettings {
        methods: vec![Method::Hold],
        folds: 10,
        ignored_joints: Vec::new(),
        predict: PredictSettings::default(),
        learn: LearnSettings::default(),
        causal: None,
    };
    let groups = vec!["same".to_owned(); 3];
    let error = leave_one_out(&clips, &groups, &settings, || ()).unwrap_err().to_string();
    assert!(error.contains("1 group"), "{error}");
}
