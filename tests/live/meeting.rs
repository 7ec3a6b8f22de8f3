//! Somebody is met.

use handover_mesh::filter::Sighting;
use handover_mesh::live::Inputs;
use handover_mesh::messages::{Header, Pose, PoseStamped, Time};
use handover_mesh::online::{Pipeline, TickInput};
use handover_mesh::safety::HoldReason;
use handover_mesh::{NodeSettings, Point, RobotState, Skeleton, Stamp, Vector, geometry};

use super::handovers::{DURATION, FRAME, Handover, lengths};
use super::{EPOCH, body, first, inputs, live, model};

/// The right hand's place in the skeleton's order.
const HAND: usize = 8;

#[test]
fn what_is_published_is_the_ticks_target_to_the_bit() {
    let handover = Handover::new(100);
    let robot = handover.giver(0.0);
    let mut pipeline = Pipeline::new(model(), &lengths(&robot), true).unwrap();
    let mut live = live(NodeSettings { approach: 1.0, ..NodeSettings::default() });
    let mut states = Vec::new();
    for frame in 0..(DURATION * 1e9) as i64 / FRAME {
        let now = Stamp(EPOCH + frame * FRAME);
        let seen = handover.receiver((frame * FRAME) as f64 / 1e9);
        let sighting = Sighting { stamp: now, body: None, positions: &seen, confidences: &[] };
        let input = TickInput { now, sighting: Some(sighting), robot: Some(&robot) };
        let target = pipeline.tick(&input).target.unwrap();
        let said = inputs(Some(body(now, None, &seen)), body(now, None, &robot));
        let outputs = live.tick(now, &said, None);
        let trajectory = outputs.joint_targets.unwrap();
        assert_eq!(first(&trajectory), target.positions());
        assert_eq!(trajectory.header.stamp.stamp(), now);
        let last = trajectory.points.last().unwrap();
        assert_eq!(last.time_from_start.span(), target.stands_in());
        if states.last() != Some(&outputs.state.data) {
            states.push(outputs.state.data.clone());
        }
        let hand = outputs.hand_target.unwrap().pose;
        assert_eq!(Point::from(hand.position), target.positions()[HAND]);
        let q = hand.orientation;
        let turn = nalgebra::Quaternion::new(q.w, q.x, q.y, q.z);
        assert!((turn.norm() - 1.0).abs() < 1e-9);
        let forearm = target.positions()[HAND] - target.positions()[HAND - 1];
        let ahead = nalgebra::UnitQuaternion::from_quaternion(turn) * Vector::x();
        assert!((ahead - forearm.normalize()).norm() < 1e-6, "x is along the forearm");
    }
    assert_eq!(states, ["idle", "approach", "contact", "retreat"]);
}

#[test]
fn the_whole_scene_may_be_in_another_frame() {
    let handover = Handover::new(101);
    let world_from_sensor = geometry::yaw_isometry(0.7, Vector::new(1.0, -2.0, 0.5));
    let node = NodeSettings {
        sensor_frame: "camera".to_owned(),
        world_from_sensor,
        ..NodeSettings::default()
    };
    let (mut here, mut there) = (live(NodeSettings::default()), live(node));
    let robot = handover.giver(0.0);
    for frame in 0..40 {
        let now = Stamp(EPOCH + frame * FRAME);
        let seen = handover.receiver((frame * FRAME) as f64 / 1e9);
        let as_is = inputs(Some(body(now, None, &seen)), body(now, None, &robot));
        let mut moved = as_is.clone();
        for body in moved.bodies.iter_mut().chain(&mut moved.robot) {
            body.frame = "camera".to_owned();
            for (_, place) in &mut body.joints {
                *place = world_from_sensor.inverse() * *place;
            }
        }
        let targets = [here.tick(now, &as_is, None), there.tick(now, &moved, None)]
            .map(|outputs| first(&outputs.joint_targets.unwrap()));
        for (one, other) in targets[0].iter().zip(&targets[1]) {
            assert!((one - other).norm() < 1e-6, "frame {frame}");
        }
    }
}

#[test]
fn of_several_people_the_nearest_is_met_and_kept() {
    let handover = Handover::new(102);
    let [mut live, mut alone] = [(); 2].map(|()| live(NodeSettings::default()));
    let robot = handover.giver(0.0);
    for frame in 0..80 {
        let now = Stamp(EPOCH + frame * FRAME);
        let seen = handover.receiver((frame * FRAME) as f64 / 1e9);
        // Somebody passes by, and is the nearest for a while.
        let aside = if frame > 30 { 0.6 } else { 2.5 };
        let other: Vec<Point> =
            robot.iter().map(|place| place + Vector::new(0.2, aside, 0.0)).collect();
        let partner = body(now, Some(9), &seen);
        let bodies = vec![body(now, Some(4), &other), partner.clone()];
        let said = Inputs { bodies, robot: Some(body(now, None, &robot)), ..Inputs::default() };
        let outputs = live.tick(now, &said, None);
        let expected = alone.tick(now, &inputs(Some(partner), body(now, None, &robot)), None);
        assert_eq!(outputs.joint_targets, expected.joint_targets, "frame {frame}");
        let status = outputs.diagnostics.map(|array| array.status[0].clone());
        let partner =
            status.map(|status| status.values.into_iter().find(|value| value.key == "partner"));
        assert!(partner.is_none_or(|partner| partner.unwrap().value == "9"));
    }
}

#[test]
fn a_robot_that_says_nothing_begins_as_demonstrated() {
    let handover = Handover::new(103);
    let base = handover.giver(0.0)[Skeleton::nite().root().index()];
    // The givers look along x.
    let world_from_base = geometry::yaw_isometry(0.0, base.coords);
    let node = NodeSettings {
        robot_state: RobotState::Demonstrated,
        world_from_base,
        ..NodeSettings::default()
    };
    let mut live = live(node);
    let begin = live.tick(Stamp(EPOCH), &Inputs::default(), None);
    assert_eq!(begin.reason, Some(HoldReason::NoPartner));
    let pose = first(&begin.joint_targets.unwrap());
    for (place, giver) in pose.iter().zip(handover.giver(0.0)) {
        assert!((place - giver).norm() < 0.15, "{place} {giver}");
    }
    // After a reset it is where it was told to be, and need not say so.
    live.reset();
    let outputs = live.tick(Stamp(EPOCH + FRAME), &Inputs::default(), None);
    for (place, before) in first(&outputs.joint_targets.unwrap()).iter().zip(&pose) {
        assert!((place - before).norm() < 1e-9, "{place} {before}");
    }
}

#[test]
fn the_hands_target_goes_on_while_the_robot_holds() {
    let handover = Handover::new(107);
    let mut live = live(NodeSettings::default());
    let robot = handover.giver(0.0);
    let mut last = None;
    for frame in 0..60 {
        let now = Stamp(EPOCH + frame * FRAME);
        let seen = handover.receiver((frame * FRAME) as f64 / 1e9);
        let partner = (frame < 45).then(|| body(now, None, &seen));
        let outputs = live.tick(now, &inputs(partner, body(now, None, &robot)), None);
        let place = first(&outputs.joint_targets.unwrap())[HAND];
        assert_eq!(Point::from(outputs.hand_target.unwrap().pose.position), place);
        last = Some((place, outputs.reason));
    }
    let (place, reason) = last.unwrap();
    assert_eq!(reason, Some(HoldReason::Stale));
    assert!((place - robot[HAND]).norm() > 0.1, "it had moved, and stands there");
}

#[test]
fn what_is_old_is_not_where_anything_is() {
    let handover = Handover::new(108);
    let mut live = live(NodeSettings::default());
    let (now, old) = (Stamp(EPOCH), Stamp(EPOCH - 3_000_000_000));
    let said = inputs(None, body(old, None, &handover.giver(0.0)));
    let outputs = live.tick(now, &said, None);
    assert_eq!(outputs.reason, Some(HoldReason::NoRobot));
    let message = &outputs.diagnostics.unwrap().status[0].message;
    assert!(message.contains("robot_skeleton: its stamp is 3.000 s old"), "{message}");
    // A report is no place to begin at for long: after a reset the robot says it anew.
    let said = inputs(None, body(now, None, &handover.giver(0.0)));
    assert!(live.tick(now, &said, None).joint_targets.is_some());
    live.reset();
    let later = Stamp(now.0 + FRAME);
    assert_eq!(live.tick(later, &Inputs::default(), None).reason, Some(HoldReason::NoRobot));
}

#[test]
fn a_robot_that_does_as_told_begins_where_it_stood() {
    let handover = Handover::new(109);
    let base = handover.giver(0.0)[Skeleton::nite().root().index()];
    let node = NodeSettings {
        robot_state: RobotState::Demonstrated,
        world_from_base: geometry::yaw_isometry(0.0, base.coords),
        ..NodeSettings::default()
    };
    let mut before = live(node.clone());
    for frame in 0..45 {
        let now = Stamp(EPOCH + frame * FRAME);
        let seen = handover.receiver((frame * FRAME) as f64 / 1e9);
        let bodies = vec![body(now, None, &seen)];
        before.tick(now, &Inputs { bodies, ..Inputs::default() }, None);
    }
    let (stand, from) = before.standstill().unwrap();
    assert!(from > Stamp(EPOCH + 44 * FRAME));
    let mut after = live(node);
    after.begin_at(&stand);
    let targets = after.tick(from, &Inputs::default(), None).joint_targets.unwrap();
    for (place, stood) in first(&targets).iter().zip(&stand) {
        assert!((place - stood).norm() < 1e-9);
    }
    assert_eq!(targets.points.len(), 1, "it stands");
}

#[test]
fn called_off_it_stands_until_it_is_reset() {
    let handover = Handover::new(104);
    let mut live = live(NodeSettings::default());
    let robot = handover.giver(0.0);
    let mut ticks = 0..;
    let mut tick = |live: &mut handover_mesh::live::Live| {
        let frame = ticks.next().unwrap();
        let now = Stamp(EPOCH + frame * FRAME);
        let seen = handover.receiver((frame * FRAME) as f64 / 1e9);
        live.tick(now, &inputs(Some(body(now, None, &seen)), body(now, None, &robot)), None)
    };
    // Even before the robot has said where it is.
    live.cancel();
    for _ in 0..30 {
        let outputs = tick(&mut live);
        assert_eq!(outputs.reason, Some(HoldReason::Cancelled));
        assert_eq!(outputs.state.data, "hold");
    }
    live.reset();
    let moved = (0..30).filter(|_| tick(&mut live).reason.is_none()).count();
    assert!(moved > 20, "{moved}");
}

#[test]
fn a_robot_is_known_by_a_whole_report() {
    let handover = Handover::new(105);
    let mut live = live(NodeSettings::default());
    let mut part = body(Stamp(EPOCH), None, &handover.giver(0.0));
    part.joints.truncate(9);
    let said = Inputs { robot: Some(part), ..Inputs::default() };
    let outputs = live.tick(Stamp(EPOCH), &said, None);
    assert_eq!((outputs.joint_targets, outputs.reason), (None, Some(HoldReason::NoRobot)));
    let status = &outputs.diagnostics.unwrap().status[0];
    assert!(status.message.contains("robot_skeleton: without left_hip, left_knee"), "{status:?}");
    // Of later ones a part is enough.
    for count in [15, 3] {
        let mut robot = body(Stamp(EPOCH), None, &handover.giver(0.0));
        robot.joints.truncate(count);
        let said = Inputs { robot: Some(robot), ..Inputs::default() };
        assert!(live.tick(Stamp(EPOCH + 15 - count as i64), &said, None).joint_targets.is_some());
    }
}

#[test]
fn the_object_says_whether_hands_that_meet_have_it() {
    let handover = Handover::new(106);
    let robot = handover.giver(0.0);
    let contact = |lifted: f64| {
        let mut live = live(NodeSettings::default());
        (0..(DURATION * 1e9) as i64 / FRAME).any(|frame| {
            let now = Stamp(EPOCH + frame * FRAME);
            let time = (frame * FRAME) as f64 / 1e9;
            let mut said =
                inputs(Some(body(now, None, &handover.receiver(time))), body(now, None, &robot));
            let held = handover.giver(time)[HAND] + Vector::new(0.0, 0.0, lifted);
            said.object = Some(PoseStamped {
                header: Header { stamp: Time::of(now), frame_id: String::new() },
                pose: Pose { position: held.into(), ..Pose::default() },
            });
            live.tick(now, &said, None).state.data == "contact"
        })
    };
    assert!(contact(0.0) && !contact(1.5));
}
