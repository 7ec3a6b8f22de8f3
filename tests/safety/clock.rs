//! Time that does not go on as it should, and what is forgotten in mid-motion.

use handover_mesh::safety::{
    HoldReason, PartnerBody, Proposal, SafetyGate, SafetySettings, Target,
};
use handover_mesh::{Point, Skeleton, Span, Stamp, Vector};

use crate::checks::Watch;
use crate::scene::{STEP, gate, lengths, standing};

const PERIOD: Span = Span(10_000_000);

/// A gate in full motion, its proposal, its watch, and the stamp of its next tick.
fn moving() -> (SafetyGate, Vec<Point>, Watch, Stamp) {
    let mut gate = gate(SafetySettings::default());
    let goal: Vec<Point> = standing().iter().map(|p| p + Vector::new(3.0, 0.0, 0.0)).collect();
    let skeleton = Skeleton::nite();
    let lengths = lengths(&skeleton, &standing());
    let mut watch = Watch::new(skeleton, lengths, SafetySettings::default());
    let mut now = Stamp(0);
    for _ in 0..100 {
        let target = tick(&mut gate, &goal, &mut watch, now).unwrap();
        assert_eq!(target.reason(), None);
        now = now + PERIOD;
    }
    (gate, goal, watch, now)
}

#[track_caller]
fn tick(gate: &mut SafetyGate, goal: &[Point], watch: &mut Watch, now: Stamp) -> Option<Target> {
    let target = gate.admit(Proposal::Move { poses: goal, step: STEP }, None, now)?;
    watch.check(target, &PartnerBody::default(), Span(100_000_000));
    Some(target.clone())
}

fn speed(target: &Target) -> f64 {
    target.velocities()[2].norm()
}

#[test]
fn a_clock_that_is_set_stops_the_robot_and_no_more() {
    let hour = 3_600_000_000_000;
    for shift in [-1, -5_000_000, -30_000_000, -hour, hour, i64::MIN, i64::MAX] {
        let (mut gate, goal, mut watch, mut now) = moving();
        let last = Stamp(now.0 - PERIOD.0);
        let mut before = tick(&mut gate, &goal, &mut watch, last).unwrap();
        assert!(speed(&before) > 1.0);
        now = last + Span(shift);
        let mut ticks = 0;
        let next = |now: Stamp| if now == Stamp(i64::MAX) { Stamp(0) } else { now + PERIOD };
        loop {
            let target = tick(&mut gate, &goal, &mut watch, now).unwrap();
            assert_eq!(target.stamp(), now);
            // It goes on, slower and slower.
            assert!(ticks == 0 || speed(&target) < speed(&before), "{shift}");
            // At the end of time the clock stands, and can only be set back.
            now = next(now);
            before = target;
            if before.reason().is_none() {
                break;
            }
            assert_eq!(before.reason(), Some(HoldReason::Clock), "{shift}");
            ticks += 1;
        }
        assert!((2..50).contains(&ticks) && speed(&before) == 0.0, "{shift}: {ticks} ticks");
        for _ in 0..60 {
            before = tick(&mut gate, &goal, &mut watch, now).unwrap();
            assert_eq!(before.reason(), None, "{shift}");
            now = next(now);
        }
        assert!(speed(&before) > 0.5, "{shift}: moves again");
    }
}

#[test]
fn a_clock_that_runs_backwards_brings_it_to_a_stand() {
    let (mut gate, goal, mut watch, mut now) = moving();
    for k in 0..60 {
        now = now + Span(-20_000_000);
        let target = tick(&mut gate, &goal, &mut watch, now).unwrap();
        assert_eq!(target.reason(), Some(HoldReason::Clock));
        assert!(k < 50 || !target.is_moving());
        // The same again says the same.
        let same = tick(&mut gate, &goal, &mut watch, now).unwrap();
        assert_eq!(same.positions(), target.positions());
        assert_eq!(same.velocities(), target.velocities());
    }
}

#[test]
fn a_reset_does_not_cut_a_motion_off() {
    let (mut gate, goal, mut watch, mut now) = moving();
    gate.reset();
    let mut stood = None;
    for _ in 0..50 {
        assert!(gate.is_started() && !gate.start(&standing(), now), "moves still");
        let target = tick(&mut gate, &goal, &mut watch, now).unwrap();
        assert_eq!(target.reason(), Some(HoldReason::NoRobot));
        now = now + PERIOD;
        gate.reset();
        if !target.is_moving() {
            stood = Some(target);
            break;
        }
    }
    assert_eq!(speed(&stood.unwrap()), 0.0);
    assert!(!gate.is_started());
    assert!(tick(&mut gate, &goal, &mut watch, now).is_none(), "has to say where it is");
    assert!(gate.start(&standing(), now));
    let target = gate.admit(Proposal::Hold(HoldReason::Stale), None, now).unwrap();
    assert_eq!((target.reason(), speed(target)), (Some(HoldReason::Stale), 0.0));
}
