//! A motion model of a size that occurs, 1,700 poses of 56 channels: made, and asked where to go.
//! The nearest points beside a k-d tree.

use std::f64::consts::TAU;
use std::hint::black_box;
use std::num::NonZero;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use handover_mesh::motion::{
    Complex, Dimensions, FollowSettings, MotionModel, MotionSettings, Nearest, Neighbourhood, Rows,
    ShortestPaths,
};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const POSES: usize = 1700;
const CHANNELS: usize = 56;
const K: usize = 16;

fn seeded() -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(0)
}

/// A normal deviate (Box & Muller 1958).
fn normal(rng: &mut impl Rng) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
}

/// Four walks that go round and round, about 140 frames a round, never twice the same.
fn walks() -> Vec<Rows> {
    let mut rng = seeded();
    let waves: Vec<[f64; 4]> = (0..CHANNELS)
        .map(|_| [1.0, 0.4, TAU, TAU].map(|size| size * rng.random::<f64>()))
        .collect();
    let walk = |_| {
        let (mut turn, mut size) = (TAU * rng.random::<f64>(), 1.0);
        let mut values = Vec::with_capacity(POSES / 4 * CHANNELS);
        for _ in 0..POSES / 4 {
            turn += TAU / 140.0 * (1.0 + 0.1 * normal(&mut rng));
            size += 0.05 * (1.0 - size) + 0.01 * normal(&mut rng);
            values.extend(waves.iter().map(|[first, second, p, q]| {
                size * first * (turn + p).sin() + second * (2.0 * turn + q).sin()
            }));
        }
        values.iter_mut().for_each(|value| *value += 0.01 * normal(&mut rng));
        Rows::new(CHANNELS, values).expect("finite")
    };
    (0..4).map(walk).collect()
}

fn settings(neighbourhood: Neighbourhood) -> MotionSettings {
    MotionSettings { dimensions: Dimensions::Count(2), neighbourhood, k: K }
}

fn fit(walks: &[Rows], neighbourhood: Neighbourhood) -> MotionModel {
    MotionModel::fit(walks, settings(neighbourhood)).expect("they span a plane")
}

/// Learning, from poses to the graph, and all its shortest paths.
fn model(criterion: &mut Criterion) {
    let walks = walks();
    let mut group = criterion.benchmark_group("motion");
    group.sample_size(20);
    for neighbourhood in Neighbourhood::ALL {
        let name = neighbourhood.name();
        let model = fit(&walks, neighbourhood);
        let graph = model.graph();
        group.bench_function(BenchmarkId::new("fit", name), |bench| {
            bench.iter(|| fit(black_box(&walks), neighbourhood));
        });
        group.bench_function(BenchmarkId::new("graph", name), |bench| {
            bench.iter(|| black_box(&model).graph());
        });
        group.bench_function(BenchmarkId::new("paths", name), |bench| {
            bench.iter(|| ShortestPaths::of(black_box(&graph)));
        });
        group.bench_function(BenchmarkId::new("whole model", name), |bench| {
            bench.iter(|| ShortestPaths::of(&fit(black_box(&walks), neighbourhood).graph()));
        });
    }
    group.finish();
}

/// Where the field goes: at places all over the data, and one step after another.
fn field(criterion: &mut Criterion) {
    let walks = walks();
    let mut rng = seeded();
    let mut group = criterion.benchmark_group("field");
    for neighbourhood in Neighbourhood::ALL {
        let name = neighbourhood.name();
        let model = fit(&walks, neighbourhood);
        let near = |_| -> Vec<f64> {
            let pose = model.points().row(rng.random_range(0..POSES));
            pose.iter().map(|x| x + 0.02 * normal(&mut rng)).collect()
        };
        let places: Vec<Vec<f64>> = (0..1024).map(near).collect();
        let follow = FollowSettings { steps: 1023, still: 0.0, goal: None };
        let path = model.follow(model.points().row(0), &follow).points;
        let path: Vec<Vec<f64>> = path.iter().map(<[f64]>::to_vec).collect();
        for (kind, places) in [("anywhere", &places), ("along a path", &path)] {
            let mut around = model.around();
            let mut velocity = [0.0; 2];
            let mut next = places.iter().cycle();
            group.bench_function(BenchmarkId::new(kind, name), |bench| {
                bench.iter(|| {
                    let place = next.next().expect("endless");
                    model.velocity(black_box(place), &mut around, &mut velocity);
                    velocity
                });
            });
        }
        if let Some(complex) = model.complex() {
            let (mut next, mut simplex) = (places.iter().cycle(), 0);
            group.bench_function(BenchmarkId::new("locate", name), |bench| {
                bench.iter(|| {
                    let place = next.next().expect("endless");
                    simplex = complex.locate(black_box(place), simplex).simplex();
                    simplex
                });
            });
        }
    }
    group.finish();
}

/// Triangles of the plane, of the sets that `delaunay.rs` has in space.
fn complex(criterion: &mut Criterion) {
    let mut rng = seeded();
    let gaussian = (0..POSES).flat_map(|_| [1.0, 0.6].map(|scale| scale * normal(&mut rng)));
    let gaussian = Rows::new(2, gaussian.collect());
    let path = (0..POSES).flat_map(|i| {
        let t = 60.0 * i as f64 / (POSES - 1) as f64;
        [0.0, 1.0]
            .map(|k: f64| (t * (1.0 + 0.13 * k) + k).sin() / (k + 1.0) + 0.05 * (7.0 * t + k).cos())
    });
    let path = Rows::new(2, path.collect());
    let mut group = criterion.benchmark_group("complex");
    for (name, points) in [("1700 gaussian", gaussian), ("1700 path", path)] {
        let points = points.expect("finite");
        group.bench_function(BenchmarkId::new("2-D", name), |bench| {
            bench.iter(|| Complex::new(black_box(&points)));
        });
    }
    group.finish();
}

/// Sixteen nearest points: of all points, and of each one as the graph asks for.
fn nearest<const D: usize>(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group(format!("nearest, {D}-D"));
    for count in [POSES, 20_000] {
        let mut rng = seeded();
        let points: Vec<[f64; D]> = (0..count).map(|_| [0; D].map(|_| normal(&mut rng))).collect();
        let places: Vec<[f64; D]> = (0..1024).map(|_| [0; D].map(|_| normal(&mut rng))).collect();
        let rows = Rows::new(D, points.as_flattened().to_vec()).expect("finite");
        let ours = Nearest::new(&rows);
        let mut found = Vec::with_capacity(K);
        let mut next = places.iter().cycle();
        group.bench_function(BenchmarkId::new("ours", count), |bench| {
            bench.iter(|| {
                let place = next.next().expect("endless");
                ours.nearest(black_box(place), K, &mut found);
                found.len()
            });
        });
        let tree = ImmutableKdTree::<f64, D>::new_from_slice(&points).expect("few are equal");
        let k = NonZero::new(K).expect("sixteen");
        group.bench_function(BenchmarkId::new("kiddo", count), |bench| {
            bench.iter(|| {
                let place = next.next().expect("endless");
                tree.query(black_box(place)).nearest_n::<SquaredEuclidean<f64>>(k).execute()
            });
        });
        group.sample_size(10);
        group.bench_function(BenchmarkId::new("ours, made and of all", count), |bench| {
            bench.iter(|| {
                let ours = Nearest::new(black_box(&rows));
                rows.iter().for_each(|place| {
                    ours.nearest(place, K, &mut found);
                    black_box(&found);
                });
            });
        });
        group.bench_function(BenchmarkId::new("kiddo, made and of all", count), |bench| {
            bench.iter(|| {
                let tree = ImmutableKdTree::<f64, D>::new_from_slice(black_box(&points));
                let tree = tree.expect("few are equal");
                points.iter().for_each(|place| {
                    let found = tree.query(place).nearest_n::<SquaredEuclidean<f64>>(k).execute();
                    black_box(found);
                });
            });
        });
        group.sample_size(100);
    }
    group.finish();
}

criterion_group!(benches, model, field, complex, nearest::<2>, nearest::<8>);
criterion_main!(benches);
