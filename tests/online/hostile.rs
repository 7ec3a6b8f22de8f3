//! Anything may be sighted, at any time, of any robot.

use std::collections::BTreeMap;
use std::sync::Arc;

use handover_mesh::filter::Sighting;
use handover_mesh::online::{OnlineModel, OnlineSettings, TickInput};
use handover_mesh::retarget::Transform;
use handover_mesh::safety::{HoldReason, PartnerBody, SafetySettings};
use handover_mesh::{Point, Skeleton, Span, Stamp, Vector};
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::checks::Watch;
use crate::handovers::{Handover, demonstrations, lengths, model, pipeline};

/// Ticks in all; `HANDOVER_SAFETY_TICKS` sets another number.
const TICKS: u64 = 20_000;
const TICKS_OF_ONE_ROBOT: u64 = 200;

/// What a sensor might say of somebody for some ticks.
#[derive(Debug, Clone, Copy)]
enum Mood {
    /// A handover as it is.
    Proper,
    /// Shaking by so much `[m]`.
    Noisy(f64),
    /// Some joints without a place, or with one that is none.
    Holes,
    /// Elsewhere at every tick, within so much `[m]`.
    Teleporting(f64),
    /// The person stands in the robot.
    Near(Vector),
    /// Joints anywhere within so much `[m]`.
    Scattered(f64),
    /// All joints at one place.
    Heap,
    /// Left and right exchanged.
    Mirrored,
    /// As they stood at that time `[s]`.
    Frozen(f64),
    Unseen,
}

fn point(random: &mut ChaCha8Rng, reach: f64) -> Point {
    let mut coordinate = || random.random_range(-reach..reach);
    Point::new(coordinate(), coordinate(), coordinate())
}

fn odd_value(random: &mut ChaCha8Rng) -> f64 {
    const ODD: [f64; 8] =
        [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e-300, 1e5, f64::MAX];
    ODD[random.random_range(0..ODD.len())]
}

fn mood(random: &mut ChaCha8Rng) -> Mood {
    match random.random_range(0..14) {
        0..4 => Mood::Proper,
        4 => Mood::Noisy([0.01, 0.05, 0.5][random.random_range(0..3)]),
        5 => Mood::Holes,
        6 => Mood::Teleporting([0.3, 1.0, 100.0][random.random_range(0..3)]),
        7 | 8 => Mood::Near(Vector::x() * -random.random_range(0.3..1.3)),
        9 => Mood::Scattered([0.5, 3.0, 1e4, 1e6][random.random_range(0..4)]),
        10 => Mood::Heap,
        11 => Mood::Mirrored,
        12 => Mood::Frozen(random.random_range(0.0..4.0)),
        _ => Mood::Unseen,
    }
}

/// The receiver as the sensor says.
fn sighted(
    mood: Mood,
    handover: &Handover,
    time: f64,
    random: &mut ChaCha8Rng,
) -> Option<Vec<Point>> {
    let mut pose = handover.receiver(time);
    match mood {
        Mood::Proper => {}
        Mood::Noisy(size) => pose.iter_mut().for_each(|p| *p += point(random, size).coords),
        Mood::Holes => {
            for joint in 0..pose.len() {
                if random.random_bool(0.2) {
                    pose[joint][random.random_range(0..3)] = odd_value(random);
                }
            }
        }
        Mood::Teleporting(reach) => {
            let by = point(random, reach).coords;
            pose.iter_mut().for_each(|p| *p += by);
        }
        Mood::Near(by) => pose.iter_mut().for_each(|p| *p += by),
        Mood::Scattered(reach) => pose.iter_mut().for_each(|p| *p = point(random, reach)),
        Mood::Heap => pose.fill(point(random, 1.0)),
        Mood::Mirrored => {
            for (left, right) in [(3, 6), (4, 7), (5, 8), (9, 12), (10, 13), (11, 14)] {
                pose.swap(left, right);
            }
        }
        Mood::Frozen(then) => pose = handover.receiver(then),
        Mood::Unseen => return None,
    }
    random.random_bool(0.8).then_some(pose)
}

/// When the sensor says that it was.
fn stamp(now: Stamp, last: Stamp, random: &mut ChaCha8Rng) -> Stamp {
    match random.random_range(0..30) {
        0 => last,
        1 => last + Span(-random.random_range(0..1_000_000_000)),
        2 => now + Span(random.random_range(-1_000_000_000..1_000_000_000)),
        3 => Stamp([i64::MIN, i64::MAX, 0][random.random_range(0..3)]),
        _ => now + Span(-random.random_range(0..50_000_000)),
    }
}

fn confidences(random: &mut ChaCha8Rng) -> Vec<f64> {
    match random.random_range(0..4) {
        0 => (0..15).map(|_| random.random_range(0.0..1.0)).collect(),
        1 => (0..15).map(|_| odd_value(random)).collect(),
        _ => vec![],
    }
}

/// What the robot says of itself.
fn robot(standing: &[Point], random: &mut ChaCha8Rng) -> Option<Vec<Point>> {
    match random.random_range(0..40) {
        0 => Some(vec![point(random, 10.0); standing.len()]),
        1 => {
            let mut pose = standing.to_vec();
            pose[random.random_range(0..standing.len())] = Point::new(odd_value(random), 0.0, 0.0);
            Some(pose)
        }
        2 => {
            let reach = [0.1, 2.0, 1e6][random.random_range(0..3)];
            let by = point(random, reach).coords;
            Some(standing.iter().map(|place| place + by).collect())
        }
        3..10 => None,
        _ => Some(standing.to_vec()),
    }
}

fn step(random: &mut ChaCha8Rng, period: i64) -> i64 {
    match random.random_range(0..40) {
        0 => 0,
        1 => -random.random_range(0..1_000_000_000),
        2 => random.random_range(1..20_000),
        3 => random.random_range(200_000_000..3_000_000_000),
        4..8 => random.random_range(500_000..200_000_000),
        _ => period,
    }
}

/// Other transforms, windows and limits.
fn models() -> Vec<(Arc<OnlineModel>, SafetySettings)> {
    let usual = SafetySettings::default();
    let boxed = SafetySettings {
        workspace: Some([Point::new(-1.0, -0.5, 0.0), Point::new(-0.1, 0.5, 1.8)]),
        speed: 0.7,
        jerk: 30.0,
        ..usual.clone()
    };
    let wary = SafetySettings { separation: 0.45, partner_speed: 1.6, ..usual.clone() };
    let hasty = SafetySettings {
        speed: 3.0,
        acceleration: 20.0,
        jerk: 1000.0,
        separation: 0.0,
        ..usual.clone()
    };
    let window = OnlineSettings::default();
    let short = OnlineSettings { past: 0, future: 1, ..OnlineSettings::default() };
    let all = [
        (Transform::None, usual, window.clone()),
        (Transform::LocalGlobal, boxed, window.clone()),
        (Transform::Implicit, wary, window),
        (Transform::None, hasty, short),
    ];
    all.into_iter()
        .map(|(transform, safety, online)| {
            let online = OnlineSettings { safety: safety.clone(), ..online };
            (model(demonstrations(3), transform, online), safety)
        })
        .collect()
}

#[test]
fn no_sighting_breaks_a_promise() {
    let ticks = std::env::var("HANDOVER_SAFETY_TICKS").ok();
    let ticks = ticks.map_or(TICKS, |text| text.parse().unwrap());
    let models = models();
    let (mut free, mut solved, mut targets, mut used) = (0, 0, 0, [0.0f64; 3]);
    let mut reasons = BTreeMap::new();
    for seed in 0..ticks.div_ceil(TICKS_OF_ONE_ROBOT) {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let (model, safety) = &models[seed as usize % models.len()];
        let handover = Handover::new(1000 + seed);
        let standing = handover.giver(0.0);
        let mut pipeline = pipeline(model, &standing);
        let watch = || Watch::new(Skeleton::nite(), lengths(&standing), safety.clone());
        let (mut watched, mut body) = (watch(), PartnerBody::default());
        let mut now = Stamp(if random.random_bool(0.9) { 0 } else { i64::MIN });
        let (start, mut newest, mut last) = (now, now, now);
        let period = [1_000_000, 10_000_000, 33_333_333, 100_000_000][random.random_range(0..4)];
        let mut current = if random.random_bool(0.7) { Mood::Proper } else { mood(random) };
        let (mut has_said, mut moves, mut leaves) = (false, false, false);
        let mut places = standing.clone();
        for _ in 0..TICKS_OF_ONE_ROBOT {
            if random.random_bool(0.03) {
                current = mood(random);
            }
            if random.random_bool(0.001) {
                pipeline.cancel();
            }
            if random.random_bool(0.003) {
                pipeline.reset();
                leaves = moves;
                // Nobody is where they were, but for a robot that has to stop first.
                body = if leaves { watched.planned_with() } else { PartnerBody::default() };
                has_said = leaves;
                if !leaves {
                    watched = watch();
                }
            }
            let time = (now - start).seconds() % 6.0;
            let positions = sighted(current, &handover, time, random);
            let confidences = confidences(random);
            let own = robot(&standing, random);
            has_said |= own.is_some();
            let sighting = positions.as_ref().map(|positions| {
                last = stamp(now, last, random);
                let body = match random.random_range(0..30) {
                    0 => None,
                    1 => Some(random.random()),
                    _ => Some(1),
                };
                Sighting { stamp: last, body, positions, confidences: &confidences }
            });
            let tick = pipeline.tick(&TickInput { now, sighting, robot: own.as_deref() });
            if tick.partner.is_some() {
                // As the filter has them: of who is followed, joints not seen are guessed.
                tick.filter.partner().unwrap().at(now, &mut places);
                let [head, neck, torso] = [0, 1, 2].map(|joint| Some(places[joint]));
                body = PartnerBody { head, neck, torso };
            }
            if let Some(target) = tick.target {
                assert!(has_said);
                watched.check(target, &body, Span(random.random_range(0..800_000_000)));
                targets += 1;
                free += u64::from(target.reason().is_none());
                moves = target.is_moving();
                if leaves {
                    assert!(matches!(
                        target.reason(),
                        Some(HoldReason::NoRobot | HoldReason::Clock)
                    ));
                }
                if leaves && !moves {
                    // It has come to a stand: what comes next is of a new start.
                    (watched, body) = (watch(), PartnerBody::default());
                    (leaves, has_said) = (false, false);
                }
            }
            if let Some(solution) = tick.solved {
                let finite = |place: &Point| place.coords.iter().all(|value| value.is_finite());
                assert!(solution.poses.iter().chain(solution.reference).all(finite));
                solved += 1;
            }
            *reasons.entry(tick.reason).or_insert(0) += 1;
            newest = newest.max(now);
            now = newest + Span(step(random, period));
        }
        (0..3).for_each(|i| used[i] = used[i].max(watched.used[i]));
    }
    println!(
        "{ticks} ticks, {targets} targets, {solved} solved, {free} free; shares of limits {used:?}; \
         {reasons:?}"
    );
    // It does move.
    assert!(free > ticks / 20 && solved > ticks / 10 && targets > ticks * 9 / 10);
}

/// After the worst that can be said, whoever does as demonstrated is followed again.
#[test]
fn nothing_said_is_kept_for_ever() {
    let (model, _) = &models()[0];
    for seed in 0..6 {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let handover = Handover::new(2000 + seed);
        let standing = handover.giver(0.0);
        let mut pipeline = pipeline(model, &standing);
        let mut reason = None;
        let mut current = mood(random);
        let tell = |now: Stamp,
                    positions: &[Point],
                    robot: &[Point],
                    pipeline: &mut handover_mesh::online::Pipeline| {
            let sighting = Sighting { stamp: now, body: None, positions, confidences: &[] };
            pipeline.tick(&TickInput { now, sighting: Some(sighting), robot: Some(robot) }).reason
        };
        for frame in 0..240 {
            let now = Stamp(frame * crate::handovers::FRAME);
            let mut own = standing.clone();
            let positions = if frame < 120 {
                if random.random_bool(0.1) {
                    current = mood(random);
                }
                if random.random_bool(0.2) {
                    own[2] = Point::new(odd_value(random), 0.0, 1.0);
                }
                sighted(current, &handover, 1.0, random).unwrap_or(standing.clone())
            } else {
                handover.receiver(now.seconds() - 5.0)
            };
            if frame == 0 {
                tell(now, &handover.receiver(0.0), &standing, &mut pipeline);
            } else {
                reason = tell(now, &positions, &own, &mut pipeline);
            }
        }
        assert_eq!(reason, None, "seed {seed}");
    }
}
