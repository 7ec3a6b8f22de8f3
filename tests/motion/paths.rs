//! Shortest paths between all pairs against trying every pose in between.

use handover_mesh::motion::{MotionGraph, Neighbourhood, Rows, ShortestPaths};
use proptest::prelude::*;

use crate::{model, walks};

/// All lengths (Floyd 1962).
fn slowly(graph: &MotionGraph) -> Vec<Vec<f64>> {
    let count = graph.len();
    let mut lengths = vec![vec![f64::INFINITY; count]; count];
    for i in 0..count {
        lengths[i][i] = 0.0;
        for (j, length) in graph.next(i) {
            lengths[i][j] = lengths[i][j].min(length);
        }
    }
    for via in 0..count {
        for i in 0..count {
            for j in 0..count {
                lengths[i][j] = lengths[i][j].min(lengths[i][via] + lengths[via][j]);
            }
        }
    }
    lengths
}

/// Returns how many pairs have a way, and how many have none.
#[track_caller]
fn check(graph: &MotionGraph) -> [usize; 2] {
    let (paths, expected) = (ShortestPaths::of(graph).unwrap(), slowly(graph));
    let mut pairs = [0, 0];
    for from in 0..graph.len() {
        for to in 0..graph.len() {
            let Some(transition) = paths.transition(from, to) else {
                assert_eq!((expected[from][to], paths.length(from, to)), (f64::INFINITY, None));
                pairs[1] += 1;
                continue;
            };
            pairs[0] += 1;
            let length = transition.length;
            assert_eq!(paths.length(from, to), Some(length));
            assert!((length - expected[from][to]).abs() <= 1e-12 * length, "{from} to {to}");
            let (first, last) = (transition.poses[0], transition.poses[transition.poses.len() - 1]);
            assert_eq!((first, last), (from, to));
            let mut walked = 0.0;
            for pair in transition.poses.windows(2) {
                let edge = graph.next(pair[0]).find(|(next, _)| *next == pair[1]);
                walked += edge.unwrap_or_else(|| panic!("no edge {pair:?}")).1;
            }
            assert!((walked - length).abs() <= 1e-12 * length, "{from} to {to}");
        }
        assert_eq!(paths.transition(from, from).unwrap().poses, [from]);
        assert_eq!(paths.length(from, from), Some(0.0));
    }
    for via in 0..graph.len() {
        for from in 0..graph.len() {
            for to in 0..graph.len() {
                let length = |a, b| paths.length(a, b).unwrap_or(f64::INFINITY);
                let detour = length(from, via) + length(via, to);
                assert!(length(from, to) <= detour * (1.0 + 1e-12), "{from} to {to} by {via}");
            }
        }
    }
    pairs
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn lengths_are_those_of_trying_every_pose(
        seed in 0..100_000_u64, lengths in prop::collection::vec(1..18_usize, 1..4),
    ) {
        prop_assume!(lengths.iter().sum::<usize>() >= 4);
        for neighbourhood in Neighbourhood::ALL {
            check(&model(&walks(seed, &lengths), neighbourhood, 3).graph());
        }
    }
}

/// Poses that stand still are steps of no length, and no trap.
#[test]
fn standing_still_costs_nothing() {
    let sequence = walks(3, &[8]).remove(0);
    let still: Vec<f64> = sequence.iter().flat_map(|pose| pose.repeat(3)).collect();
    let model = model(&[Rows::new(4, still).unwrap()], Neighbourhood::KDelaunay, 4);
    let graph = model.graph();
    let [ways, none] = check(&graph);
    assert!(ways > 24 && none > 0, "{ways} {none}");
    let paths = ShortestPaths::of(&graph).unwrap();
    assert_eq!(paths.length(0, 2), Some(0.0));
    assert_eq!(paths.transition(0, 2).unwrap().poses, [0, 1, 2]);
}

#[test]
fn a_round_leads_from_everywhere_to_everywhere() {
    let circle = |k: i32| [0.0, 1.5].map(|shift| (f64::from(k) * 0.31 + shift).sin());
    let circle = Rows::new(2, (0..60).flat_map(circle).collect()).unwrap();
    let graph = model(&[circle], Neighbourhood::Delaunay, 1).graph();
    assert_eq!(check(&graph), [3600, 0]);
}

#[test]
fn the_same_paths_on_any_number_of_threads() {
    let graph = model(&walks(2, &[60, 40]), Neighbourhood::KDelaunay, 6).graph();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| ShortestPaths::of(&graph).unwrap())
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn too_many_poses_are_refused_before_memory_is_taken() {
    let many = ShortestPaths::MOST + 1;
    let line = |k: usize| [k as f64, (k * k % 1013) as f64];
    let poses = Rows::new(2, (0..many).flat_map(line).collect()).unwrap();
    let graph = model(&[poses], Neighbourhood::Delaunay, 1).graph();
    let error = ShortestPaths::of(&graph).unwrap_err().to_string();
    assert!(error.contains("10001") && error.contains("10000"), "{error}");
}
