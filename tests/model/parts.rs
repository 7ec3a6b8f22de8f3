//! Small models, made up.

use std::collections::BTreeMap;
use std::sync::Arc;

use handover_mesh::demonstration::Hands;
use handover_mesh::mesh::{Edge, Pair, Vertex};
use handover_mesh::model::{Model, ModelError, Source, Training};
use handover_mesh::predict::{LearnedEdge, LearnedEdges};
use handover_mesh::{
    Config, Frame, ObjectTrack, Part, Person, Point, Recording, Role, Sequence, Side, Skeleton,
    Stamp,
};
use proptest::prelude::*;

const EIGHT: &str =
    "head torso left_shoulder left_elbow left_hand right_shoulder right_elbow right_hand";
const FOUR: &str = "torso left_hand right_hand head";

/// What a model is made of.
#[derive(Debug, Clone)]
pub(crate) struct Parts {
    pub(crate) sources: Vec<Source>,
    pub(crate) role: String,
    pub(crate) edges: LearnedEdges,
    pub(crate) config: Config,
    pub(crate) training: Training,
}

impl Parts {
    pub(crate) fn model(&self) -> Result<Model, ModelError> {
        let Self { sources, role, edges, config, training } = self.clone();
        Model::new(sources, &role, edges, config, training)
    }
}

pub(crate) fn skeleton(which: usize) -> Arc<Skeleton> {
    let named = |text: &str| {
        let names = text.split(' ').map(String::from).collect();
        Arc::new(Skeleton::from_names(names).unwrap())
    };
    match which {
        0 => Skeleton::nite(),
        1 => named(EIGHT),
        // With a cup in the hand.
        2 => {
            let hand = named(EIGHT).part(Part::Hand(Side::Right)).unwrap();
            let cup = ["rim", "base"].map(String::from);
            Arc::new(named(EIGHT).with_attached(hand, &cup).unwrap())
        }
        _ => named(FOUR),
    }
}

pub(crate) fn hash() -> String {
    "0123456789abcdef".repeat(4)
}

pub(crate) fn motion(skeleton: Arc<Skeleton>, frames: usize, x: f64) -> Sequence {
    let at = |k: usize, joint: usize| Point::new(x, 0.1 * joint as f64, 1.0 / (k + 3) as f64);
    let frame = |k: usize| Frame {
        stamp: Stamp(33_333_333 * k as i64),
        positions: (0..skeleton.len()).map(|joint| at(k, joint)).collect(),
    };
    Sequence::new(skeleton.clone(), (0..frames).map(frame).collect()).unwrap()
}

pub(crate) fn person(name: &str, motion: Sequence) -> Person {
    Person { name: name.to_owned(), motion }
}

pub(crate) fn source(name: &str, people: [Person; 2]) -> Source {
    let recording = Recording::new(name, people, None, BTreeMap::new()).unwrap();
    Source { recording: recording.into(), sha256: hash() }
}

pub(crate) fn recording(name: &str, which: usize, object: bool) -> Arc<Recording> {
    let people =
        [("giver", 0.0), ("receiver", 1.0)].map(|(n, x)| person(n, motion(skeleton(which), 3, x)));
    let places = vec![(Stamp(0), Point::origin())];
    let object = object.then(|| ObjectTrack::of_point("cup", places));
    let metadata = BTreeMap::from([("class".to_owned(), "07 \"ä\"\n".to_owned())]);
    Recording::new(name, people, object, metadata).unwrap().into()
}

/// Edges between two NiTE skeletons, by joint over both; factors 0.5, 1.5, …
pub(crate) fn edges_between(ends: &[(usize, usize)], phases: usize) -> LearnedEdges {
    let pair = Pair::new([Skeleton::nite(), Skeleton::nite()]);
    let edges = edges_of(&pair, ends, phases);
    LearnedEdges::new(&pair, right_hands(), phases, edges).unwrap()
}

fn edges_of(pair: &Pair, ends: &[(usize, usize)], phases: usize) -> Vec<LearnedEdge> {
    let vertices: Vec<Vertex> =
        pair.vertices(Role::First).chain(pair.vertices(Role::Second)).collect();
    let factors: Vec<f64> = (0..phases).map(|phase| 0.5 + phase as f64).collect();
    let edge = |&(a, b)| LearnedEdge {
        edge: Edge::new(vertices[a], vertices[b]),
        factors: factors.clone(),
    };
    ends.iter().map(edge).collect()
}

pub(crate) fn right_hands() -> Hands {
    Hands { robot: Side::Right, partner: Side::Right }
}

/// Two demonstrations of two NiTE skeletons, two edges of three phases.
pub(crate) fn parts() -> Parts {
    let source = |name| Source { recording: recording(name, 0, false), sha256: hash() };
    Parts {
        sources: vec![source("first"), source("second")],
        role: "giver".to_owned(),
        edges: edges_between(&[(8, 23), (0, 23)], 3),
        config: Config { folds: 7, ..Config::default() },
        training: Training {
            method: "grow".to_owned(),
            steps: 2,
            evaluations: 451,
            initial_distance: 0.1,
            final_distance: 1.0 / 30.0,
            held_out_distance: Some(0.05),
        },
    }
}

fn side() -> impl Strategy<Value = Side> {
    prop_oneof![Just(Side::Left), Just(Side::Right)]
}

/// Any place within reach, also beside zero on either side.
fn metres() -> impl Strategy<Value = f64> {
    prop_oneof![
        -1e3..=1e3,
        Just(-0.0),
        Just(f64::MIN_POSITIVE / 8.0),
        Just(-1e3),
        prop::num::f64::SUBNORMAL
    ]
}

fn sequences(joints: [usize; 2]) -> impl Strategy<Value = [Vec<Frame>; 2]> {
    let point = || prop::array::uniform3(metres()).prop_map(Point::from);
    let pose = move |joints| prop::collection::vec(point(), joints).prop_map(Box::from);
    let frame = (1..i64::MAX >> 4, pose(joints[0]), pose(joints[1]));
    prop::collection::vec(frame, 1..4).prop_map(|frames| {
        let mut stamp = i64::MIN >> 1;
        let mut motions = [Vec::new(), Vec::new()];
        for (step, first, second) in frames {
            stamp += step;
            motions[0].push(Frame { stamp: Stamp(stamp), positions: first });
            motions[1].push(Frame { stamp: Stamp(stamp), positions: second });
        }
        motions
    })
}

fn demonstration(
    skeletons: [Arc<Skeleton>; 2],
    people: [String; 2],
) -> impl Strategy<Value = Source> {
    let motions = sequences([skeletons[0].len(), skeletons[1].len()]);
    let metadata = prop::collection::btree_map(".{0,8}", any::<String>(), 0..3);
    (motions, metadata, "[^\\pC]{1,20}", "[0-9a-f]{64}").prop_map(
        move |([a, b], metadata, name, sha256)| {
            let motion = |k: usize, frames| Sequence::new(skeletons[k].clone(), frames).unwrap();
            let people = [person(&people[0], motion(0, a)), person(&people[1], motion(1, b))];
            let recording = Recording::new(name, people, None, metadata).unwrap();
            Source { recording: recording.into(), sha256 }
        },
    )
}

fn configs() -> impl Strategy<Value = Config> {
    (0.0..1.0, 1usize..1000, prop::bool::ANY, 0.0..1e6, "[a-z]{1,8}", 1e-9..1.0).prop_map(
        |(smoothing, demonstrations, uniform, scale, joint, memory)| {
            let mut config = Config { ignored_joints: vec![joint], ..Config::default() };
            config.predict.smoothing = smoothing;
            config.predict.demonstrations = demonstrations;
            config.predict.retarget.rotation_memory = memory;
            config.online.trust = memory + 0.001;
            config.online.filter.stale = smoothing + 0.01;
            config.online.safety.workspace =
                uniform.then(|| [Point::origin(), Point::new(1.0, 1.0, memory)]);
            config.predict.kernel = if uniform {
                handover_mesh::mesh::Kernel::Uniform
            } else {
                let (power, reference, minimum) = (scale / 1e6, 0.1, 0.05);
                handover_mesh::mesh::Kernel::InverseDistance { scale, power, reference, minimum }
            };
            config
        },
    )
}

fn trainings() -> impl Strategy<Value = Training> {
    let distance = || prop_oneof![Just(0.0), 0.0..2.0, Just(f64::MAX), Just(5e-324)];
    ("[a-z_]{1,12}", any::<u32>(), distance(), distance(), prop::option::of(distance())).prop_map(
        |(method, steps, initial_distance, final_distance, held_out_distance)| Training {
            method,
            steps: steps as usize,
            evaluations: 3 * steps as usize,
            initial_distance,
            final_distance,
            held_out_distance,
        },
    )
}

/// Any model of a few frames.
pub(crate) fn model_parts() -> impl Strategy<Value = Parts> {
    (0usize..4, 0usize..4, prop::bool::ANY, "[^\\pC]{1,9}").prop_flat_map(|(a, b, second, name)| {
        let skeletons = [skeleton(a), skeleton(b)];
        let pair = Pair::new(skeletons.clone());
        let people = [format!("{name}1"), format!("{name}2")];
        let role = people[usize::from(second)].clone();
        let first = skeletons[0].len();
        let ends = prop::collection::btree_set((0..first, first..pair.len()), 0..6);
        let factors = prop_oneof![Just(0.0), 0.0..1e3, Just(LearnedEdges::MOST_FACTOR)];
        let edges = (ends, 1usize..4, prop::collection::vec(factors, 18), side(), side());
        let edges = edges.prop_map(move |(ends, phases, factors, robot, partner)| {
            let ends: Vec<_> = ends.into_iter().collect();
            let mut edges = edges_of(&pair, &ends, phases);
            let slots = edges.iter_mut().flat_map(|edge| &mut edge.factors);
            slots.zip(factors).for_each(|(slot, factor)| *slot = factor);
            LearnedEdges::new(&pair, Hands { robot, partner }, phases, edges).unwrap()
        });
        let sources = prop::collection::vec(demonstration(skeletons, people), 1..4);
        (sources, Just(role), edges, configs(), trainings()).prop_map(
            |(sources, role, edges, config, training)| Parts {
                sources,
                role,
                edges,
                config,
                training,
            },
        )
    })
}
