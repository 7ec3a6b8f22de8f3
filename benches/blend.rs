//! Blending two shapes of 26,000 triangles: taking apart, one `E_T` solve with the blend computed,
//! ten iterations of `E_S`; and one window of an interaction mesh. Kaji's Table 1 has the same on
//! another machine, libigl's `arap_precomputation` the first on the same torus.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]
#![allow(clippy::print_stderr, reason = "what is skipped is said")]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use handover_mesh::Point;
use handover_mesh::blend::{
    Apart, BlendSettings, Blender, DenseBlender, Energy, Rotation, Structure, Tetrisation,
    Triangles,
};
use handover_mesh::delaunay::delaunay;
use handover_mesh::formats::obj::Obj;

#[path = "../tests/common/standing.rs"]
mod standing;
use standing::STANDING;

/// Around the torus, and around its tube: 25,992 triangles.
const AROUND: u32 = 114;

/// A bumpy torus, bent by an angle a metre: the shape that the peer's bench takes apart.
fn torus(bump: f64, bend: f64) -> Vec<Point> {
    let turn = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(AROUND);
    let places = (0..AROUND).flat_map(|i| (0..AROUND).map(move |j| (turn(i), turn(j))));
    let place = |(u, v): (f64, f64)| {
        let radius = 0.35 + bump * (5.0 * u).sin() * (3.0 * v).cos();
        let ring = 1.0 + radius * v.cos();
        let (x, y, z) = (ring * u.cos(), ring * u.sin(), radius * v.sin());
        let (sine, cosine) = (bend * x).sin_cos();
        Point::new(x, cosine * y - sine * z, sine * y + cosine * z)
    };
    places.map(place).collect()
}

fn torus_triangles() -> Triangles {
    let corners = (0..AROUND).flat_map(|i| (0..AROUND).map(move |j| (i, j))).flat_map(|(i, j)| {
        let at = |i: u32, j: u32| i % AROUND * AROUND + j % AROUND;
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    Triangles::new((AROUND * AROUND) as usize, corners.collect()).unwrap()
}

/// A mesh and two shapes of it.
struct Pair {
    name: &'static str,
    triangles: Triangles,
    shapes: [Vec<Point>; 2],
}

/// The torus, and the lions of 26,000 triangles where they are.
fn pairs() -> Vec<Pair> {
    let shapes = [torus(0.02, 0.0), torus(0.05, 0.8)];
    let mut pairs = vec![Pair { name: "torus", triangles: torus_triangles(), shapes }];
    let data = std::env::var("HANDOVER_DATA").unwrap_or("../../shared/data".to_owned());
    let files = ["lion26k-reference.obj", "lion26k-04.obj"];
    let read = |file: &str| std::fs::read(format!("{data}/meshes/{file}")).ok();
    let Some(lions) = files.map(read).into_iter().collect::<Option<Vec<_>>>() else {
        eprintln!("SKIPPED: no lions of 26,000 triangles under {data}/meshes (set HANDOVER_DATA)");
        return pairs;
    };
    let [reference, pose] = [0, 1].map(|at| Obj::read(&lions[at]).unwrap());
    let triangles = Triangles::new(reference.positions().len(), reference.triangles()).unwrap();
    let shapes = [&reference, &pose].map(|lion| lion.positions().to_vec());
    pairs.push(Pair { name: "lion26k", triangles, shapes });
    pairs
}

fn blend(criterion: &mut Criterion) {
    for Pair { name, triangles, shapes: [reference, pose] } in pairs() {
        let mut group = criterion.benchmark_group(format!("blend/{name}"));
        group.sample_size(20);
        for tetrisation in Tetrisation::ALL {
            let kind = tetrisation.name();
            let settings = BlendSettings { tetrisation, ..BlendSettings::default() };
            let take_apart = |settings| {
                Blender::of_triangles(&triangles, &[&reference, &pose], settings).unwrap()
            };
            group.bench_function(format!("{kind}/init"), |bencher| {
                bencher.iter(|| black_box(take_apart(settings)));
            });
            let mut out = reference.clone();
            for rotation in Rotation::ALL {
                let transforms = take_apart(BlendSettings { rotation, ..settings });
                let mut workspace = transforms.workspace();
                group.bench_function(format!("{kind}/e_t/{}", rotation.name()), |bencher| {
                    bencher.iter(|| black_box(transforms.blend(&[0.4], &mut workspace, &mut out)));
                });
                let energy = Energy::Shears;
                let ten =
                    BlendSettings { energy, rotation, iterations: 10, tolerance: 0.0, ..settings };
                let shears = take_apart(ten);
                let mut workspace = shears.workspace();
                group.bench_function(format!("{kind}/e_s_10/{}", rotation.name()), |bencher| {
                    bencher.iter(|| black_box(shears.blend(&[0.4], &mut workspace, &mut out)));
                });
            }
        }
        group.finish();
    }
}

/// A reference window: 17 frames of 30 joints, from five demonstrations, each between two frames.
fn window(criterion: &mut Criterion) {
    const FRAMES: usize = 17;
    let pose = |phase: f64, person: u64| {
        let mut pose = Vec::new();
        for (sign, origin) in [(1.0, 0.0), (-1.0, 1.1)] {
            for (joint, [x, y, z]) in STANDING.iter().enumerate() {
                let lean = 0.1 * ((person + 3 * joint as u64) as f64 + 2.0 * phase).sin();
                pose.push(Point::new(sign * (x + lean) + origin, sign * y, z + 0.5 * lean));
            }
        }
        pose
    };
    let rest = pose(0.0, 0);
    let structure = Structure::new(30, delaunay(&rest).unwrap().tetrahedra().to_vec()).unwrap();
    let blender = DenseBlender::new(&structure, &rest, &[2, 17]).unwrap();
    let at = |frame: usize| frame as f64 / FRAMES as f64;
    let demonstrations: Vec<Vec<Apart>> = (0..5)
        .map(|person| (0..=FRAMES).map(|at_| blender.apart(&pose(at(at_), person))).collect())
        .collect();
    let means: Vec<Vec<Point>> = (0..FRAMES).map(|frame| pose(at(frame), 2)).collect();
    let mut places = means.clone();
    let mut workspace = blender.workspace();
    criterion.bench_function("blend/window_17x30_of_5", |bencher| {
        bencher.iter(|| {
            for (frame, (place, mean)) in places.iter_mut().zip(&means).enumerate() {
                place.copy_from_slice(mean);
                let shapes = demonstrations
                    .iter()
                    .flat_map(|frames| [(0.08, &frames[frame]), (0.12, &frames[frame + 1])]);
                blender.blend(shapes, place, &mut workspace);
            }
            black_box(&places);
        });
    });
}

criterion_group!(benches, window, blend);
criterion_main!(benches);
