//! Who is taken for somebody who hands over, and who is not.

use std::f64::consts::TAU;

use handover_mesh::safety::HoldReason;
use handover_mesh::{Point, Vector};

use crate::handovers::{DURATION, Handover, pipeline};
use crate::runs::{HELD_OUT, Said, run, usual, whole};

/// Puts somebody to the robot for 4 s.
fn meet(partner: impl Fn(f64) -> Vec<Point>) -> Vec<Said> {
    let robot = Handover::new(HELD_OUT).giver(0.0);
    run(&mut pipeline(&usual(), &robot), |now| Some(partner(now)), &robot, 30.0, DURATION)
}

/// Checks that somebody is not followed once the belief has had a moment; how near they came to
/// what was demonstrated `[m]`.
#[track_caller]
fn check_strange(name: &str, said: &[Said]) -> f64 {
    let mut nearest = f64::INFINITY;
    for said in said.iter().filter(|said| said.now > 1.0) {
        assert_eq!(said.reason, Some(HoldReason::OffDemonstration), "{name}, {} s", said.now);
        nearest = nearest.min(said.distance);
    }
    nearest
}

#[test]
fn whoever_does_something_else_is_off_demonstration() {
    let standing = Handover::new(HELD_OUT).receiver(0.0);
    let feet = Point::new(standing[2].x, standing[2].y, 0.0);
    // On the back: up has become along.
    let lying = |place: &Point| {
        let from_feet = place - feet;
        feet + Vector::new(from_feet.z, from_feet.y, 0.3 - from_feet.x)
    };
    let lying = check_strange("lying", &meet(|_| standing.iter().map(lying).collect()));
    let dancing = |now: f64| {
        let mut pose = standing.clone();
        let wave = |joint: usize, turn: f64| {
            let phase = TAU * 0.8 * now + turn;
            Vector::new(0.2 * phase.cos(), 0.15 * phase.sin(), 0.2 + 0.25 * phase.sin())
                * if [5, 8].contains(&joint) { 2.0 } else { 1.0 }
        };
        for (joint, turn) in [(4, 0.0), (5, 0.5), (7, 3.1), (8, 3.6), (10, 1.0), (11, 1.2)] {
            pose[joint] += wave(joint, turn);
        }
        pose
    };
    let dancing = check_strange("dancing", &meet(dancing));
    let turned = |place: &Point| feet - (place - feet).xy().push(0.0) + Vector::z() * place.z;
    // As a pose it is one that was demonstrated; only not towards the robot.
    let away = meet(|now| Handover::new(HELD_OUT).receiver(now).iter().map(turned).collect());
    for said in &away {
        assert!(!said.is_familiar, "back turned, {} s: {} m", said.now, said.distance);
    }
    println!("at least {lying:.3} m away lying, {dancing:.3} dancing");
}

#[test]
fn whoever_does_as_demonstrated_is_never_off() {
    let mut farthest = 0.0f64;
    for seed in HELD_OUT..HELD_OUT + 8 {
        for said in whole(&Handover::new(seed)) {
            farthest = farthest.max(said.distance);
            assert!(said.is_familiar, "seed {seed}, {} s: {} m", said.now, said.distance);
            assert_ne!(said.reason, Some(HoldReason::OffDemonstration));
        }
    }
    println!("demonstrated: at most {farthest:.3} m away");
}
