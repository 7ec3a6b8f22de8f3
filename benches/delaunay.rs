//! Delaunay simplices of sizes that occur: two people's joints, and a few seconds of a latent path.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use handover_mesh::Point;
use handover_mesh::delaunay::{Workspace, delaunay};
use rand::{Rng, SeedableRng};
use std::hint::black_box;

/// One person's joints `[m]`, upright at the origin, facing along y.
const PERSON: [[f64; 3]; 15] = [
    [0.0, 0.0, 1.6],
    [0.0, 0.0, 1.4],
    [0.0, 0.0, 1.15],
    [0.2, 0.0, 1.4],
    [0.3, 0.05, 1.15],
    [0.3, 0.25, 1.05],
    [-0.2, 0.0, 1.4],
    [-0.3, 0.05, 1.15],
    [-0.3, 0.25, 1.05],
    [0.1, 0.0, 0.9],
    [0.12, 0.02, 0.5],
    [0.12, 0.0, 0.1],
    [-0.1, 0.0, 0.9],
    [-0.12, 0.02, 0.5],
    [-0.12, 0.0, 0.1],
];

/// Two people facing each other 1.2 m apart.
fn pair() -> Vec<Point> {
    let other = PERSON.map(|[x, y, z]| [-x, 1.2 - y, z]);
    PERSON.into_iter().chain(other).map(Point::from).collect()
}

/// A normal deviate (Box & Muller 1958).
fn normal(rng: &mut impl Rng) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// 1,700 points along a smooth curve.
fn path<const D: usize>(axes: [f64; D]) -> impl Iterator<Item = [f64; D]> {
    (0..1700).map(move |i| {
        let t = 60.0 * f64::from(i) / 1699.0;
        axes.map(|k| (t * (1.0 + 0.13 * k) + k).sin() / (k + 1.0) + 0.05 * (7.0 * t + k).cos())
    })
}

fn sets() -> Vec<(&'static str, Vec<Point>)> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(0);
    let rng = &mut rng;
    let noisy =
        pair().into_iter().map(|p| Point::from([p.x, p.y, p.z].map(|c| c + 0.01 * normal(rng))));
    let noisy = noisy.collect();
    let mut uniform = |count: usize| -> Vec<Point> {
        (0..count).map(|_| Point::from([0; 3].map(|_| rng.random::<f64>()))).collect()
    };
    let (few, hundred, many) = (uniform(30), uniform(100), uniform(1700));
    let gaussian = (0..1700).map(|_| Point::from([1.0, 0.6, 0.4].map(|s| s * normal(rng))));
    let gaussian = gaussian.collect();
    let path = path([0.0, 1.0, 2.0]).map(Point::from).collect();
    let grid = (0..1000)
        .map(|i| Point::new(f64::from(i / 100), f64::from(i / 10 % 10), f64::from(i % 10)));
    let grid = grid.collect();
    vec![
        ("30 joints", noisy),
        ("30 joints, exact", pair()),
        ("30 uniform", few),
        ("100 uniform", hundred),
        ("1700 uniform", many),
        ("1700 gaussian", gaussian),
        ("1700 path", path),
        ("1000 grid", grid),
    ]
}

fn tetrahedra(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("delaunay");
    for (name, points) in sets() {
        group.bench_with_input(BenchmarkId::new("new", name), &points, |bench, points| {
            bench.iter(|| delaunay(black_box(points)));
        });
        let mut workspace = Workspace::default();
        group.bench_with_input(BenchmarkId::new("kept", name), &points, |bench, points| {
            bench.iter(|| workspace.delaunay(black_box(points)));
        });
    }
    group.finish();
}

fn four_dimensions(criterion: &mut Criterion) {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(0);
    let gaussian = (0..1700).map(|_| [1.0, 0.6, 0.4, 0.25].map(|s| s * normal(&mut rng))).collect();
    let path = path([0.0, 1.0, 2.0, 3.0]).collect();
    let digits = |i: i32| [1, 6, 36, 216].map(|n| f64::from(i / n % 6));
    let grid = (0..1296).map(digits).collect();
    let sets: [(_, Vec<[f64; 4]>); 3] =
        [("1700 gaussian", gaussian), ("1700 path", path), ("1296 grid", grid)];
    let mut group = criterion.benchmark_group("delaunay_4d");
    group.sample_size(20);
    for (name, points) in sets {
        let mut workspace = Workspace::default();
        group.bench_with_input(BenchmarkId::new("kept", name), &points, |bench, points| {
            bench.iter(|| workspace.delaunay_4d(black_box(points)));
        });
    }
    group.finish();
}

criterion_group!(benches, tetrahedra, four_dimensions);
criterion_main!(benches);
