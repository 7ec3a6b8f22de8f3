//! Solves of `tests/data/golden_solves.json`, made by a slow independent implementation
//! (numpy, scipy) on synthetic motion: every coordinate within 1e-6 m.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests, as tests do")]

use std::sync::Arc;

use handover_mesh::mesh::{Edge, EdgeWeights, InteractionMesh, Kernel, Pair, Topology, Vertex};
use handover_mesh::retarget::{Constraint, RetargetSettings, Retargeter, Start, Transform};
use handover_mesh::{Point, Role, Skeleton};
use serde::Deserialize;

const TOLERANCE: f64 = 1e-6;

/// The file's bone order, within one person.
const BONES: [[usize; 2]; 14] = [
    [0, 1],
    [1, 2],
    [1, 3],
    [3, 4],
    [4, 5],
    [1, 6],
    [6, 7],
    [7, 8],
    [2, 9],
    [9, 10],
    [10, 11],
    [2, 12],
    [12, 13],
    [13, 14],
];

#[derive(Deserialize)]
struct Case {
    name: String,
    edges: Vec<[usize; 2]>,
    kernel: String,
    scale: f64,
    power: f64,
    d0: f64,
    d_min: f64,
    w_time: f64,
    known: Vec<usize>,
    known_is: Option<String>,
    transform: String,
    w_l: f64,
    w_p: Option<f64>,
    w_b: f64,
    iterations: Option<usize>,
    sweeps: Option<usize>,
    eps: Option<f64>,
    last_step: Option<f64>,
    energies: Option<Vec<f64>>,
    lengths: Vec<f64>,
    input: Vec<Vec<[f64; 3]>>,
    target: Vec<Vec<[f64; 3]>>,
    output: Vec<Vec<[f64; 3]>>,
}

fn points(frames: &[Vec<[f64; 3]>]) -> Vec<Point> {
    frames.iter().flatten().map(|p| Point::from(*p)).collect()
}

fn lengths(case: &Case, pair: &Pair) -> Vec<f64> {
    let place = |a: usize, b: usize| {
        let within = [a % 15, b % 15];
        let found =
            BONES.iter().position(|bone| *bone == within || *bone == [within[1], within[0]]);
        found.unwrap() + if a < 15 { 0 } else { BONES.len() }
    };
    pair.bones().map(|[a, b]| case.lengths[place(a.index(), b.index())]).collect()
}

#[track_caller]
fn check(case: &Case) {
    let skeleton = Skeleton::nite();
    let pair = Arc::new(Pair::new([skeleton.clone(), skeleton]));
    let vertices: Vec<Vertex> =
        pair.vertices(Role::First).chain(pair.vertices(Role::Second)).collect();
    let edges = case.edges.iter().map(|[a, b]| Edge::new(vertices[*a], vertices[*b]));
    let topology = Arc::new(Topology::new(pair.clone(), edges).unwrap());
    assert_eq!(topology.edges().len(), case.edges.len(), "bones are among the edges");
    let kernel = match case.kernel.as_str() {
        "uniform" => Kernel::Uniform,
        _ => Kernel::InverseDistance {
            scale: case.scale,
            power: case.power,
            reference: case.d0,
            minimum: case.d_min,
        },
    };
    let input = points(&case.input);
    let weights = EdgeWeights::by_kernel(&topology, &input, kernel, case.w_time);
    let mesh = InteractionMesh::new(topology.clone(), input.clone(), weights).unwrap();
    let known = if case.known_is.as_deref() == Some("eliminated") {
        Constraint::Fixed
    } else {
        Constraint::Soft(1.0)
    };
    let constraints: Vec<Constraint> = (0..input.len())
        .map(|v| if case.known.contains(&(v % 30)) { known } else { Constraint::Free })
        .collect();
    let local_global = case.transform == "local_global";
    let settings = RetargetSettings {
        transform: match case.transform.as_str() {
            "none" => Transform::None,
            "implicit" => Transform::Implicit,
            _ => Transform::LocalGlobal,
        },
        laplacian_weight: case.w_l,
        known_weight: case.w_p.unwrap_or(1.5),
        bone_weight: case.w_b,
        steps: case.iterations.or(case.sweeps).unwrap(),
        tolerance: 0.0,
        start: if local_global { Start::Aligned } else { Start::Reference },
        rotation_memory: case.eps.unwrap_or(1e-3),
    };
    let retargeter = Retargeter::new(topology, &constraints, settings).unwrap();
    let mut workspace = retargeter.workspace();
    retargeter.assemble(&mesh, &mut workspace).unwrap();
    retargeter.factor(&mut workspace).unwrap();
    let (targets, lengths) = (points(&case.target), lengths(case, &pair));
    let mut solved = input;
    let residual =
        retargeter.solve(&mesh, &targets, &lengths, &mut workspace, &mut solved).unwrap();
    let expected = points(&case.output);
    let worst = solved.iter().zip(&expected).map(|(a, b)| (a - b).amax()).fold(0.0f64, f64::max);
    println!("{}: farthest coordinate {worst:.1e} m", case.name);
    assert!(worst < TOLERANCE, "{}: a coordinate is {worst:e} m off", case.name);
    if let Some(last_step) = case.last_step {
        assert!((residual.last_step - last_step).abs() < TOLERANCE, "{}: {residual:?}", case.name);
    }
    if let Some(energies) = &case.energies {
        let energy = retargeter.energy(&mesh, &targets, &lengths, &workspace, &solved);
        // The file counts the partner's own bones too; they are fixed and so constant.
        let fixed: f64 = pair
            .bones()
            .zip(&lengths)
            .filter(|([a, b], _)| {
                case.known.contains(&a.index()) && case.known.contains(&b.index())
            })
            .flat_map(|([a, b], length)| {
                targets
                    .chunks(30)
                    .map(move |f| ((f[a.index()] - f[b.index()]).norm() - length).powi(2))
            })
            .sum();
        let expected = energies.last().unwrap();
        let found = energy + case.w_b * fixed;
        assert!((found - expected).abs() < 1e-9 * expected.max(1.0), "{found} {expected}");
    }
}

#[test]
fn every_golden_solve_is_reproduced() {
    let cases: Vec<Case> = serde_json::from_str(include_str!("data/golden_solves.json")).unwrap();
    assert_eq!(cases.len(), 5);
    cases.iter().for_each(check);
}
