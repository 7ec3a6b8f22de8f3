//! What retargeting must keep, whatever the motion: invariances, descent, limits.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::sync::Arc;

use handover_mesh::geometry::yaw_isometry;
use handover_mesh::mesh::{
    Edge, EdgeWeights, InitialEdges, InteractionMesh, Kernel, Pair, Topology,
};
use handover_mesh::retarget::{
    Constraint, Residual, RetargetError, RetargetSettings, Retargeter, Start, Transform, Workspace,
};
use handover_mesh::{Isometry, Point, Role, Skeleton, Vector};
use proptest::prelude::*;

#[path = "common/standing.rs"]
mod standing;
use standing::STANDING;

const TRANSFORMS: [Transform; 3] = [Transform::None, Transform::Implicit, Transform::LocalGlobal];
const FRAMES: usize = 5;
const JOINTS: usize = 30;
const KERNEL: Kernel =
    Kernel::InverseDistance { scale: 30.0, power: 4.0, reference: 0.1, minimum: 0.05 };

/// Two people facing each other, arms moving with the frame, every joint off by `noise` `[m]`.
fn motion(noise: &[f64]) -> Vec<Point> {
    let mut noise = noise.iter().cycle();
    let mut positions = Vec::new();
    for frame in 0..FRAMES {
        let reach = (frame as f64 * 0.7).sin();
        for (sign, origin) in [(1.0, 0.0), (-1.0, 1.1)] {
            for (joint, rest) in STANDING.iter().enumerate() {
                let mut p = Vector::new(sign * rest[0] + origin, sign * rest[1], rest[2]);
                if joint == 7 || joint == 8 {
                    p += reach * Vector::new(0.15 * sign, 0.05 * sign, 0.1) * (joint - 6) as f64;
                }
                p += Vector::from_fn(|_, _| *noise.next().unwrap());
                positions.push(Point::from(p));
            }
        }
    }
    positions
}

/// A solve from a mesh of `demonstration` to `targets`, the first person and the second's torso
/// known.
struct Case {
    mesh: InteractionMesh,
    retargeter: Retargeter,
    targets: Vec<Point>,
    lengths: Vec<f64>,
}

impl Case {
    fn new(
        demonstration: Vec<Point>,
        targets: &[Point],
        known: Constraint,
        settings: RetargetSettings,
    ) -> Self {
        let skeleton = Skeleton::nite();
        let pair = Arc::new(Pair::new([skeleton.clone(), skeleton]));
        let hand = |role| pair.vertices(role).nth(8).unwrap();
        let first_frame = &motion(&[0.0])[..JOINTS];
        // One topology for all: it must not change with what is done to the demonstration.
        let topology =
            Topology::initial(pair.clone(), first_frame, InitialEdges::EachPerson).unwrap();
        let topology =
            Arc::new(topology.with([Edge::new(hand(Role::First), hand(Role::Second))]).unwrap());
        let weights = EdgeWeights::by_kernel(&topology, &demonstration, KERNEL, 1.0);
        let lengths = pair.bones().map(|[a, b]| (targets[a.index()] - targets[b.index()]).norm());
        let lengths = lengths.collect();
        let mesh = InteractionMesh::new(topology.clone(), demonstration, weights).unwrap();
        let is_known = |v: usize| v % JOINTS < 15 || v % JOINTS == 17;
        let constraints: Vec<Constraint> = (0..targets.len())
            .map(|v| if is_known(v) { known } else { Constraint::Free })
            .collect();
        let retargeter = Retargeter::new(topology, &constraints, settings).unwrap();
        Self { mesh, retargeter, targets: targets.to_vec(), lengths }
    }

    /// `Σ (‖e‖ − l)²` `[m²]` over the robot's bones.
    fn squared_bone_misses(&self, positions: &[Point]) -> f64 {
        let bones = self.mesh.topology().pair().bones().zip(&self.lengths).skip(14);
        bones
            .flat_map(|([a, b], length)| {
                let frames = positions.chunks_exact(JOINTS);
                frames.map(move |f| ((f[a.index()] - f[b.index()]).norm() - length).powi(2))
            })
            .sum()
    }

    fn solve(&self) -> (Vec<Point>, Residual, Workspace) {
        let mut workspace = self.retargeter.workspace();
        self.retargeter.assemble(&self.mesh, &mut workspace).unwrap();
        self.retargeter.factor(&mut workspace).unwrap();
        let mut solved = self.targets.clone();
        let residual = self
            .retargeter
            .solve(&self.mesh, &self.targets, &self.lengths, &mut workspace, &mut solved)
            .unwrap();
        (solved, residual, workspace)
    }
}

fn farthest(a: &[Point], b: &[Point]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

fn moved(points: &[Point], by: &Isometry) -> Vec<Point> {
    points.iter().map(|p| by * p).collect()
}

/// The partner as demonstrated, the robot smaller and nearer: something to do for the bones.
fn targets(demonstration: &[Point]) -> Vec<Point> {
    let shrink = |v: usize, p: &Point| {
        if v % JOINTS < 15 { *p } else { Point::new(p.x * 0.9, p.y, p.z * 0.92) }
    };
    demonstration.iter().enumerate().map(|(v, p)| shrink(v, p)).collect()
}

fn settings(transform: Transform, steps: usize) -> RetargetSettings {
    RetargetSettings { transform, steps, ..RetargetSettings::default() }
}

fn noise() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-0.03f64..0.03, 97)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    /// Moving everything moves the solution along, and nothing else.
    #[test]
    fn translation_moves_the_solution(noise in noise(), shift in prop::array::uniform3(-5.0f64..5.0)) {
        let shift = yaw_isometry(0.0, Vector::from(shift));
        for transform in TRANSFORMS {
            let here = motion(&noise);
            let there = Case::new(
                moved(&here, &shift), &moved(&targets(&here), &shift), Constraint::Fixed,
                settings(transform, 5),
            );
            let here = Case::new(here.clone(), &targets(&here), Constraint::Fixed, settings(transform, 5));
            let off = farthest(&moved(&here.solve().0, &shift), &there.solve().0);
            prop_assert!(off < 1e-9, "{transform:?}: {off:e}");
        }
    }

    #[test]
    fn rotating_the_demonstration_alone_changes_nothing(
        noise in noise(),
        axis in prop::array::uniform3(-2.0f64..2.0),
    ) {
        let settings =
            RetargetSettings { start: Start::Aligned, ..settings(Transform::LocalGlobal, 12) };
        let demonstration = motion(&noise);
        let targets = targets(&demonstration);
        let turn = Isometry::new(Vector::new(1.0, -2.0, 0.5), Vector::from(axis));
        let turned = Case::new(moved(&demonstration, &turn), &targets, Constraint::Fixed, settings);
        let plain = Case::new(demonstration, &targets, Constraint::Fixed, settings);
        let off = farthest(&plain.solve().0, &turned.solve().0);
        prop_assert!(off < 1e-9, "{off:e}");
    }

    /// The linearised bones are a majorisation: the energy with true bones falls at every step.
    #[test]
    fn energy_with_true_bones_never_rises(noise in noise()) {
        let demonstration = motion(&noise);
        for (transform, known) in
            TRANSFORMS.into_iter().flat_map(|t| [(t, Constraint::Fixed), (t, Constraint::Soft(1.0))])
        {
            let energies = run(&demonstration, transform, known, 20).map(|(energy, _)| energy);
            for (before, after) in energies.clone().zip(energies.skip(1)) {
                prop_assert!(after <= before * (1.0 + 1e-12), "{transform:?}: {before} to {after}");
            }
        }
    }

    /// `L v' = T(v') δ` for every small similarity `v' = v + s v + h × v + t`: exactly, because T
    /// is linear in v'.
    #[test]
    fn implicit_operator_annihilates_similarities(
        noise in noise(),
        stretch in -0.3f64..0.3,
        turn in prop::array::uniform3(-0.5f64..0.5),
        shift in prop::array::uniform3(-3.0f64..3.0),
    ) {
        let demonstration = motion(&noise);
        let similar: Vec<Point> = demonstration
            .iter()
            .map(|p| p * (1.0 + stretch) + Vector::from(turn).cross(&p.coords) + Vector::from(shift))
            .collect();
        // Without bones and soft constraints the energy is the operator's alone.
        let settings =
            RetargetSettings { bone_weight: 0.0, ..settings(Transform::Implicit, 1) };
        let case = Case::new(demonstration, &similar, Constraint::Fixed, settings);
        let (solved, _, workspace) = case.solve();
        let energy =
            case.retargeter.energy(&case.mesh, &similar, &case.lengths, &workspace, &similar);
        prop_assert!(energy < 1e-20, "{energy:e}");
        prop_assert!(farthest(&solved, &similar) < 1e-6, "{:e}", farthest(&solved, &similar));
    }

    #[test]
    fn rigid_bone_input_is_a_fixed_point(noise in noise(), yaw in -3.0f64..3.0) {
        // The same pose in every frame: its bones are rigid.
        let pose = &motion(&noise)[..JOINTS];
        let demonstration = pose.repeat(FRAMES);
        for transform in TRANSFORMS {
            let case = Case::new(demonstration.clone(), &demonstration, Constraint::Fixed, settings(transform, 5));
            let (solved, residual, _) = case.solve();
            prop_assert!(farthest(&solved, &demonstration) < 1e-9, "{transform:?}");
            prop_assert!(residual.bones < 1e-9);
        }
        // Turned people are no other problem where neighbourhoods may turn.
        let turned = moved(&demonstration, &yaw_isometry(yaw, Vector::new(1.0, 2.0, 0.0)));
        let settings =
            RetargetSettings { start: Start::Aligned, ..settings(Transform::LocalGlobal, 5) };
        let case = Case::new(demonstration, &turned, Constraint::Fixed, settings);
        prop_assert!(farthest(&case.solve().0, &turned) < 1e-9);
    }

    /// Without bones, whose directions are taken from first iterates that differ.
    #[test]
    fn soft_constraints_converge_to_eliminated_ones(noise in noise()) {
        let demonstration = motion(&noise);
        let targets = targets(&demonstration);
        for transform in [Transform::None, Transform::Implicit] {
            let settings = RetargetSettings { bone_weight: 0.0, ..settings(transform, 1) };
            let solve = |known| {
                Case::new(demonstration.clone(), &targets, known, settings).solve().0
            };
            let exact = solve(Constraint::Fixed);
            let off = [1e2, 1e4, 1e6].map(|weight| farthest(&solve(Constraint::Soft(weight)), &exact));
            prop_assert!(off[1] < 0.05 * off[0] && off[2] < 0.05 * off[1], "{transform:?} {off:?}");
        }
    }
}

/// Energy `[m²]` and squared bone misses `[m²]` after each number of steps.
fn run(
    demonstration: &[Point],
    transform: Transform,
    known: Constraint,
    most: usize,
) -> impl Iterator<Item = (f64, f64)> + Clone + '_ {
    let targets = targets(demonstration);
    (1..=most).map(move |steps| {
        let settings = settings(transform, steps);
        let case = Case::new(demonstration.to_vec(), &targets, known, settings);
        let (solved, _, workspace) = case.solve();
        let energy =
            case.retargeter.energy(&case.mesh, &case.targets, &case.lengths, &workspace, &solved);
        (energy, case.squared_bone_misses(&solved))
    })
}

/// `local_global` alternates rotations and positions: neither may raise the energy.
#[test]
fn local_global_energy_never_rises() {
    let demonstration = motion(&[0.02, -0.01, 0.005, -0.03, 0.015, 0.0, 0.01]);
    for known in [Constraint::Fixed, Constraint::Soft(1.0)] {
        let energies =
            run(&demonstration, Transform::LocalGlobal, known, 80).map(|(energy, _)| energy);
        let energies: Vec<f64> = energies.collect();
        for pair in energies.windows(2) {
            assert!(pair[1] <= pair[0] * (1.0 + 1e-12), "{} rose to {}", pair[0], pair[1]);
        }
        assert!(energies[79] < 0.9 * energies[0], "and it does fall");
    }
}

/// The energy falls by theorem; on clean motion the bones' own misses do so too, step by step.
#[test]
fn bone_residual_falls_monotonically() {
    let demonstration = motion(&[0.0]);
    for transform in TRANSFORMS {
        let misses: Vec<f64> = run(&demonstration, transform, Constraint::Fixed, 40)
            .map(|(_, misses)| misses)
            .collect();
        for (step, pair) in misses.windows(2).enumerate() {
            assert!(
                pair[1] <= pair[0],
                "{transform:?}, step {step}: {} rose to {}",
                pair[0],
                pair[1]
            );
        }
        assert!(misses[4] < 0.75 * misses[0], "{transform:?}: five steps bring it down");
    }
}

#[test]
fn fixed_joints_are_their_targets_and_a_workspace_may_be_used_again() {
    let demonstration = motion(&[0.01, -0.02, 0.005]);
    let targets = targets(&demonstration);
    for transform in TRANSFORMS {
        let case =
            Case::new(demonstration.clone(), &targets, Constraint::Fixed, settings(transform, 5));
        let (solved, residual, mut workspace) = case.solve();
        for (v, (a, b)) in solved.iter().zip(&targets).enumerate() {
            assert!(v % JOINTS >= 15 || a == b, "{transform:?}: the partner stays");
        }
        let mut again = vec![Point::origin(); targets.len()];
        let second = case
            .retargeter
            .solve(&case.mesh, &targets, &case.lengths, &mut workspace, &mut again)
            .unwrap();
        assert_eq!((second, again), (residual, solved), "{transform:?}");
    }
}

#[test]
fn a_tolerance_ends_the_steps_early() {
    let demonstration = motion(&[0.0]);
    let targets = targets(&demonstration);
    let settings = RetargetSettings { tolerance: 1e-3, ..settings(Transform::None, 500) };
    let (_, residual, _) = Case::new(demonstration, &targets, Constraint::Fixed, settings).solve();
    assert!(residual.steps < 500 && residual.last_step <= 1e-3, "{residual:?}");
}

#[test]
fn what_cannot_be_solved_is_named() {
    let demonstration = motion(&[0.0]);
    let good = Case::new(
        demonstration.clone(),
        &demonstration,
        Constraint::Fixed,
        settings(Transform::None, 5),
    );
    let topology = good.mesh.topology().clone();
    let new = |constraints: &[Constraint], settings| {
        Retargeter::new(topology.clone(), constraints, settings)
    };

    let free = vec![Constraint::Free; demonstration.len()];
    for transform in TRANSFORMS {
        let retargeter = new(&free, settings(transform, 5)).unwrap();
        let mut workspace = retargeter.workspace();
        retargeter.assemble(&good.mesh, &mut workspace).unwrap();
        let error = retargeter.factor(&mut workspace).unwrap_err();
        assert!(matches!(error, RetargetError::Unanchored { .. }), "{transform:?}: {error}");
    }

    let bad = RetargetSettings { steps: 0, bone_weight: f64::NAN, ..RetargetSettings::default() };
    let error = new(&free, bad).unwrap_err().to_string();
    assert!(error.contains("steps is 0") && error.contains("bone_weight is NaN"), "{error}");
    assert!(new(&free[1..], RetargetSettings::default()).is_err());
    let mut weight = free.clone();
    weight[31] = Constraint::Soft(-1.0);
    let error = new(&weight, RetargetSettings::default()).unwrap_err();
    assert_eq!(error, RetargetError::Weight { frame: 1, joint: 1, weight: -1.0 });

    let mut workspace = good.retargeter.workspace();
    good.retargeter.assemble(&good.mesh, &mut workspace).unwrap();
    good.retargeter.factor(&mut workspace).unwrap();
    let mut out = demonstration.clone();
    let mut solve = |targets: &[Point], lengths: &[f64]| {
        good.retargeter.solve(&good.mesh, targets, lengths, &mut workspace, &mut out)
    };
    let mut targets = demonstration.clone();
    targets[33].z = f64::INFINITY;
    let error = solve(&targets, &good.lengths).unwrap_err();
    assert_eq!(error, RetargetError::NotFinite { frame: 1, joint: 3 });
    // A free joint's target is not read.
    targets[33] = demonstration[33];
    targets[29].z = f64::NAN;
    assert!(solve(&targets, &good.lengths).is_ok());
    let mut lengths = good.lengths.clone();
    lengths[2] = 0.0;
    let error = solve(&demonstration, &lengths).unwrap_err();
    assert_eq!(error, RetargetError::Length { bone: 2, length: 0.0 });
    assert!(solve(&demonstration[1..], &good.lengths).is_err());
}
