//! One retargeting of 60 frames × 30 joints, partner and robot's torso eliminated: assembly,
//! factorisation and one step apart, and all of them with three steps; the banded factor beside
//! `faer`'s sparse one on the same matrices.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::hint::black_box;
use std::sync::Arc;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use faer::linalg::solvers::Solve as _;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use handover_mesh::mesh::{EdgeWeights, InitialEdges, InteractionMesh, Kernel, Pair, Topology};
use handover_mesh::retarget::{
    BandMatrix, Constraint, RetargetSettings, Retargeter, Transform, Workspace,
};
use handover_mesh::{Point, Skeleton, Vector};

#[path = "../tests/common/standing.rs"]
mod standing;
use standing::STANDING;

const FRAMES: usize = 60;
const JOINTS: usize = 30;
const TRANSFORMS: [(&str, Transform); 3] = [
    ("none", Transform::None),
    ("implicit", Transform::Implicit),
    ("local_global", Transform::LocalGlobal),
];

/// Two people whose right hands meet in the middle of the motion.
fn motion(distance: f64, scale: f64, reach: f64, lift: f64) -> Vec<Point> {
    let mut positions = Vec::with_capacity(FRAMES * JOINTS);
    for frame in 0..FRAMES {
        let part = (std::f64::consts::PI * frame as f64 / (FRAMES - 1) as f64).sin().powi(2);
        for (sign, scale, origin) in [(1.0, 1.0, 0.0), (-1.0, scale, distance)] {
            for (joint, rest) in STANDING.iter().enumerate() {
                let mut p = Vector::from(*rest) * scale;
                let share = [0.4, 1.0][usize::from(joint == 8)];
                if joint == 7 || joint == 8 {
                    p += part * share * Vector::new(reach, 0.15, lift);
                }
                positions.push(Point::new(sign * p.x + origin, sign * p.y, p.z));
            }
        }
    }
    positions
}

struct Problem {
    mesh: InteractionMesh,
    targets: Vec<Point>,
    lengths: Vec<f64>,
    retargeter: Retargeter,
}

impl Problem {
    fn new(transform: Transform) -> Self {
        let skeleton = Skeleton::nite();
        let pair = Arc::new(Pair::new([skeleton.clone(), skeleton]));
        let (input, targets) = (motion(1.1, 1.0, 0.38, 0.35), motion(1.0, 0.92, 0.33, 0.28));
        let topology =
            Topology::initial(pair.clone(), &input[..JOINTS], InitialEdges::BothPeople).unwrap();
        let topology = Arc::new(topology);
        let weights = EdgeWeights::by_kernel(&topology, &input, Kernel::Uniform, 1.0);
        let lengths = pair.bones().map(|[a, b]| (targets[a.index()] - targets[b.index()]).norm());
        let lengths = lengths.collect();
        let mesh = InteractionMesh::new(topology.clone(), input, weights).unwrap();
        let known = |v: usize| v % JOINTS < 15 || v % JOINTS == 17;
        let constraints: Vec<Constraint> = (0..FRAMES * JOINTS)
            .map(|v| if known(v) { Constraint::Fixed } else { Constraint::Free })
            .collect();
        let settings = RetargetSettings { transform, steps: 3, ..RetargetSettings::default() };
        let retargeter = Retargeter::new(topology, &constraints, settings).unwrap();
        Self { mesh, targets, lengths, retargeter }
    }

    fn assembled(&self) -> Workspace {
        let mut workspace = self.retargeter.workspace();
        self.retargeter.assemble(&self.mesh, &mut workspace).unwrap();
        workspace
    }

    fn solve(&self, workspace: &mut Workspace, out: &mut [Point]) {
        let Self { mesh, targets, lengths, retargeter } = self;
        black_box(retargeter.solve(mesh, targets, lengths, workspace, out).unwrap());
    }
}

fn retarget(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("retarget_60x30");
    for (name, transform) in TRANSFORMS {
        let problem = Problem::new(transform);
        let assembled = problem.assembled();
        let mut workspace = assembled.clone();
        let mut out = problem.targets.clone();
        group.bench_function(format!("{name}/assemble"), |bencher| {
            bencher.iter(|| problem.retargeter.assemble(&problem.mesh, &mut workspace).unwrap());
        });
        group.bench_function(format!("{name}/factor"), |bencher| {
            let factor = |workspace: &mut Workspace| problem.retargeter.factor(workspace).unwrap();
            bencher.iter_batched_ref(|| assembled.clone(), factor, BatchSize::LargeInput);
        });
        problem.retargeter.assemble(&problem.mesh, &mut workspace).unwrap();
        problem.retargeter.factor(&mut workspace).unwrap();
        group.bench_function(format!("{name}/three_steps"), |bencher| {
            bencher.iter(|| problem.solve(&mut workspace, &mut out));
        });
        group.bench_function(format!("{name}/whole"), |bencher| {
            bencher.iter(|| {
                problem.retargeter.assemble(&problem.mesh, &mut workspace).unwrap();
                problem.retargeter.factor(&mut workspace).unwrap();
                problem.solve(&mut workspace, &mut out);
            });
        });
    }
    group.finish();
}

/// The matrix of the problem in `faer`'s form, lower half.
fn sparse(matrix: &BandMatrix) -> SparseColMat<usize, f64> {
    let mut triplets = Vec::new();
    for row in 0..matrix.size() {
        for column in row.saturating_sub(matrix.half_bandwidth())..=row {
            let value = matrix.get(row, column);
            if value != 0.0 {
                triplets.push(Triplet::new(row, column, value));
            }
        }
    }
    SparseColMat::try_new_from_triplets(matrix.size(), matrix.size(), &triplets).unwrap()
}

fn factors(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("factor_and_solve_60x30");
    for (name, transform) in TRANSFORMS {
        let problem = Problem::new(transform);
        let band = problem.assembled().matrix().clone();
        let size = band.size();
        let rhs: Vec<[f64; 4]> = (0..size).map(|i| [(i as f64).sin(); 4]).collect();
        group.bench_function(format!("{name}/band"), |bencher| {
            let work = |(matrix, rhs): &mut (BandMatrix, Vec<[f64; 4]>)| {
                matrix.factor().unwrap();
                matrix.solve(rhs);
            };
            bencher.iter_batched_ref(|| (band.clone(), rhs.clone()), work, BatchSize::LargeInput);
        });
        let lower = sparse(&band);
        let symbolic = SymbolicLlt::try_new(lower.symbolic(), Side::Lower).unwrap();
        let right = Mat::from_fn(size, 4, |i, j| rhs[i][j]);
        group.bench_function(format!("{name}/faer_sparse"), |bencher| {
            bencher.iter(|| {
                let factor =
                    Llt::try_new_with_symbolic(symbolic.clone(), lower.as_ref(), Side::Lower);
                black_box(factor.unwrap().solve(&right));
            });
        });
    }
    group.finish();
}

criterion_group!(benches, retarget, factors);
criterion_main!(benches);
