//! Where a person will be: learning from some minutes of motion, and one forecast.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use handover_mesh::forecast::{ForecastMethod, ForecastSettings, Forecaster, Moment};
use handover_mesh::{Frame, Point, Sequence, Skeleton, Stamp};

const RECORDINGS: u32 = 20;
const FRAMES: i64 = 225;

/// Somebody's joints swinging, each recording in a way of its own: 7.5 s at 30 Hz.
fn motion(recording: u32) -> Sequence {
    let own = f64::from(recording);
    let frame = |k: i64| {
        let t = k as f64 / 30.0;
        let place = |joint: u32| {
            let j = f64::from(joint);
            let swing = |turn: f64| ((turn + 0.05 * own) * t + turn * j + own).sin();
            let home = Point::new((1.3 * j).sin(), (2.1 * j).cos(), 0.1 * j);
            home + handover_mesh::Vector::new(swing(1.0), swing(1.7), swing(2.3)) * 0.02 * j
        };
        Frame { stamp: Stamp(k * 33_333_333), positions: (0..15).map(place).collect() }
    };
    let frames = (0..FRAMES).map(frame).collect();
    Sequence::new(Skeleton::nite(), frames).expect("rising stamps and finite places")
}

fn forecasts(criterion: &mut Criterion) {
    let motions: Vec<Sequence> = (0..RECORDINGS).map(motion).collect();
    let named: Vec<(&Sequence, u32)> = motions.iter().zip(0..).collect();
    let skeleton = Skeleton::nite();
    let root = skeleton.root();
    let mut group = criterion.benchmark_group("forecast");
    group.sample_size(10);
    let fit = || Forecaster::fit(black_box(&named), root, ForecastSettings::default());
    group.bench_function("fit", |bench| bench.iter(fit));
    group.sample_size(100);
    let forecaster = fit().expect("motions long enough");
    let seen = motion(RECORDINGS);
    let mut workspace = forecaster.workspace();
    for method in ForecastMethod::ALL {
        let mut moment = Moment::new(&skeleton, root);
        let mut now = (5..seen.len()).cycle();
        group.bench_function(method.name(), |bench| {
            bench.iter(|| {
                let past = &seen.frames()[..now.next().unwrap_or(seen.len())];
                moment.observe(&skeleton, past, forecaster.velocity_window());
                black_box(forecaster.forecast(method, &moment, &mut workspace));
            });
        });
    }
    group.finish();
}

criterion_group!(benches, forecasts);
criterion_main!(benches);
