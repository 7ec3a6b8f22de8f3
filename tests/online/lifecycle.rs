//! Before the robot has said where it is, cancelled, reset.

use handover_mesh::filter::Sighting;
use handover_mesh::online::{Pipeline, TickInput};
use handover_mesh::safety::HoldReason;
use handover_mesh::{Point, Stamp};

use crate::handovers::{DURATION, FRAME, Handover, pipeline};
use crate::runs::{HAND, HELD_OUT, run, usual};

#[test]
fn without_a_robot_there_is_no_target() {
    let handover = Handover::new(HELD_OUT);
    let robot = handover.giver(0.0);
    let mut pipeline = pipeline(&usual(), &robot);
    let broken = vec![Point::new(f64::NAN, 0.0, 0.0); robot.len()];
    for frame in 0..90 {
        let stamp = Stamp(frame * FRAME);
        let positions = handover.receiver(stamp.seconds());
        let sighting = Sighting { stamp, body: None, positions: &positions, confidences: &[] };
        // Nothing, nonsense, and at last where it is.
        let said = match frame {
            0..30 => None,
            30..60 => Some(broken.as_slice()),
            _ => Some(robot.as_slice()),
        };
        let input = TickInput { now: stamp, sighting: Some(sighting), robot: said };
        let tick = pipeline.tick(&input);
        if frame < 60 {
            assert!(tick.target.is_none() && tick.solved.is_none() && tick.partner.is_none());
            assert_eq!(tick.reason, Some(HoldReason::NoRobot));
        } else {
            let target = tick.target.unwrap();
            assert!((target.positions()[HAND] - robot[HAND]).norm() < 1.0);
            assert!(tick.partner.is_some());
        }
    }
}

#[test]
fn cancelled_holds_until_reset() {
    let handover = Handover::new(HELD_OUT);
    let robot = handover.giver(0.0);
    let mut pipeline = pipeline(&usual(), &robot);
    let mut stood: Option<Vec<Point>> = None;
    for frame in 0..240 {
        let stamp = Stamp(frame * FRAME);
        if frame == 45 {
            pipeline.cancel();
        }
        if frame == 120 {
            pipeline.reset();
        }
        let time = stamp.seconds() - if frame < 120 { 0.0 } else { 4.0 };
        let positions = handover.receiver(time);
        let sighting = Sighting { stamp, body: None, positions: &positions, confidences: &[] };
        let robot = (frame != 120).then_some(robot.as_slice());
        let tick = pipeline.tick(&TickInput { now: stamp, sighting: Some(sighting), robot });
        match frame {
            0 => assert!(tick.target.is_some()),
            1..45 => assert!(matches!(tick.reason, None | Some(HoldReason::Limits))),
            45..120 => {
                assert_eq!(tick.reason, Some(HoldReason::Cancelled));
                let target = tick.target.unwrap();
                // The person is seen all the same: the robot keeps its distance while it brakes.
                let seen = tick.partner.unwrap();
                assert!((seen[2] - positions[2]).norm() < 0.1);
                if frame >= 75 {
                    assert!(!target.is_moving(), "frame {frame}");
                    let stood = stood.get_or_insert(target.positions().to_vec());
                    assert_eq!(stood, target.positions());
                }
            }
            120 => assert!(tick.target.is_none()),
            _ => {}
        }
        if frame == 180 {
            let moved = tick.target.unwrap().positions()[HAND] - handover.giver(0.0)[HAND];
            assert!(tick.reason.is_none() && moved.norm() > 0.1, "{:?}, {moved}", tick.reason);
        }
    }
}

/// One pipeline that had another handover before, and a reset once it stood, says to the bit what a
/// new one does.
#[test]
fn after_a_reset_it_is_as_new() {
    let [before, after] = [Handover::new(HELD_OUT), Handover::new(HELD_OUT + 1)];
    let targets = |pipeline: &mut Pipeline| {
        let robot = after.giver(0.0);
        let said = run(pipeline, |now| Some(after.receiver(now)), &robot, 30.0, DURATION);
        said.into_iter().map(|said| said.places).collect::<Vec<_>>()
    };
    let robot = after.giver(0.0);
    let mut used = pipeline(&usual(), &robot);
    // In the end nobody is there, and it stands.
    let partner = |now: f64| (now < 3.0).then(|| before.receiver(now));
    run(&mut used, partner, &robot, 30.0, DURATION + 2.0);
    used.reset();
    let (used, new) = (targets(&mut used), targets(&mut pipeline(&usual(), &robot)));
    for (tick, (used, new)) in used.iter().zip(&new).enumerate() {
        assert_eq!(used, new, "tick {tick}");
    }
}

/// Skeletons that show nobody are as good as none: after a while the robot will go on gently.
#[test]
fn whoever_is_not_known_for_long_stops_it_whatever_the_sensor_sends() {
    let handover = Handover::new(HELD_OUT);
    let robot = handover.giver(0.0);
    let nobody = vec![Point::new(f64::NAN, f64::NAN, f64::NAN); robot.len()];
    let partner = |now: f64| Some(if now < 2.0 { handover.receiver(now) } else { nobody.clone() });
    let said = run(&mut pipeline(&usual(), &robot), partner, &robot, 30.0, 5.0);
    let at = |time: f64| said.iter().find(|said| said.now >= time).unwrap().reason;
    assert_eq!(at(2.8), Some(HoldReason::Lost));
    assert_eq!(at(3.5), Some(HoldReason::Stopped));
    assert_eq!(at(4.9), Some(HoldReason::Stopped));
}
