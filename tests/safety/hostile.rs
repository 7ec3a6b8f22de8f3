//! Anything may come in.

use handover_mesh::safety::{HoldReason, PartnerBody, Proposal, SafetyGate, SafetySettings};
use handover_mesh::{Point, Skeleton, Span, Stamp, Vector};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::checks::Watch;
use crate::scene::{lengths, reaching, standing};

/// Ticks in all; `HANDOVER_SAFETY_TICKS` sets another number.
const TICKS: u64 = 30_000;
const TICKS_OF_ONE_GATE: u64 = 150;

fn point(random: &mut ChaCha8Rng, reach: f64) -> Point {
    let mut coordinate = || random.random_range(-reach..reach);
    Point::new(coordinate(), coordinate(), coordinate())
}

fn odd_value(random: &mut ChaCha8Rng) -> f64 {
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e5][random.random_range(0..6)]
}

/// What somebody might want of the gate for some ticks.
enum Mood {
    /// Poses anywhere, other ones at every tick.
    Wild(f64),
    /// The same pose all the time.
    Steady(Vec<Point>),
    /// One pose and its reverse in turns.
    Flip(Vec<Point>),
    /// A circling hand.
    Circle(f64, f64),
    /// Far poses in turns, one aim ahead of each other: these ways along a direction `[m]`, which
    /// ask for much jerk between the moments that a plan is looked at, one way and the other.
    Jerk(Vector, [f64; 5], Span),
    Hold(HoldReason),
    Broken,
}

/// Ways to a jerk `[m/s³]` that is a parabola around the middle of the lead.
fn jerking(random: &mut ChaCha8Rng, settings: &SafetySettings) -> Mood {
    let (lead, t) = (settings.lead, settings.aim);
    let end = settings.jerk * random.random_range(-0.96..0.96);
    let peak = settings.jerk * random.random_range(0.5..5.0);
    let bend = 4.0 * (peak - end) / (lead * lead);
    let (j0, j1, j2) = (end, bend * lead, -2.0 * bend);
    let place = (j0 / 6.0 + (j1 / 24.0 + j2 / 120.0 * t) * t) * t * t * t;
    let velocity = (j0 / 2.0 + (j1 / 6.0 + j2 / 24.0 * t) * t) * t * t;
    let acceleration = (j0 + (j1 / 2.0 + j2 / 6.0 * t) * t) * t;
    // As the gate takes differences of poses around the aim.
    let step = t / 2.0;
    let ways = [0.0, 0.0, place, t * velocity, t * t * acceleration + 2.0 * place];
    let direction = (point(random, 1.0).coords + Vector::x() * 1e-3).normalize();
    Mood::Jerk(direction, ways, Span((step * 1e9) as i64))
}

fn mood(random: &mut ChaCha8Rng, settings: &SafetySettings) -> Mood {
    let pose = |random: &mut ChaCha8Rng, reach: f64| {
        let base = point(random, reach);
        standing().iter().map(|_| base + point(random, 0.6).coords).collect()
    };
    match random.random_range(0..10) {
        0 => Mood::Wild([0.01, 0.3, 3.0, 1000.0][random.random_range(0..4)]),
        1 => Mood::Steady(pose(random, 1.0)),
        2 => Mood::Flip(pose(random, 0.2)),
        3 | 4 => Mood::Circle(random.random_range(0.02..0.5), random.random_range(0.5..20.0)),
        5 => Mood::Hold(HoldReason::ALL[random.random_range(0..HoldReason::ALL.len())]),
        6 => Mood::Steady(reaching(point(random, 0.5).coords)),
        7 | 8 => jerking(random, settings),
        _ => Mood::Broken,
    }
}

/// Poses and their step for one tick.
fn poses(
    mood: &Mood,
    pose: &[Point],
    time: f64,
    tick: u64,
    random: &mut ChaCha8Rng,
) -> (Vec<Point>, Span) {
    let count = [1, 2, 16][random.random_range(0..3)];
    let step = Span(33_333_333);
    let many = |pose: &[Point]| (0..count).flat_map(|_| pose.to_vec()).collect::<Vec<_>>();
    match mood {
        Mood::Wild(reach) => (
            (0..count * 15).map(|_| point(random, *reach)).collect(),
            Span(random.random_range(1..200_000_000)),
        ),
        Mood::Steady(pose) => (many(pose), step),
        Mood::Flip(pose) => {
            let turn = if tick % 7 < 3 { 1.0 } else { -1.0 };
            let base = pose[2];
            (many(&pose.iter().map(|p| base + (p - base) * turn).collect::<Vec<_>>()), step)
        }
        Mood::Circle(radius, speed) => {
            let at = |k: i32| {
                let phase = speed * (time + f64::from(k) / 30.0);
                reaching(Vector::new(0.2 + radius * phase.cos(), 0.0, radius * phase.sin()))
            };
            ((0..16).flat_map(at).collect(), step)
        }
        Mood::Jerk(direction, ways, step) => {
            // From where it is, so that what is asked for is what is looked at.
            let turn = if tick % 20 < 10 { 1.0 } else { -1.0 };
            let at = |way: &f64| {
                let way = direction * (way * turn);
                pose.iter().map(move |place| place + way).collect::<Vec<_>>()
            };
            (ways.iter().flat_map(at).collect(), *step)
        }
        Mood::Hold(_) | Mood::Broken => {
            let mut poses = many(&standing());
            match random.random_range(0..5) {
                0 => poses.clear(),
                1 => drop(poses.pop()),
                2 => {
                    return (
                        poses,
                        Span([0, -5, i64::MIN, 1, i64::MAX][random.random_range(0..5)]),
                    );
                }
                3 => poses.iter_mut().for_each(|p| *p = Point::new(1.0, 2.0, 3.0)),
                _ => {
                    let at = random.random_range(0..poses.len());
                    poses[at][random.random_range(0..3)] = odd_value(random);
                }
            }
            (poses, step)
        }
    }
}

fn next_partner(random: &mut ChaCha8Rng, robot: &[Point]) -> Option<PartnerBody> {
    let near = robot[random.random_range(0..robot.len())];
    let reach = [0.05, 0.3, 0.6, 1.5][random.random_range(0..4)];
    let head = near + point(random, reach).coords;
    let some = |p: Point, random: &mut ChaCha8Rng| random.random_bool(0.85).then_some(p);
    let mut body = PartnerBody {
        head: some(head, random),
        neck: some(head - Vector::z() * 0.2, random),
        torso: some(head - Vector::z() * 0.5 + point(random, 0.1).coords, random),
    };
    if random.random_bool(0.03) {
        body.neck = Some(Point::new(0.0, odd_value(random), 0.0));
    }
    random.random_bool(0.9).then_some(body)
}

fn settings(random: &mut ChaCha8Rng) -> SafetySettings {
    let usual = SafetySettings::default();
    if random.random_bool(0.4) {
        return usual;
    }
    let lead = match random.random_range(0..3) {
        0 => random.random_range(0.1..0.2),
        _ => random.random_range(0.005..0.1),
    };
    let low = Point::new(-0.5, -0.6, 0.0) + point(random, 0.3).coords;
    let high = Point::new(0.6, 0.6, 1.8) + point(random, 0.3).coords;
    SafetySettings {
        speed: random.random_range(0.1..3.0),
        acceleration: random.random_range(0.5..20.0),
        jerk: random.random_range(5.0..1000.0),
        workspace: random.random_bool(0.6).then_some([low, high]),
        separation: random.random_range(0.0..0.5),
        partner_speed: if random.random_bool(0.5) { 0.0 } else { random.random_range(0.0..1.6) },
        lead,
        aim: random.random_range(f64::max(0.05, lead)..0.5),
        recover: if random.random_bool(0.5) { 0.0 } else { random.random_range(0.0..1.0) },
    }
}

/// Between ticks `[ns]`: to fit the lead, or anything.
fn period(random: &mut ChaCha8Rng, settings: &SafetySettings) -> i64 {
    match random.random_range(0..4) {
        0 => [1_000_000, 10_000_000, 33_333_333, 200_000_000][random.random_range(0..4)],
        1 => random.random_range(1_000_000..33_333_333),
        _ => ((settings.lead / 1.5 * 1e9) as i64).clamp(1_000_000, 33_333_333),
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

/// By how much a clock is set `[ns]`.
fn jump(random: &mut ChaCha8Rng) -> i64 {
    let far = random.random_range(60_000_000_001..10_000_000_000_000);
    [-far, far, i64::MIN, i64::MAX, -1, 0][random.random_range(0..6)]
}

const NOBODY: PartnerBody = PartnerBody { head: None, neck: None, torso: None };

#[test]
fn no_input_breaks_a_promise() {
    let ticks = std::env::var("HANDOVER_SAFETY_TICKS").ok();
    let ticks = ticks.map_or(TICKS, |text| text.parse().unwrap());
    let skeleton = Skeleton::nite();
    let lengths = lengths(&skeleton, &standing());
    let (mut used, mut plans, mut near, mut free) = ([0.0f64; 3], 0, 0, 0);
    let mut take = |watched: &Watch| {
        plans += watched.plans;
        near += watched.near;
        (0..3).for_each(|i| used[i] = used[i].max(watched.used[i]));
    };
    let mut reasons = std::collections::BTreeMap::new();
    for seed in 0..ticks.div_ceil(TICKS_OF_ONE_GATE) {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let settings = settings(random);
        let base = skeleton.root();
        let made = SafetyGate::new(skeleton.clone(), base, &lengths, settings.clone());
        let mut gate = made.unwrap();
        let watch = || Watch::new(skeleton.clone(), lengths.clone(), settings.clone());
        let (mut watched, mut leaves) = (watch(), false);
        let origin = if random.random_bool(0.9) { 0 } else { i64::MIN };
        let (mut now, mut pose) = (Stamp(origin), standing());
        assert!(gate.start(&pose, now));
        let period = period(random, &settings);
        // Some clocks are set every now and then.
        let sets_clock = random.random_bool(0.2);
        let mut current = mood(random, &settings);
        let mut partner = None;
        // Some partners never move.
        let restless = [0.0, 0.02, 0.5][random.random_range(0..3)];
        for tick in 0..TICKS_OF_ONE_GATE {
            if random.random_bool(0.04) {
                current = mood(random, &settings);
            }
            if random.random_bool(restless) || (tick == 0 && random.random_bool(0.7)) {
                partner = next_partner(random, &pose);
            }
            let (poses, pose_step) = poses(&current, &pose, now.seconds() % 100.0, tick, random);
            let proposal = match current {
                Mood::Hold(reason) => Proposal::Hold(reason),
                _ => Proposal::Move { poses: &poses, step: pose_step },
            };
            let target = gate.admit(proposal, partner.as_ref(), now).unwrap();
            let soon = random.random_bool(0.5);
            let longest = if soon { (settings.lead * 1e9) as i64 } else { 800_000_000 };
            let ahead = Span(random.random_range(0..longest));
            // One that was reset takes a partner who is not there to be where they were.
            let known = partner.unwrap_or(if leaves { watched.planned_with() } else { NOBODY });
            watched.check(target, &known, ahead);
            *reasons.entry(target.reason()).or_insert(0) += 1;
            free += usize::from(target.reason().is_none());
            pose = target.positions().to_vec();
            let moves = target.is_moving();
            if leaves && !moves {
                assert!(!gate.is_started());
                assert!(gate.admit(Proposal::Hold(HoldReason::Stale), None, now).is_none());
                pose = standing();
                assert!(gate.start(&pose, now));
                take(&watched);
                (watched, leaves) = (watch(), false);
            } else if random.random_bool(0.005) && moves {
                gate.reset();
                leaves = true;
            }
            let set = sets_clock && random.random_bool(0.05);
            now = now + Span(if set { jump(random) } else { step(random, period) });
        }
        take(&watched);
    }
    println!(
        "{ticks} ticks, {plans} plans, {near} of them too near, {free} free; shares of limits {used:?}; {reasons:?}"
    );
    // It does move, up to near its limits.
    assert!(free as u64 > ticks / 10 && plans as u64 > ticks / 10);
    assert!(near > 0, "no stop comes too near");
    assert!(used.iter().all(|share| *share > 0.8), "{used:?}");
}
