//! The measurement: noise, losses, holds and swaps do what they say, and nothing else.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic as tests do")]

use handover_mesh::{
    Frame, JointId, Part, Person, Point, Recording, Role, Sequence, Side, Skeleton, Span, Stamp,
};
use handover_sim::generate;
use handover_sim::scene::{Scene, SceneConfig};
use handover_sim::sensor::{Sensor, SensorConfig, View};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

fn truth() -> Recording {
    let scene = Scene::new(SceneConfig { centre: [0.0, 2.5], ..SceneConfig::default() }).unwrap();
    let sensor = Sensor::new(SensorConfig::ideal(30.0)).unwrap();
    let stamps = sensor.capture_stamps(scene.moments().end, &mut ChaCha8Rng::seed_from_u64(0));
    scene.record("clip", &stamps).unwrap().truth
}

/// Two people who stand still, every joint this far ahead of the sensor.
fn at_depth(depth: f64) -> Recording {
    let person = |name: &str| {
        let frame = |k: i64| Frame {
            stamp: Stamp(0) + Span(k * 33_333_333),
            positions: vec![Point::new(0.2, depth, 1.1); 15].into(),
        };
        let motion = Sequence::new(Skeleton::nite(), (0..400).map(frame).collect()).unwrap();
        Person { name: name.into(), motion }
    };
    Recording::new("still", [person("giver"), person("receiver")], None, Default::default())
        .unwrap()
}

fn observe(config: SensorConfig, truth: &Recording) -> View {
    let sensor = Sensor::new(config).unwrap();
    sensor.observe(truth, &mut ChaCha8Rng::seed_from_u64(3)).unwrap()
}

/// Root mean square error along y, the depth.
fn depth_error(config: SensorConfig, depth: f64) -> f64 {
    let measured = observe(config, &at_depth(depth)).measured;
    let frames = measured.person(Role::First).motion.frames();
    let errors = frames.iter().flat_map(|frame| &frame.positions).map(|p| (p.y - depth).powi(2));
    (errors.sum::<f64>() / (15 * frames.len()) as f64).sqrt()
}

#[test]
fn an_ideal_sensor_sees_the_truth() {
    let truth = truth();
    let view = observe(SensorConfig::ideal(30.0), &truth);
    assert_eq!(view.measured, truth);
    assert_eq!((view.lost_frames, view.swapped_frames, view.held_joints), (0, 0, 0));
}

#[test]
fn noise_grows_with_the_square_of_depth() {
    let config = || SensorConfig { depth_noise: 1.425e-3, ..SensorConfig::ideal(30.0) };
    for depth in [1.0, 2.0, 4.0] {
        let expected = 1.425e-3 * depth * depth;
        assert!((depth_error(config(), depth) / expected - 1.0).abs() < 0.05, "at {depth}");
    }
    let sixteen = SensorConfig { pixels: 16.0, ..config() };
    assert!((depth_error(sixteen, 2.0) / (1.425e-3 * 4.0 / 4.0) - 1.0).abs() < 0.05);
    // Uniform within a step: a twelfth of its square, if the noise spreads over some steps.
    let steps = SensorConfig { depth_step: 2.85e-3, ..config() };
    let expected = 1.425e-3 * 16.0 * (1.0_f64 + 4.0 / 12.0).sqrt();
    assert!((depth_error(steps, 4.0) / expected - 1.0).abs() < 0.1);
}

#[test]
fn lost_frames_leave_gaps_and_the_rest_alone() {
    let truth = truth();
    let view = observe(SensorConfig { frame_loss: 0.3, ..SensorConfig::ideal(30.0) }, &truth);
    assert!(view.lost_frames > truth.len() / 6);
    assert_eq!(view.measured.len() + view.lost_frames, truth.len());
    let spans: Vec<Span> =
        view.measured.stamps().zip(view.measured.stamps().skip(1)).map(|(a, b)| b - a).collect();
    assert!(spans.iter().any(|span| span.0 > 60_000_000));
    for person in view.measured.people() {
        let whole = &truth.person(truth.role(&person.name).unwrap()).motion;
        for frame in person.motion.frames() {
            assert!(whole.frames().contains(frame));
        }
    }
    assert_eq!(view.measured.object().unwrap().points[0].places.len(), view.measured.len());
    // At the worst one frame is left: a recording needs one.
    let worst = SensorConfig { frame_loss: 0.9, ..SensorConfig::ideal(30.0) };
    assert!(!observe(worst, &truth).measured.stamps().collect::<Vec<_>>().is_empty());
}

#[test]
fn a_lost_joint_keeps_its_last_place() {
    let truth = truth();
    let config = SensorConfig { hold_rate: 1.0, hold_duration: 0.2, ..SensorConfig::ideal(30.0) };
    let view = observe(config, &truth);
    let mut held = 0;
    for role in [Role::First, Role::Second] {
        let [seen, real] = [&view.measured, &truth].map(|r| &r.person(role).motion);
        for (at, frame) in seen.frames().iter().enumerate() {
            for (joint, point) in frame.positions.iter().enumerate() {
                if *point != real.frames()[at].positions[joint] {
                    assert_eq!(*point, seen.frames()[at - 1].positions[joint]);
                    held += 1;
                }
            }
        }
    }
    // A resting joint that is held can be where it should.
    assert!(held > 100 && held <= view.held_joints, "{held} of {}", view.held_joints);
}

#[test]
fn a_swap_exchanges_left_and_right() {
    let truth = truth();
    for (whole_body_swaps, legs) in [(0.0, false), (1.0, true)] {
        let config = SensorConfig {
            swap_rate: 50.0,
            swap_duration: 10.0,
            whole_body_swaps,
            ..SensorConfig::ideal(30.0)
        };
        let view = observe(config, &truth);
        let last = truth.len() - 1;
        let skeleton = Skeleton::nite();
        let joint =
            |part: fn(Side) -> Part, side| -> JointId { skeleton.part(part(side)).unwrap() };
        let exchanged = |part: fn(Side) -> Part| {
            Side::BOTH.iter().all(|side| {
                let seen =
                    view.measured.person(Role::First).motion.position(last, joint(part, *side));
                let other = joint(part, side.opposite());
                seen == truth.person(Role::First).motion.position(last, other)
            })
        };
        assert!(view.swapped_frames > truth.len());
        assert!(exchanged(Part::Hand) && exchanged(Part::Elbow) && exchanged(Part::Shoulder));
        assert_eq!(exchanged(Part::Foot), legs);
        let head = |recording: &Recording| {
            recording.person(Role::First).motion.position(last, skeleton.part(Part::Head).unwrap())
        };
        assert_eq!(head(&view.measured), head(&truth));
    }
}

#[test]
fn stamps_jitter_about_an_even_beat_and_rise() {
    let config = SensorConfig { stamp_jitter: 0.05, ..SensorConfig::ideal(15.0) };
    let sensor = Sensor::new(config).unwrap();
    let stamps = sensor.capture_stamps(4.0, &mut ChaCha8Rng::seed_from_u64(5));
    assert_eq!((stamps.len(), stamps[0]), (61, Stamp(0)));
    assert!(stamps.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(stamps.iter().enumerate().all(|(k, s)| (s.seconds() - k as f64 / 15.0).abs() < 0.027));
    assert_eq!(sensor.capture_stamps(f64::NAN, &mut ChaCha8Rng::seed_from_u64(5)), [Stamp(0)]);
}

#[test]
fn a_kinect_moves_bones_as_a_kinect_does() {
    let sensor = Sensor::new(SensorConfig::kinect(30.0)).unwrap();
    let faultless = SensorConfig { hold_rate: 0.0, swap_rate: 0.0, ..SensorConfig::kinect(30.0) };
    let faultless = Sensor::new(faultless).unwrap();
    let mut faults = 0;
    for index in 0..20 {
        let clip = generate(11, index, "clip", &sensor).unwrap();
        faults += clip.view.held_joints + clip.view.swapped_frames + clip.view.lost_frames;
        let clip = generate(11, index, "clip", &faultless).unwrap();
        let motion = &clip.view.measured.person(Role::First).motion;
        let [_, elbow, hand] = Skeleton::nite().arm(Side::Right).unwrap();
        let lengths: Vec<f64> = (0..motion.len())
            .map(|frame| (motion.position(frame, hand) - motion.position(frame, elbow)).norm())
            .collect();
        let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
        let spread = lengths.iter().map(|l| (l - mean).powi(2)).sum::<f64>();
        let spread = (spread / lengths.len() as f64).sqrt();
        assert!((0.004..0.025).contains(&spread), "forearm scatters by {spread} m");
    }
    assert!(faults > 40, "{faults}");
}

#[test]
fn everything_out_of_range_is_reported_at_once() {
    let config =
        SensorConfig { frame_loss: 2.0, yaw: f64::NAN, pixels: 0.0, ..SensorConfig::kinect(1.0) };
    let violations = Sensor::new(config).unwrap_err();
    let keys: Vec<&str> = violations.all().iter().map(|v| v.key.as_str()).collect();
    assert_eq!(keys, ["sensor.rate", "sensor.yaw", "sensor.pixels", "sensor.frame_loss"]);
}
