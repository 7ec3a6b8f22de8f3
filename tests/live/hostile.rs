//! Anything may be said by anybody at any time.

use handover_mesh::bodies::Body;
use handover_mesh::frames::FrameTree;
use handover_mesh::live::{Inputs, Outputs};
use handover_mesh::messages::{
    Header, Pose, PoseStamped, Quaternion, Time, Transform, TransformStamped, TransformTree,
    Vector3,
};
use handover_mesh::{NodeSettings, Point, RobotState, Skeleton, Stamp};
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::handovers::{FRAME, Handover};
use super::{EPOCH, body, first, live, model};

fn value(random: &mut ChaCha8Rng) -> f64 {
    match random.random_range(0..12) {
        0 => f64::NAN,
        1 => f64::INFINITY,
        2 => 1e300,
        3 => -1e7,
        _ => random.random_range(-3.0..3.0),
    }
}

fn vector(random: &mut ChaCha8Rng) -> Vector3 {
    Vector3 { x: value(random), y: value(random), z: value(random) }
}

fn word(random: &mut ChaCha8Rng) -> String {
    const WORDS: [&str; 8] =
        ["world", "/world", "camera", "", "torso", "moon", "a\0\n\u{1b}[2J", "b"];
    let word = WORDS[random.random_range(0..WORDS.len())];
    word.repeat(if random.random_bool(0.02) { 3000 } else { 1 })
}

fn stamp(random: &mut ChaCha8Rng, now: Stamp) -> Stamp {
    match random.random_range(0..8) {
        0 => Stamp(0),
        1 => Stamp(random.random()),
        2 => Stamp(now.0 - random.random_range(0..3_000_000_000)),
        _ => now,
    }
}

/// A body that is proper in some ways, or in none.
fn anybody(random: &mut ChaCha8Rng, now: Stamp, places: &[Point]) -> Body {
    let id = random.random_bool(0.5).then(|| random.random_range(0..3));
    let mut body = body(stamp(random, now), id, places);
    if random.random_bool(0.3) {
        body.frame = word(random);
    }
    body.joints.retain(|_| random.random_bool(0.9));
    for (name, place) in &mut body.joints {
        if random.random_bool(0.05) {
            *name = word(random);
        }
        if random.random_bool(0.05) {
            *place = vector(random).into();
        }
    }
    body
}

fn tree(random: &mut ChaCha8Rng) -> TransformTree {
    let edge = |random: &mut ChaCha8Rng| TransformStamped {
        header: Header { stamp: Time::default(), frame_id: word(random) },
        child_frame_id: word(random),
        transform: Transform {
            translation: vector(random),
            rotation: Quaternion { x: value(random), y: 0.0, z: 0.0, w: value(random) },
        },
    };
    TransformTree { transforms: (0..random.random_range(0..4)).map(|_| edge(random)).collect() }
}

/// What strangers call things is fit for a log: short, and in characters that do nothing to it.
fn check_words(outputs: &Outputs) {
    let news = outputs.news.iter().map(|news| &news.text);
    let statuses = outputs.diagnostics.iter().flat_map(|array| &array.status);
    let told = statuses.flat_map(|status| {
        std::iter::once(&status.message).chain(status.values.iter().map(|pair| &pair.value))
    });
    for text in news.chain(told) {
        assert!(text.chars().count() < 2000, "{text}");
        assert!(!text.contains(char::is_control), "{text:?}");
    }
}

/// The joints' distance in a trajectory's first points, and the limit on speed kept in between.
#[test]
fn nothing_said_by_anybody_makes_a_target_that_is_none() {
    let settings = model().settings().safety.clone();
    let mut moved = 0;
    for seed in 0..40 {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let robot_state =
            if seed % 3 == 0 { RobotState::Demonstrated } else { RobotState::Reported };
        let mut live = live(NodeSettings { robot_state, ..NodeSettings::default() });
        let handover = Handover::new(200 + seed);
        let mut frames = FrameTree::default();
        let (mut now, mut before, mut reset) = (Stamp(EPOCH), None, -1000);
        for tick in 0..150 {
            now.0 += if random.random_bool(0.05) {
                random.random_range(-FRAME..3 * FRAME)
            } else {
                FRAME / 3
            };
            let time = f64::from(tick) / 90.0;
            let mut said = Inputs::default();
            for _ in 0..random.random_range(0..3) {
                said.bodies.push(anybody(random, now, &handover.receiver(time)));
            }
            if random.random_bool(0.5) {
                said.robot = Some(if random.random_bool(0.9) {
                    body(now, None, &handover.giver(0.0))
                } else {
                    anybody(random, now, &handover.giver(0.0))
                });
            }
            if random.random_bool(0.1) {
                let header = Header { stamp: Time::of(now), frame_id: word(random) };
                let pose = Pose { position: vector(random), ..Pose::default() };
                said.object = Some(PoseStamped { header, pose });
            }
            if random.random_bool(0.1) {
                frames.take(&tree(random), now);
                frames.fix(&tree(random));
                said.frames.clone_from(&frames);
            }
            match random.random_range(0..200) {
                0 => live.cancel(),
                1..4 => {
                    live.reset();
                    reset = tick;
                }
                _ => {}
            }
            let outputs = live.tick(now, &said, Some(1.0));
            check_words(&outputs);
            let Some(trajectory) = outputs.joint_targets else {
                before = None;
                continue;
            };
            let places = first(&trajectory);
            assert_eq!(places.len(), Skeleton::nite().len());
            assert!(places.iter().all(|place| place.iter().all(|x| x.is_finite())));
            let times: Vec<i64> =
                trajectory.points.iter().map(|point| point.time_from_start.span().0).collect();
            assert!(times[0] == 0 && times.is_sorted_by(|a, b| a < b), "{times:?}");
            if let Some((then, last)) = before.replace((now, places.clone())) {
                let passed = (now - then).seconds();
                let far = |(a, b): (&Point, &Point)| (a - b).norm();
                let farthest = places.iter().zip(&last).map(far).fold(0.0, f64::max);
                // A clock that was set tells nothing of speeds, and after a reset the robot may say
                // that it is elsewhere.
                if passed > 0.0 && passed < 0.05 && tick - reset > 75 {
                    assert!(farthest <= settings.speed * passed * 1.001 + 1e-6, "{farthest}");
                }
                moved += usize::from(farthest > 1e-4);
            }
        }
    }
    assert!(moved > 500, "some of them move: {moved}");
}
