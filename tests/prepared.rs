//! A prepared system: one edge's weights changed give what a mesh made with them gives, and the
//! derivatives of its solution are those of finite differences.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::sync::Arc;

use handover_mesh::mesh::{
    Edge, EdgeWeights, InitialEdges, InteractionMesh, Kernel, Pair, Topology,
};
use handover_mesh::retarget::{
    Constraint, NoDerivative, Prepared, RetargetSettings, Retargeter, Transform,
};
use handover_mesh::{Point, Role, Skeleton, Vector};

#[path = "common/standing.rs"]
mod standing;
use standing::STANDING;

const FRAMES: usize = 6;
const JOINTS: usize = 30;
const KERNEL: Kernel =
    Kernel::InverseDistance { scale: 3.0, power: 2.0, reference: 0.1, minimum: 0.05 };

/// Two people facing each other who reach out by `reach` `[m]`, the second `higher` `[m]`.
fn motion(reach: f64, higher: f64) -> Vec<Point> {
    let mut positions = Vec::new();
    for frame in 0..FRAMES {
        let swing = reach * (frame as f64 * 0.7).sin();
        for (sign, origin, lift) in [(1.0, 0.0, 0.0), (-1.0, 1.1, higher)] {
            for (joint, rest) in STANDING.iter().enumerate() {
                let wobble = 0.01 * (f64::from(joint as u32) * 1.7 + frame as f64).sin();
                let mut p = Vector::new(sign * rest[0] + origin, sign * rest[1], rest[2] + lift);
                p += Vector::new(wobble, -0.5 * wobble, 0.3 * wobble);
                if joint == 7 || joint == 8 {
                    p += swing * Vector::new(1.5 * sign, 0.2 * sign, 0.6) * (joint - 6) as f64;
                }
                positions.push(Point::from(p));
            }
        }
    }
    positions
}

fn pair() -> Arc<Pair> {
    Arc::new(Pair::new([Skeleton::nite(), Skeleton::nite()]))
}

/// Hands, an elbow and a shoulder: the edges whose weights change.
fn edges(pair: &Pair) -> Vec<Edge> {
    let joint = |role, at| pair.vertices(role).nth(at).unwrap();
    [(8, 8), (7, 8), (5, 6), (0, 2)]
        .map(|(a, b)| Edge::new(joint(Role::First, a), joint(Role::Second, b)))
        .to_vec()
}

/// The people's mesh with `edges`, whose weights are `factors` of the kernel's, prepared for
/// another reach.
fn prepared(factors: &[f64], known: Constraint, settings: RetargetSettings) -> Prepared {
    let (pair, reference, targets) = (pair(), motion(0.1, 0.0), motion(0.16, 0.05));
    let first_frame = &reference[..JOINTS];
    let topology = Topology::initial(pair.clone(), first_frame, InitialEdges::EachPerson).unwrap();
    let topology = Arc::new(topology.with(edges(&pair)).unwrap());
    let mut weights = EdgeWeights::by_kernel(&topology, &reference, KERNEL, 1.0);
    for (edge, factor) in edges(&pair).iter().zip(factors) {
        let edge = topology.find(*edge).unwrap();
        for frame in 0..FRAMES {
            weights.set(frame, edge, factor * weights.get(frame, edge));
        }
    }
    let lengths = pair.bones().map(|[a, b]| (targets[a.index()] - targets[b.index()]).norm());
    let lengths = lengths.collect();
    let mesh = InteractionMesh::new(topology.clone(), reference, weights).unwrap();
    let is_known = |v: usize| v % JOINTS < 15 || v % JOINTS == 17;
    let constraints: Vec<Constraint> =
        (0..targets.len()).map(|v| if is_known(v) { known } else { Constraint::Free }).collect();
    let retargeter = Retargeter::new(topology, &constraints, settings).unwrap();
    Prepared::new(retargeter, mesh, targets, lengths).unwrap()
}

fn settings(transform: Transform) -> RetargetSettings {
    RetargetSettings { transform, ..RetargetSettings::default() }
}

#[test]
fn one_edge_changed_is_the_mesh_made_with_it() {
    for transform in [Transform::None, Transform::Implicit, Transform::LocalGlobal] {
        for known in [Constraint::Fixed, Constraint::Soft(1.0)] {
            let base = prepared(&[1.0, 0.0, 0.5, 1.0], known, settings(transform));
            let mut room = base.variation();
            let topology = base.mesh().topology().clone();
            for (at, edge) in edges(&pair()).iter().enumerate() {
                for factor in [0.0, 2.0] {
                    let mut factors = [1.0, 0.0, 0.5, 1.0];
                    factors[at] = factor;
                    let made = prepared(&factors, known, settings(transform));
                    let mut expected = made.variation();
                    let all = made.solve(&mut expected).unwrap();
                    let edge = topology.find(*edge).unwrap();
                    let weights: Vec<f64> =
                        (0..FRAMES).map(|k| made.mesh().weights().get(k, edge)).collect();
                    let weights = if factor == 0.0 { None } else { Some(weights.as_slice()) };
                    let found = base.solve_with(edge, weights, &mut room).unwrap();
                    let pairs = room.solved().iter().zip(expected.solved());
                    let off = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
                    assert!(off < 1e-10, "{transform:?} {known:?} edge {at}: {off}");
                    assert!((found.bones - all.bones).abs() < 1e-10);
                }
            }
            // The room is as it was.
            let mut fresh = base.variation();
            base.solve(&mut fresh).unwrap();
            base.solve(&mut room).unwrap();
            assert_eq!(room.solved(), fresh.solved());
        }
    }
}

/// `d = Σ ω ‖v' − truth‖` and its slope by every vertex.
fn distance(solved: &[Point]) -> (f64, Vec<Vector>) {
    let truth = motion(0.2, 0.1);
    let mut sum = 0.0;
    let slope = solved.iter().zip(&truth).enumerate().map(|(vertex, (a, b))| {
        let weight = if vertex % JOINTS == 23 { 5.0 } else { 1.0 };
        let off = a - b;
        sum += weight * off.norm();
        if off.norm() > 0.0 { off * (weight / off.norm()) } else { Vector::zeros() }
    });
    let slope = slope.collect();
    (sum, slope)
}

fn converged(system: &Prepared) -> f64 {
    let mut room = system.variation();
    let last = system.converge(1e-12, &mut room).unwrap();
    assert!(last < 1e-11, "{last}");
    distance(room.solved()).0
}

#[test]
fn slopes_are_those_of_finite_differences() {
    for transform in [Transform::None, Transform::Implicit] {
        for known in [Constraint::Fixed, Constraint::Soft(1.0)] {
            // Weights of 0 too: that is where learning starts.
            let mut system = prepared(&[1.0, 0.0, 0.5, 2.0], known, settings(transform));
            let topology = system.mesh().topology().clone();
            let of_edges: Vec<usize> =
                edges(&pair()).iter().map(|edge| topology.find(*edge).unwrap()).collect();
            let mut room = system.variation();
            system.converge(1e-12, &mut room).unwrap();
            let (_, slope) = distance(room.solved());
            let slopes = system.slopes(&slope, &of_edges, &mut room).unwrap();
            let largest = slopes.iter().fold(0.0, |most: f64, slope| most.max(slope.abs()));
            for (at, edge) in of_edges.iter().enumerate() {
                let frame = [0, 2, 4, 5][at];
                let before: Vec<f64> =
                    (0..FRAMES).map(|k| system.mesh().weights().get(k, *edge)).collect();
                let mut with = |step: f64| {
                    system
                        .reweigh(&[*edge], |_, weights| {
                            weights.copy_from_slice(&before);
                            weights[frame] += step;
                        })
                        .unwrap();
                    converged(&system)
                };
                // One-sided where the weight is 0, of third order all the same.
                let h = 3e-4;
                let difference = if before[frame] < 3.0 * h {
                    (-11.0 * with(0.0) + 18.0 * with(h) - 9.0 * with(2.0 * h) + 2.0 * with(3.0 * h))
                        / (6.0 * h)
                } else {
                    (8.0 * (with(h) - with(-h)) - (with(2.0 * h) - with(-2.0 * h))) / (12.0 * h)
                };
                with(0.0);
                let found = slopes[at * FRAMES + frame];
                let off = (found - difference).abs() / difference.abs().max(1e-3 * largest);
                assert!(
                    off < 1e-5,
                    "{transform:?} {known:?} edge {at} frame {frame}: {found} {difference}"
                );
            }
        }
    }
}

#[test]
fn local_global_has_no_slopes() {
    let system = prepared(&[1.0; 4], Constraint::Fixed, settings(Transform::LocalGlobal));
    let mut room = system.variation();
    system.solve(&mut room).unwrap();
    let slope = vec![Vector::zeros(); FRAMES * JOINTS];
    assert_eq!(system.slopes(&slope, &[0], &mut room), Err(NoDerivative));
}
