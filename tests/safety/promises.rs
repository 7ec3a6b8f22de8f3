//! Separation, workspace, refusals.

use handover_mesh::safety::{HoldReason, PartnerBody, Proposal, SafetyGate, SafetySettings};
use handover_mesh::{Point, Skeleton, Vector};

use crate::checks::least_distance;
use crate::scene::{STEP, gate, partner, reaching, right_hand, seconds, standing, window};

fn run(
    gate: &mut SafetyGate,
    from: f64,
    duration: f64,
    goal: &[Point],
    partner: &PartnerBody,
) -> (Vec<Point>, Option<HoldReason>) {
    let mut now = from;
    loop {
        let proposal = Proposal::Move { poses: goal, step: STEP };
        let target = gate.admit(proposal, Some(partner), seconds(now)).unwrap();
        now += 1.0 / 30.0;
        if now > from + duration {
            return (target.positions().to_vec(), target.reason());
        }
    }
}

#[test]
fn the_robot_stops_before_the_partner_and_moves_away_again() {
    let (skeleton, hand) = (Skeleton::nite(), right_hand(&Skeleton::nite()));
    let mut gate = gate(SafetySettings::default());
    // A hand's goal in the partner's chest.
    let person = partner(0.6, -0.2);
    let goal = reaching(Vector::new(0.4, 0.0, 0.3));
    let (pose, reason) = run(&mut gate, 0.0, 3.0, &goal, &person);
    let distance = least_distance(&skeleton, &pose, &person);
    println!("stands {distance} m from the partner");
    assert!((0.2..0.25).contains(&distance), "{distance} m");
    assert_eq!(reason, Some(HoldReason::Separation));
    // The person comes nearer: the robot stands, and may only go away.
    let nearer = partner(0.5, -0.2);
    let (same, reason) = run(&mut gate, 3.0, 1.0, &goal, &nearer);
    assert_eq!(reason, Some(HoldReason::Separation));
    assert!((same[hand] - pose[hand]).norm() < 1e-9);
    let (_, reason) = run(&mut gate, 4.0, 0.1, &standing(), &nearer);
    assert_eq!(reason, Some(HoldReason::Separation), "too near still");
    let (away, reason) = run(&mut gate, 4.1, 2.0, &standing(), &nearer);
    assert_eq!(reason, None);
    assert!((away[hand] - standing()[hand]).norm() < 1e-3);
}

#[test]
fn a_partner_expected_to_come_nearer_is_kept_farther_from() {
    let person = partner(0.6, -0.2);
    let goal = reaching(Vector::new(0.4, 0.0, 0.3));
    let distances = [0.0, 1.6].map(|partner_speed| {
        let mut gate = gate(SafetySettings { partner_speed, ..SafetySettings::default() });
        let (pose, _) = run(&mut gate, 0.0, 0.8, &goal, &person);
        least_distance(&Skeleton::nite(), &pose, &person)
    });
    assert!(distances[1] > distances[0] + 0.02, "{distances:?}");
}

#[test]
fn the_workspace_is_not_left_and_may_be_entered() {
    let hand = right_hand(&Skeleton::nite());
    let goal = reaching(Vector::new(0.4, 0.0, 0.3));
    for (front, start) in [(0.4, 0.2), (0.1, 0.2)] {
        let workspace = Some([Point::new(-1.0, -1.0, 0.0), Point::new(front, 1.0, 2.0)]);
        let mut gate = gate(SafetySettings { workspace, ..SafetySettings::default() });
        let (pose, reason) = run(&mut gate, 0.0, 3.0, &goal, &PartnerBody::default());
        assert_eq!(reason, Some(HoldReason::Workspace));
        assert!(pose[hand].x <= f64::max(front, start) + 1e-9, "{}", pose[hand]);
        assert!(pose[hand].x > f64::max(front, start) - 0.03, "{}", pose[hand]);
        // Back in, from outside too.
        let back = reaching(Vector::new(-0.15, 0.0, 0.1));
        let (pose, reason) = run(&mut gate, 3.0, 3.0, &back, &PartnerBody::default());
        assert_eq!(reason, None);
        assert!(pose[hand].x < 0.06, "{}", pose[hand]);
    }
}

#[test]
fn what_makes_no_sense_holds() {
    let mut gate = gate(SafetySettings::default());
    let good = standing();
    let mut reason = |poses: &[Point], partner: Option<&PartnerBody>, now: f64| {
        let proposal = Proposal::Move { poses, step: STEP };
        gate.admit(proposal, partner, seconds(now)).unwrap().reason()
    };
    assert_eq!(reason(&good, None, 0.0), None);
    assert_eq!(reason(&good, None, 0.0), Some(HoldReason::Clock));
    assert_eq!(reason(&good, None, -1.0), Some(HoldReason::Clock));
    assert_eq!(reason(&good[1..], None, 0.1), Some(HoldReason::Unsolved));
    let nowhere = PartnerBody { neck: Some(Point::new(0.0, f64::NAN, 0.0)), ..partner(2.0, 0.0) };
    assert_eq!(reason(&good, Some(&nowhere), 0.2), Some(HoldReason::Lost));
    assert_eq!(reason(&good, Some(&partner(2.0, 0.0)), 0.3), None);

    assert!(!gate.start(&good, seconds(1.0)), "has started");
    gate.admit(Proposal::Hold(HoldReason::Stale), None, seconds(2.0)).unwrap();
    gate.reset();
    assert!(gate.admit(Proposal::Hold(HoldReason::Stale), None, seconds(3.0)).is_none());
    for (joint, place) in [(3, Point::new(f64::NAN, 0.0, 0.0)), (0, good[1])] {
        let mut bad = good.clone();
        bad[joint] = place;
        assert!(!gate.start(&bad, seconds(2.0)));
    }
    assert!(!gate.start(&good[1..], seconds(2.0)));
    assert!(!gate.is_started());
    assert!(gate.start(&good, seconds(-5.0)), "a new start may be at any time");
}

#[test]
fn slow_stops_are_planned_too() {
    // A stop from full speed takes 100 s.
    let settings = SafetySettings {
        speed: 10.0,
        acceleration: 0.1,
        jerk: 10.0,
        aim: 1.0,
        recover: 0.0,
        ..SafetySettings::default()
    };
    let mut gate = gate(settings);
    let person = partner(100.0, 0.0);
    // Faster and faster, at 0.04 m/s².
    let way = |time: f64| Vector::x() * (0.02 * time * time);
    let pose = |time: f64| standing().into_iter().map(move |p| p + way(time)).collect::<Vec<_>>();
    let mut now = 0.0;
    while now < 20.0 {
        let poses = window(&pose, now);
        let proposal = Proposal::Move { poses: &poses, step: STEP };
        let target = gate.admit(proposal, Some(&person), seconds(now)).unwrap();
        assert!(matches!(target.reason(), None | Some(HoldReason::Limits)), "{now} s");
        let off = target.positions()[2] - pose(now)[2];
        assert!(off.norm() < 1.0, "{now} s: {off}");
        now += 1.0 / 30.0;
    }
    let hold = Proposal::Hold(HoldReason::Stale);
    let target = gate.admit(hold, Some(&person), seconds(now)).unwrap();
    let stands_in = target.stands_in().seconds();
    println!("stands in {stands_in} s from {}", target.velocities()[2].x);
    assert!((8.0..60.0).contains(&stands_in), "{stands_in} s");
}
