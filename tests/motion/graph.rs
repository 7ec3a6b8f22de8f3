//! Which pose may follow which: the rule of direction, and the paper's claim about connectivity.

use std::collections::BTreeSet;
use std::ops::Range;

use handover_mesh::motion::{MotionGraph, MotionModel, Neighbourhood, Rows};
use petgraph::algo::{connected_components, kosaraju_scc};
use proptest::prelude::*;

use crate::{distance, model, owners, walks};

const K: usize = 4;

/// What may be neighbours, slowly: simplices' corners with all that lie at their places, and the
/// nearest.
fn neighbours(model: &MotionModel) -> BTreeSet<[usize; 2]> {
    let points = model.points();
    let count = points.len();
    let mut pairs = BTreeSet::new();
    if model.neighbourhood() != Neighbourhood::Delaunay {
        for i in 0..count {
            let mut others: Vec<usize> = (0..count).filter(|j| *j != i).collect();
            let far = |j: &usize| distance(points.row(i), points.row(*j));
            others.sort_by(|a, b| far(a).total_cmp(&far(b)).then(a.cmp(b)));
            pairs.extend(others.into_iter().take(K).map(|j| [i.min(j), i.max(j)]));
        }
    }
    if let Some(complex) = model.complex() {
        for edge in complex.edges() {
            let [a, b] = edge.map(|corner| points.row(corner as usize));
            for i in (0..count).filter(|i| points.row(*i) == a) {
                for j in (0..count).filter(|j| points.row(*j) == b) {
                    pairs.insert([i.min(j), i.max(j)]);
                }
            }
        }
    }
    pairs
}

fn in_time(sequences: &[Range<usize>]) -> BTreeSet<[usize; 2]> {
    let steps = sequences.iter().flat_map(|range| range.clone().zip(range.clone().skip(1)));
    steps.map(|(i, j)| [i, j]).collect()
}

#[track_caller]
fn check_edges(model: &MotionModel) {
    let (graph, points, velocities) = (model.graph(), model.points(), model.velocities());
    assert_eq!(graph.len(), points.len());
    let edges = (0..graph.len()).flat_map(|i| graph.next(i).map(move |(j, length)| (i, j, length)));
    let edges: Vec<(usize, usize, f64)> = edges.collect();
    let found: BTreeSet<[usize; 2]> = edges.iter().map(|&(i, j, _)| [i, j]).collect();
    assert_eq!(found.len(), graph.edge_count(), "no edge twice");

    let in_time = in_time(model.sequences());
    let mut expected = in_time.clone();
    for [i, j] in neighbours(model) {
        if !in_time.contains(&[i, j]) {
            let along: f64 = (0..2)
                .map(|axis| {
                    let mean = 0.5 * (velocities.row(i)[axis] + velocities.row(j)[axis]);
                    mean * (points.row(j)[axis] - points.row(i)[axis])
                })
                .sum();
            if along > 0.0 {
                expected.insert([i, j]);
            } else if along < 0.0 {
                expected.insert([j, i]);
            }
        }
    }
    assert_eq!(found, expected);
    for (i, j, length) in edges {
        assert_ne!(i, j, "no pose follows itself");
        assert!((length - distance(points.row(i), points.row(j))).abs() < 1e-12);
        assert!(!found.contains(&[j, i]), "{i} and {j} follow each other");
    }
}

/// Who leads to whom, by trying every pose in between (Warshall 1962).
fn reachable(graph: &MotionGraph) -> Vec<Vec<bool>> {
    let count = graph.len();
    let mut reached: Vec<Vec<bool>> = (0..count)
        .map(|i| {
            let next: BTreeSet<usize> = graph.next(i).map(|(j, _)| j).collect();
            (0..count).map(|j| i == j || next.contains(&j)).collect()
        })
        .collect();
    for via in 0..count {
        for i in 0..count {
            if reached[i][via] {
                for j in 0..count {
                    reached[i][j] |= reached[via][j];
                }
            }
        }
    }
    reached
}

#[track_caller]
fn check_components(graph: &MotionGraph) {
    let reached = reachable(graph);
    let mut expected: Vec<Vec<usize>> = Vec::new();
    for i in 0..graph.len() {
        let mutual = |j: &usize| reached[i][*j] && reached[*j][i];
        let component: Vec<usize> = (0..graph.len()).filter(mutual).collect();
        if component[0] == i {
            expected.push(component);
        }
    }
    assert_eq!(graph.components(), expected);

    // The claim, with H as it is and by what it should be.
    let ends = graph.sequence_ends();
    let nodes: BTreeSet<usize> =
        graph.sequences().iter().flat_map(|range| [range.start, range.end - 1]).collect();
    assert_eq!(ends.node_weights().copied().collect::<BTreeSet<_>>(), nodes);
    for from in ends.node_indices() {
        for to in ends.node_indices() {
            let arc = from != to && reached[ends[from]][ends[to]];
            assert_eq!(ends.contains_edge(from, to), arc);
        }
    }
    let (whole, small) = (expected.len() == 1, kosaraju_scc(&ends).len() == 1);
    assert_eq!(whole, small, "{} components", expected.len());
}

/// Sequences that wander, some of one pose or two, some round in circles.
fn sequences() -> impl Strategy<Value = Vec<Rows>> {
    let lengths = prop::collection::vec(prop_oneof![1..=2_usize, 3..=12_usize], 1..5);
    (0..100_000_u64, lengths, prop::bool::ANY).prop_filter_map("flat", |(seed, lengths, round)| {
        let mut sequences = walks(seed, &lengths);
        if round {
            for (at, sequence) in sequences.iter_mut().enumerate() {
                let radius = 1.0 + 0.05 * at as f64;
                let turned = sequence.iter().enumerate().flat_map(|(k, pose)| {
                    let angle = k as f64 * 0.9 + at as f64;
                    let noise = 0.03 * pose[2];
                    [radius * angle.cos() + noise, radius * angle.sin() - noise, 0.1 * pose[3], 0.0]
                });
                *sequence = Rows::new(4, turned.collect()).unwrap();
            }
        }
        (lengths.iter().sum::<usize>() >= 4).then_some(sequences)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn edges_go_the_way_both_ends_move(sequences in sequences()) {
        for neighbourhood in Neighbourhood::ALL {
            check_edges(&model(&sequences, neighbourhood, K));
        }
    }

    #[test]
    fn the_graph_is_connected_exactly_if_its_sequences_ends_are(sequences in sequences()) {
        for neighbourhood in Neighbourhood::ALL {
            check_components(&model(&sequences, neighbourhood, K).graph());
        }
    }
}

/// Both sides of the claim occur among random sequences: it is not tested on one of them alone.
#[test]
fn connected_and_unconnected_graphs_both_occur() {
    let circle = |k: i32| [0.0, 0.7].map(|shift| (f64::from(k) * 0.5 + shift).sin());
    let circle = Rows::new(2, (0..40).flat_map(circle).collect()).unwrap();
    for neighbourhood in Neighbourhood::ALL {
        let connected = model(std::slice::from_ref(&circle), neighbourhood, K).graph();
        assert_eq!(connected.components().len(), 1, "{}", neighbourhood.name());
        check_components(&connected);
        let line = model(&walks(11, &[2, 2]), neighbourhood, K).graph();
        assert!(line.components().len() > 1);
    }
}

/// Read weakly, the claim fails: two frames that follow each other make H connected, and nothing
/// leads back.
#[test]
fn weak_connectivity_of_the_ends_says_nothing() {
    let three = [0.0, 0.0, 1.0, 0.3, 0.5, -0.2];
    let two = Rows::new(2, three[..4].to_vec()).unwrap();
    let settings = handover_mesh::motion::MotionSettings {
        dimensions: handover_mesh::motion::Dimensions::Count(1),
        neighbourhood: Neighbourhood::Knn,
        k: K,
    };
    let graph = MotionModel::fit(&[two], settings).unwrap().graph();
    assert_eq!(connected_components(&graph.sequence_ends()), 1, "weakly connected");
    assert_eq!(graph.components(), [[0], [1]]);
    assert_eq!(kosaraju_scc(&graph.sequence_ends()).len(), 2, "but not strongly");
}

/// Frames keep the order of time even where the mean of their velocities points back.
#[test]
fn time_goes_on_even_against_the_velocities() {
    // At the turn from 1 to 2 the motion comes back much faster than it went.
    let there_and_back = [[0.0, 0.0], [0.1, 0.4], [0.3, 0.2], [-5.0, 0.1], [-6.0, 3.0]];
    let poses = Rows::new(2, there_and_back.concat()).unwrap();
    for neighbourhood in Neighbourhood::ALL {
        let model = model(std::slice::from_ref(&poses), neighbourhood, K);
        let (points, velocities) = (model.points(), model.velocities());
        let along: f64 = (0..2)
            .map(|axis| {
                let step = points.row(2)[axis] - points.row(1)[axis];
                (velocities.row(1)[axis] + velocities.row(2)[axis]) * step
            })
            .sum();
        assert!(along < 0.0, "the rule alone would turn the edge: {along}");
        let next: Vec<usize> = model.graph().next(1).map(|(pose, _)| pose).collect();
        assert!(next.contains(&2), "{next:?}");
        assert!(model.graph().next(2).all(|(pose, _)| pose != 1));
        check_edges(&model);
    }
}

#[test]
fn sequences_do_not_run_into_each_other() {
    let model = model(&walks(6, &[5, 1, 7]), Neighbourhood::Knn, K);
    assert_eq!(owners(&model), [vec![0; 5], vec![1], vec![2; 7]].concat());
    assert_eq!(model.graph().sequences(), [0..5, 5..6, 6..13]);
    check_edges(&model);
}

/// Equal poses have all the neighbours of their place, and no edge between each other.
#[test]
fn copies_of_a_pose_are_joined_as_it_is() {
    let first = walks(9, &[15]).remove(0);
    let stopping = Rows::new(4, [&first.values()[16..40], &first.values()[36..]].concat()).unwrap();
    for neighbourhood in Neighbourhood::ALL {
        let model = model(&[first.clone(), stopping.clone()], neighbourhood, K);
        check_edges(&model);
        check_components(&model.graph());
    }
}
