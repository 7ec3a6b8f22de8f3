//! Blending two shapes of 26,000 triangles, beside Kaji's Table 1 (another machine) and
//! `reference/peer_arap_libigl.py` (run apart): taking apart, one `E_T` solve with the blend
//! computed, ten iterations of `E_S`.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use handover_mesh::Point;
use handover_mesh::blend::{BlendSettings, Blender, Energy, Rotation, Tetrisation, Triangles};

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

fn triangles() -> Triangles {
    let corners = (0..AROUND).flat_map(|i| (0..AROUND).map(move |j| (i, j))).flat_map(|(i, j)| {
        let at = |i: u32, j: u32| i % AROUND * AROUND + j % AROUND;
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    Triangles::new((AROUND * AROUND) as usize, corners.collect()).unwrap()
}

/// The pair that is blended, and how it is called.
fn pair() -> (&'static str, Triangles, [Vec<Point>; 2]) {
    ("torus", triangles(), [torus(0.02, 0.0), torus(0.05, 0.8)])
}

fn blend(criterion: &mut Criterion) {
    let (name, triangles, [reference, pose]) = pair();
    let mut group = criterion.benchmark_group(format!("blend/{name}"));
    group.sample_size(20);
    for tetrisation in Tetrisation::ALL {
        let kind = tetrisation.name();
        let settings = BlendSettings { tetrisation, ..BlendSettings::default() };
        let take_apart =
            |settings| Blender::of_triangles(&triangles, &[&reference, &pose], settings).unwrap();
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

criterion_group!(benches, blend);
criterion_main!(benches);
