//! Where the scene stands and how often the tick comes make no difference.

use std::f64::consts::FRAC_PI_3;

use handover_mesh::geometry::yaw_isometry;
use handover_mesh::{Point, Vector};

use crate::handovers::{DURATION, Handover, pipeline};
use crate::runs::{HELD_OUT, Said, farthest, run, usual};

#[test]
fn targets_move_with_the_scene() {
    let handover = Handover::new(HELD_OUT);
    let robot = handover.giver(0.0);
    let here = run(
        &mut pipeline(&usual(), &robot),
        |now| Some(handover.receiver(now)),
        &robot,
        30.0,
        DURATION,
    );
    for (yaw, shift) in
        [(0.0, Vector::new(3.0, -2.0, 0.4)), (FRAC_PI_3, Vector::zeros()), (2.9, Vector::x())]
    {
        let there_from_here = yaw_isometry(yaw, shift);
        let all = |pose: Vec<Point>| -> Vec<Point> {
            pose.iter().map(|place| there_from_here * place).collect()
        };
        let there = run(
            &mut pipeline(&usual(), &robot),
            |now| Some(all(handover.receiver(now))),
            &all(robot.clone()),
            30.0,
            DURATION,
        );
        let off = here.iter().zip(&there).map(|(here, there)| {
            assert_eq!(here.reason, there.reason);
            farthest(&all(here.places.clone()), &there.places)
        });
        let off = off.fold(0.0, f64::max);
        println!("turned by {yaw} rad, moved by {:?}: {off:.1e} m off", shift.as_slice());
        assert!(off < 1e-6, "{off} m");
    }
}

#[test]
fn the_rate_of_ticks_makes_little_difference() {
    let handover = Handover::new(HELD_OUT);
    let robot = handover.giver(0.0);
    // Multiples of 30 Hz, so that instants are the same; ticks between sightings see none.
    let at = |rate: usize| {
        let partner = |now| Some(handover.receiver(now));
        let said = run(&mut pipeline(&usual(), &robot), partner, &robot, rate as f64, 2.5);
        said.into_iter().step_by(rate / 30).collect::<Vec<_>>()
    };
    let [slow, medium, fast] = [30, 90, 990].map(at);
    let off = |a: &[Said], b: &[Said], from: f64| {
        let pairs = a.iter().zip(b).filter(|(a, _)| a.now >= from);
        let off = pairs.map(|(a, b)| {
            assert!((a.now - b.now).abs() < 1e-6 && a.distance == b.distance);
            farthest(&a.places, &b.places)
        });
        off.fold(0.0, f64::max)
    };
    let met = handover.contact;
    println!(
        "30 Hz is {:.3} m off 90 Hz, {:.3} from contact on; 90 Hz {:.3} m and {:.3} off 990 Hz",
        off(&slow, &medium, 0.0),
        off(&slow, &medium, met),
        off(&medium, &fast, 0.0),
        off(&medium, &fast, met),
    );
    assert!(off(&medium, &fast, 0.0) < 0.01);
    // A jump of what is believed the gate follows worse at 30 Hz.
    assert!(off(&slow, &medium, 0.0) < 0.03);
    assert!(off(&slow, &medium, met) < 0.01);
}
