//! What is played when: stamps, loops, pauses, clocks, faults; and what the document says of it.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic as tests do")]

use std::process::Command;

use handover_mesh::formats::csv;
use handover_mesh::messages::MultiDofJointState;
use handover_mesh::parameters::{ParameterTable, ParameterValue};
use handover_mesh::{Point, Recording, Role, Span, Stamp};
use handover_sim::broadcast::{Outgoing, Player, Settings, Source, Topic, follow_ups, parameters};
use handover_sim::generate;
use handover_sim::sensor::{Sensor, SensorConfig};

/// When the tests begin: some time after 1970.
const NOW: Stamp = Stamp(1_700_000_000_000_000_000);

fn seconds(seconds: f64) -> Span {
    Span::from_seconds(seconds).unwrap()
}

/// No delay, whatever else.
fn at_once() -> Settings {
    Settings { start_delay: Span(0), ..Settings::default() }
}

/// The clip as made up, and the same as a sensor of some kind sees it.
fn clip(seed: u64, config: SensorConfig) -> [Recording; 2] {
    let clip = generate(seed, 0, "clip", &Sensor::new(config).unwrap()).unwrap();
    [clip.truth, clip.view.measured]
}

fn recorded(recording: &Recording, settings: Settings) -> Player {
    Player::new(Source::Recording(Box::new(recording.clone())), settings).unwrap()
}

/// Everything that comes in so many seconds, asked for every so many milliseconds.
fn play(player: &mut Player, length: f64, milliseconds: i64) -> Vec<Outgoing> {
    let steps = (length * 1e3) as i64 / milliseconds;
    let at = |step: i64| NOW + Span(step * milliseconds * 1_000_000);
    (0..=steps).flat_map(|step| player.advance(at(step))).collect()
}

fn skeletons(sent: &[Outgoing]) -> Vec<&MultiDofJointState> {
    fn skeleton(sent: &Outgoing) -> Option<&MultiDofJointState> {
        match sent {
            Outgoing::Skeleton(skeleton) => Some(skeleton),
            _ => None,
        }
    }
    sent.iter().filter_map(skeleton).collect()
}

fn stamps(sent: &[Outgoing]) -> Vec<Stamp> {
    skeletons(sent).iter().map(|skeleton| skeleton.header.stamp.stamp()).collect()
}

fn places(skeleton: &MultiDofJointState) -> Vec<Point> {
    skeleton.transforms.iter().map(|transform| transform.translation.into()).collect()
}

#[test]
fn a_recording_comes_as_it_is_at_its_own_stamps() {
    let [truth, _] = clip(3, SensorConfig::ideal(30.0));
    let sent = play(&mut recorded(&truth, at_once()), 20.0, 7);
    let partner = truth.person(Role::Second).motion.frames();
    assert_eq!(skeletons(&sent).len(), partner.len());
    for (skeleton, frame) in skeletons(&sent).iter().zip(partner) {
        assert_eq!(skeleton.header.stamp.stamp(), NOW + (frame.stamp - Stamp(0)));
        assert_eq!(places(skeleton), frame.positions.to_vec());
        assert_eq!(skeleton.joint_names, truth.people()[1].motion.skeleton().names());
        assert_eq!(skeleton.header.frame_id, "world");
    }
    assert_eq!(sent.first(), Some(&Outgoing::Finished(false)));
    assert_eq!(sent.last(), Some(&Outgoing::Finished(true)));
    let robots = sent.iter().filter(|sent| sent.topic() == Topic::RobotSkeleton);
    let objects = sent.iter().filter(|sent| sent.topic() == Topic::ObjectPose);
    assert_eq!((robots.count(), objects.count()), (partner.len(), partner.len()));
}

#[test]
fn the_robot_stands_as_at_first_where_the_person_in_its_role_is() {
    let [truth, _] = clip(3, SensorConfig::ideal(30.0));
    let settings = Settings { role: Some("receiver".to_owned()), ..at_once() };
    let sent = play(&mut recorded(&truth, settings), 20.0, 10);
    let motion = &truth.person(Role::Second).motion;
    let base = motion.skeleton().root().index();
    let robots = sent.iter().filter_map(|sent| match sent {
        Outgoing::RobotSkeleton(robot) => Some(places(robot)),
        _ => None,
    });
    for (robot, frame) in robots.zip(motion.frames()) {
        assert!((robot[base] - frame.positions[base]).norm() < 1e-12);
        let turned = robot.iter().zip(&motion.frames()[0].positions);
        let shift = robot[base] - motion.frames()[0].positions[base];
        assert!(turned.into_iter().all(|(now, first)| (now - first - shift).norm() < 1e-12));
    }
}

#[test]
fn what_is_made_up_is_what_generate_makes() {
    for config in [SensorConfig::ideal(30.0), SensorConfig::kinect(30.0)] {
        let [_, measured] = clip(11, config.clone());
        let settings = Settings { seed: 11, sensor: config, ..at_once() };
        let mut player = Player::new(Source::generated(11).unwrap(), settings).unwrap();
        let sent = play(&mut player, 20.0, 10);
        let seen: Vec<_> = skeletons(&sent).into_iter().map(places).collect();
        let frames = measured.person(Role::Second).motion.frames().iter();
        assert_eq!(seen, frames.map(|frame| frame.positions.to_vec()).collect::<Vec<_>>());
    }
}

#[test]
fn equal_seeds_and_settings_give_equal_bytes_however_often_somebody_asks() {
    let sensor = SensorConfig::kinect(30.0);
    let settings = Settings { is_looped: true, sends_markers: true, sensor, ..at_once() };
    let bytes = |milliseconds: i64, seed: u64| -> Vec<Vec<u8>> {
        let settings = Settings { seed, ..settings.clone() };
        let mut player = Player::new(Source::generated(5).unwrap(), settings).unwrap();
        play(&mut player, 15.0, milliseconds).iter().map(Outgoing::bytes).collect()
    };
    assert_eq!(bytes(1, 5), bytes(50, 5));
    assert_ne!(bytes(50, 5), bytes(50, 6));
}

#[test]
fn speed_brings_frames_closer_and_rate_makes_others() {
    let [truth, _] = clip(3, SensorConfig::ideal(30.0));
    let fast = play(&mut recorded(&truth, Settings { speed: 4.0, ..at_once() }), 10.0, 10);
    let last = truth.stamps().last().unwrap();
    let ends = *stamps(&fast).last().unwrap() - NOW;
    assert!((ends.seconds() - last.seconds() / 4.0).abs() < 1e-8);
    let sampled = play(&mut recorded(&truth, Settings { rate: Some(50.0), ..at_once() }), 20.0, 10);
    let beats = stamps(&sampled);
    assert!(beats.windows(2).all(|pair| ((pair[1] - pair[0]).seconds() - 0.02).abs() < 1e-8));
    assert_eq!(beats.len(), (last.seconds() * 50.0).floor() as usize + 1);
}

#[test]
fn loops_pause_between_and_see_anew() {
    let [truth, _] = clip(3, SensorConfig::ideal(30.0));
    let sensor = SensorConfig { joint_noise: 0.01, ..SensorConfig::ideal(30.0) };
    let pause = seconds(0.75);
    let settings = Settings { is_looped: true, pause, sensor, ..at_once() };
    let length = truth.stamps().last().unwrap() - Stamp(0);
    let sent = play(&mut recorded(&truth, settings), 3.0 * length.seconds(), 10);
    let all = stamps(&sent);
    assert_eq!(all[truth.len()] - all[truth.len() - 1], pause);
    assert_eq!(all[truth.len()], NOW + length + pause);
    let shown = skeletons(&sent);
    assert_ne!(places(shown[4]), places(shown[truth.len() + 4]), "another noise");
    assert!(!sent.contains(&Outgoing::Finished(true)));
}

#[test]
fn paused_nothing_comes_and_nothing_is_left_out() {
    let [truth, _] = clip(3, SensorConfig::ideal(30.0));
    let mut player = recorded(&truth, at_once());
    let mut sent = play(&mut player, 1.0, 10);
    let paused = Settings { is_paused: true, ..at_once() };
    player.change(&paused).unwrap();
    let at = |milliseconds: i64| NOW + Span(milliseconds * 1_000_000);
    let still: Vec<_> = (101..300).flat_map(|step| player.advance(at(step * 10))).collect();
    assert_eq!((still, player.wait()), (Vec::new(), None));
    player.change(&at_once()).unwrap();
    sent.extend((300..2000).flat_map(|step| player.advance(at(step * 10))));
    let all = stamps(&sent);
    assert_eq!(all.len(), truth.len());
    let gaps: Vec<f64> = all.windows(2).map(|pair| (pair[1] - pair[0]).seconds()).collect();
    let longest = gaps.iter().copied().fold(0.0, f64::max);
    assert!((longest - 1.99 - 1.0 / 30.0).abs() < 0.011, "{longest}");
    assert_eq!(gaps.iter().filter(|gap| **gap > 0.05).count(), 1);
}

#[test]
fn speed_and_loop_change_while_it_runs() {
    let [truth, _] = clip(3, SensorConfig::ideal(30.0));
    let mut player = recorded(&truth, at_once());
    let mut sent = play(&mut player, 1.0, 10);
    player.change(&Settings { speed: 2.0, ..at_once() }).unwrap();
    sent.extend((101..1000).flat_map(|step| player.advance(NOW + Span(step * 10_000_000))));
    let all = stamps(&sent);
    assert_eq!(all.len(), truth.len());
    assert!(((all[40] - all[39]).seconds() - 1.0 / 60.0).abs() < 1e-6);
    assert!(player.is_over() && player.wait().is_none());
    player.change(&Settings { is_looped: true, ..at_once() }).unwrap();
    let again: Vec<_> =
        (1000..1200).flat_map(|step| player.advance(NOW + Span(step * 10_000_000))).collect();
    assert_eq!(again[0], Outgoing::Finished(false));
    assert!(stamps(&again)[0] >= NOW + seconds(9.99), "not in the past");
}

#[test]
fn another_sensor_sees_the_rest() {
    let [truth, _] = clip(3, SensorConfig::ideal(30.0));
    let mut player = recorded(&truth, at_once());
    let before = play(&mut player, 1.0, 10);
    let sensor = SensorConfig { frame_loss: 0.5, ..SensorConfig::ideal(30.0) };
    player.change(&Settings { sensor, ..at_once() }).unwrap();
    let after: Vec<_> =
        (101..1000).flat_map(|step| player.advance(NOW + Span(step * 10_000_000))).collect();
    let left = truth.len() - skeletons(&before).len();
    let seen = skeletons(&after).len();
    assert!((left / 4..left * 3 / 4).contains(&seen), "{seen} of {left}");
    let robots = after.iter().filter(|sent| sent.topic() == Topic::RobotSkeleton).count();
    assert_eq!(robots, left, "the robot knows where it is, and nothing comes twice");
    let bad = SensorConfig { frame_loss: 2.0, ..SensorConfig::ideal(30.0) };
    assert!(player.change(&Settings { sensor: bad, ..at_once() }).is_err());
}

#[test]
fn a_clock_of_its_own_goes_as_fast_as_it_plays_and_never_back() {
    let [truth, _] = clip(3, SensorConfig::ideal(30.0));
    let start = Some(seconds(100.0));
    let settings = Settings { has_clock: true, clock_start: start, speed: 4.0, ..at_once() };
    let sent = play(&mut recorded(&truth, settings), 4.0, 5);
    let mut clock = Stamp(0);
    for sent in &sent {
        match sent {
            Outgoing::Clock(message) => {
                assert!(message.clock.stamp() >= clock);
                clock = message.clock.stamp();
            }
            Outgoing::Skeleton(skeleton) => assert_eq!(skeleton.header.stamp.stamp(), clock),
            _ => {}
        }
    }
    assert_eq!(clock, Stamp(100_000_000_000) + seconds(16.0));
    let all = stamps(&sent);
    assert_eq!(all[0], Stamp(100_000_000_000));
    assert_eq!(
        all[9] - all[0],
        truth.stamps().nth(9).unwrap() - Stamp(0),
        "stamps are as recorded"
    );
    // Nobody says when: the recording's own time, but never 0, which means that there is none.
    let own = play(&mut recorded(&truth, Settings { has_clock: true, ..at_once() }), 1.0, 5);
    assert_eq!(stamps(&own)[0], Stamp(1_000_000_000));
}

#[test]
fn a_clock_that_is_set_moves_what_is_to_come() {
    let [truth, _] = clip(3, SensorConfig::ideal(30.0));
    let mut player = recorded(&truth, at_once());
    let before = skeletons(&play(&mut player, 1.0, 10)).len();
    for jump in [3600.0, -7200.0] {
        let there = NOW + seconds(1.0 + jump);
        assert!(player.advance(there).is_empty());
        assert_eq!(skeletons(&player.advance(there + seconds(0.0334))).len(), 1);
        player.advance(NOW + seconds(1.0));
    }
    let after: Vec<_> =
        (101..1000).flat_map(|step| player.advance(NOW + Span(step * 10_000_000))).collect();
    assert_eq!(before + 2 + skeletons(&after).len(), truth.len());
}

#[test]
fn whom_nobody_knows_the_robot_cannot_be() {
    let settings = Settings { role: Some("waiter".to_owned()), ..at_once() };
    let error = Player::new(Source::generated(1).unwrap(), settings).unwrap_err();
    assert_eq!(error.to_string(), "role is \"waiter\", must be giver or receiver");
}

#[test]
fn the_kind_of_a_sensor_and_its_figures_go_together() {
    let change = |name: &str, value: ParameterValue| vec![(name.to_owned(), value)];
    let mut table = ParameterTable::new(parameters("kinect"));
    assert_eq!(Settings::of(&table).sensor, SensorConfig::kinect(30.0));
    assert!(follow_ups(&table, &[]).is_empty());
    let lossy = table.set(&change("sensor.frame_loss", 0.5.into()), |_, _| Ok(())).unwrap();
    assert_eq!(follow_ups(&table, &lossy), change("sensor.kind", "custom".into()));
    table.start(follow_ups(&table, &lossy)).unwrap();
    let ideal = table.set(&change("sensor.kind", "ideal".into()), |_, _| Ok(())).unwrap();
    table.start(follow_ups(&table, &ideal)).unwrap();
    assert_eq!(Settings::of(&table).sensor, SensorConfig::ideal(30.0));
    let both = [change("sensor.kind", "kinect".into()), change("sensor.swap_rate", 9.into())];
    let both = table.set(&both.concat(), |_, _| Ok(())).unwrap();
    table.start(follow_ups(&table, &both)).unwrap();
    let expected = SensorConfig { swap_rate: 9.0, ..SensorConfig::kinect(30.0) };
    assert_eq!(Settings::of(&table).sensor, expected);
    assert_eq!(table.text("sensor.kind"), "custom");
}

#[test]
fn the_document_has_every_parameter_and_topic() {
    let document = include_str!("../../docs/simulator.md");
    for parameter in parameters("ideal") {
        let mark = if parameter.read_only.is_none() { "yes" } else { "no" };
        let row = format!(
            "| `{}` | `{}` | {} | {mark} | {} |",
            parameter.name,
            parameter.value,
            parameter.allowed(),
            parameter.description
        );
        assert!(document.contains(&row), "missing: {row}");
    }
    let rows = document.lines().filter(|line| line.starts_with("| `") && line.contains("| yes |"));
    let changeable = parameters("ideal").iter().filter(|p| p.read_only.is_none()).count();
    assert_eq!(rows.count(), changeable, "no other rows");
    for topic in Topic::ALL {
        let row = format!("| `{}` | {} |", topic.name(), topic.type_name());
        assert!(document.contains(&row), "missing: {row}");
    }
}

#[track_caller]
fn check_refused(arguments: &[&str], code: i32, words: &str) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_handover_sim")).arg("node").args(arguments).output();
    let output = output.unwrap();
    let talk = String::from_utf8_lossy(&output.stderr) + String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(code), "{talk}");
    assert!(talk.contains(words), "{talk}");
}

#[test]
fn help_lists_parameters_and_other_arguments_are_refused() {
    check_refused(&["--help"], 0, "sensor.frame_loss");
    check_refused(&["--help"], 0, "robot_skeleton");
    check_refused(&["clip.csv"], 2, "unexpected argument 'clip.csv'");
    #[cfg(not(feature = "ros"))]
    check_refused(&["--ros-args", "-p", "seed:=1"], 2, "built without ROS 2");
}

#[test]
fn a_recording_is_played_as_it_reads_back() {
    let [_, measured] = clip(4, SensorConfig::kinect(30.0));
    let text = csv::write_rounded(&measured).unwrap();
    let read =
        handover_mesh::formats::read(text.as_bytes(), "clip", handover_mesh::formats::UpAxis::Z)
            .unwrap();
    let sent = play(&mut recorded(&read, at_once()), 20.0, 10);
    let all = stamps(&sent);
    let expected: Vec<Stamp> =
        read.stamps().map(|stamp| NOW + (stamp - read.stamps().next().unwrap())).collect();
    assert_eq!(all, expected);
}

#[test]
fn before_it_begins_its_clock_stands_at_the_start() {
    let settings = Settings { has_clock: true, clock_start: Some(seconds(50.0)), ..at_once() };
    let mut player = Player::new(Source::generated(1).unwrap(), settings).unwrap();
    let time = |sent: &Outgoing| match sent {
        Outgoing::Clock(clock) => Some(clock.clock.stamp()),
        _ => None,
    };
    // However long it takes.
    for step in 0..300 {
        let sent = player.stand_by(NOW + seconds(f64::from(step)));
        assert_eq!(sent.as_ref().and_then(time), Some(Stamp(50_000_000_000)));
    }
    let sent = player.advance(NOW + seconds(299.01));
    assert_eq!(sent.iter().filter_map(time).next_back(), Some(Stamp(50_010_000_000)));
    assert!(sent.contains(&Outgoing::Finished(false)));
    let mut without = Player::new(Source::generated(1).unwrap(), at_once()).unwrap();
    assert_eq!(without.stand_by(NOW), None);
}
