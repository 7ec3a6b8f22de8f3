//! What learning repeats thousands of times: one candidate edge on 60 frames × 30 joints, partner
//! and robot's torso eliminated, three steps as `scipy`'s reference takes; a whole growth of ten
//! steps; and what updating the factor would cost instead of making it anew.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::collections::BTreeMap;
use std::hint::black_box;
use std::sync::Arc;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use handover_mesh::demonstration::Demonstration;
use handover_mesh::learn::{LearnSettings, Lessons, Search};
use handover_mesh::predict::{PredictSettings, Predictor};
use handover_mesh::retarget::{RetargetSettings, Transform};
use handover_mesh::{Frame, Person, Point, Recording, Sequence, Skeleton, Stamp, Vector};

#[path = "../tests/common/standing.rs"]
mod standing;
use standing::STANDING;

const FRAMES: usize = 60;
const TRANSFORMS: [(&str, Transform); 3] = [
    ("none", Transform::None),
    ("implicit", Transform::Implicit),
    ("local_global", Transform::LocalGlobal),
];

/// Two people whose right hands meet in the middle of the recording.
fn recording(name: &str, distance: f64, reach: f64, lift: f64) -> Arc<Demonstration> {
    let skeleton = Skeleton::nite();
    let person = |name: &str, sign: f64, origin: f64| {
        let frames = (0..FRAMES).map(|frame| {
            let part = (std::f64::consts::PI * frame as f64 / (FRAMES - 1) as f64).sin().powi(2);
            let joint = |(joint, rest): (usize, &[f64; 3])| {
                let mut p = Vector::from(*rest);
                if joint == 7 || joint == 8 {
                    let share = [0.4, 1.0][usize::from(joint == 8)];
                    p += part * share * Vector::new(reach, 0.15, lift);
                }
                Point::new(sign * p.x + origin, sign * p.y, p.z)
            };
            Frame {
                stamp: Stamp::from_seconds(frame as f64 / 30.0).unwrap(),
                positions: STANDING.iter().enumerate().map(joint).collect(),
            }
        });
        let motion = Sequence::new(skeleton.clone(), frames.collect()).unwrap();
        Person { name: name.into(), motion }
    };
    let people = [person("receiver", 1.0, 0.0), person("giver", -1.0, distance)];
    let recording = Recording::new(name, people, None, BTreeMap::new()).unwrap();
    Arc::new(Demonstration::new(Arc::new(recording), "giver", "torso").unwrap())
}

/// One reference to learn from.
fn lessons(transform: Transform, settings: &LearnSettings) -> Lessons {
    let clips = vec![recording("one", 1.1, 0.38, 0.35), recording("two", 1.0, 0.33, 0.28)];
    let groups = ["one", "two"].map(String::from);
    let predict = PredictSettings {
        retarget: RetargetSettings { transform, steps: 3, ..RetargetSettings::default() },
        ..PredictSettings::default()
    };
    let predictor = Predictor::fit(clips, predict).unwrap();
    Lessons::of(&predictor, &groups, &[], settings).unwrap()
}

/// All candidates in turn; the time is that of one.
fn candidate(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("learn_candidate_60x30");
    for (name, transform) in TRANSFORMS {
        let settings = LearnSettings { references: 1, ..LearnSettings::default() };
        let lessons = lessons(transform, &settings);
        let mut room = lessons.room();
        let mut candidates = (0..lessons.candidates().len()).cycle();
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                lessons.distance_with(candidates.next().unwrap(), true, &mut room).unwrap()
            });
        });
    }
    group.finish();
}

/// Ten steps over 225 candidates, on all cores.
fn grow(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("learn_grow_60x30");
    group.sample_size(10);
    for (name, transform) in TRANSFORMS {
        let settings =
            LearnSettings { references: 1, tolerance: 0.0, steps: 10, ..LearnSettings::default() };
        let lessons = lessons(transform, &settings);
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let mut search = Search::new(lessons.clone(), settings.clone()).unwrap();
                search.run().unwrap();
                search.evaluations()
            });
        });
    }
    group.finish();
}

/// A factor's lower half, `width` columns of the band a row, the diagonal last.
type Band = Vec<Vec<f64>>;

/// `L Lᵀ + x xᵀ` in place, from the first entry of `x` on (Gill, Golub, Murray & Saunders 1974, C1).
fn add_rank_one(band: &mut Band, width: usize, x: &mut [f64], first: usize) {
    for column in first..band.len() {
        let diagonal = band[column][width - 1];
        let radius = diagonal.hypot(x[column]);
        let (cosine, sine) = (radius / diagonal, x[column] / diagonal);
        band[column][width - 1] = radius;
        for row in column + 1..band.len().min(column + width) {
            let entry = &mut band[row][width - 1 + column - row];
            *entry = (*entry + sine * x[row]) / cosine;
            x[row] = cosine * x[row] - sine * *entry;
        }
    }
}

/// One edge changes the rows of its two ends in every frame; each row goes out and comes in.
fn updates(criterion: &mut Criterion) {
    const UNKNOWNS: usize = 14;
    let (size, width) = (UNKNOWNS * FRAMES, 2 * UNKNOWNS + 1);
    let band: Band = (0..size).map(|_| [vec![0.05; width - 1], vec![3.0]].concat()).collect();
    criterion.bench_function("learn_updates_60x30/none", |bencher| {
        bencher.iter_batched(
            || band.clone(),
            |mut band| {
                for change in 0..4 * FRAMES {
                    let first = (change / 4) * UNKNOWNS;
                    let mut row = vec![0.0; size];
                    let end = size.min(first + width);
                    row[first..end].fill(0.01);
                    add_rank_one(&mut band, width, &mut row, first);
                }
                black_box(band)
            },
            BatchSize::LargeInput,
        );
    });
}

criterion_group!(benches, candidate, grow, updates);
criterion_main!(benches);
