//! What the gate lets through, and how well.

use handover_mesh::safety::{HoldReason, Proposal, SafetySettings};
use handover_mesh::{Point, Skeleton, Span, Vector};
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::scene::{STEP, gate, reach, reaching, right_hand, seconds, standing, window};

/// Settings for so many ticks a second.
fn at_rate(rate: f64) -> SafetySettings {
    let usual = SafetySettings::default();
    let lead = usual.lead.max(1.5 / rate);
    SafetySettings { lead, aim: usual.aim.max(lead), ..usual }
}

/// Follows a reach of 0.5 m in 0.8 s at these ticks a second; the largest distance of the hand
/// `[m]` to where it belongs.
///
/// - `noise`: `[m]`, standard deviation of each coordinate of what is proposed.
fn follow(rate: f64, noise: f64) -> f64 {
    // Recovered before it begins.
    let mut gate = gate(at_rate(rate));
    let pose = reach(Vector::new(0.2, 0.08, 0.45), 1.0, 0.8);
    let hand = right_hand(&Skeleton::nite());
    let (mut off, mut random) = (0.0f64, ChaCha8Rng::seed_from_u64(1));
    for tick in 0..(2.5 * rate) as u32 {
        let now = f64::from(tick) / rate;
        let mut poses = window(&pose, now);
        for coordinate in poses.iter_mut().flat_map(|place| place.coords.iter_mut()) {
            // A sum of four of variance 1/12 each.
            let sum: f64 = (0..4).map(|_| random.random_range(-0.5..0.5)).sum();
            *coordinate += noise * sum * 3.0f64.sqrt();
        }
        let target = gate.admit(Proposal::Move { poses: &poses, step: STEP }, None, seconds(now));
        let target = target.unwrap();
        assert!(noise > 0.0 || target.reason().is_none(), "{now} s");
        off = off.max((target.positions()[hand] - pose(now)[hand]).norm());
    }
    off
}

#[test]
fn a_human_reach_is_followed() {
    for rate in [20.0, 30.0, 100.0, 1000.0] {
        let off = [0.0, 0.001, 0.003].map(|noise| follow(rate, noise));
        println!(
            "{rate} Hz: off {:.4} m; {:.4} m with 1 mm of noise, {:.4} m with 3",
            off[0], off[1], off[2]
        );
        assert!(off[0] < 0.003 && off[1] < 0.01 && off[2] < 0.1, "{rate} Hz: {off:?}");
    }
}

#[test]
fn holding_stands_soon() {
    let pose = reach(Vector::new(0.2, 0.08, 0.45), 1.0, 0.8);
    let mut longest = 0.0f64;
    for hold_at in (0..25).map(|k| 1.0 + f64::from(k) * 0.033) {
        let mut gate = gate(SafetySettings::default());
        for tick in 0..200 {
            let now = f64::from(tick) / 30.0;
            let poses = window(&pose, now);
            let proposal = if now < hold_at {
                Proposal::Move { poses: &poses, step: STEP }
            } else {
                Proposal::Hold(HoldReason::Stale)
            };
            let target = gate.admit(proposal, None, seconds(now)).unwrap();
            if now >= hold_at {
                assert_eq!(target.reason(), Some(HoldReason::Stale));
                longest = longest.max(target.stands_in().seconds() + now - hold_at);
                if !target.is_moving() {
                    assert!(target.velocities().iter().all(|v| *v == Vector::zeros()));
                    break;
                }
            }
        }
    }
    println!("stands {longest:.3} s after hold");
    assert!(longest < 0.45, "{longest} s");
}

/// Goes to a pose that never changes; when it arrived `[s]`.
fn arrival(goal: &[Point], rate: f64) -> f64 {
    let mut gate = gate(at_rate(rate));
    for tick in 0..(20.0 * rate) as u32 {
        let now = f64::from(tick) / rate;
        let proposal = Proposal::Move { poses: goal, step: STEP };
        let target = gate.admit(proposal, None, seconds(now)).unwrap();
        let off = target.positions().iter().zip(goal).map(|(a, b)| (a - b).norm());
        if off.fold(0.0, f64::max) < 1e-3 {
            return now;
        }
    }
    panic!("never arrived at {rate} Hz");
}

#[test]
fn far_goals_are_reached() {
    let moved: Vec<Point> = standing().iter().map(|p| p + Vector::new(2.0, -1.0, 0.0)).collect();
    // Each bone reversed: no direction is nearer than any other.
    let reversed: Vec<Point> =
        standing().iter().map(|p| standing()[2] - (p - standing()[2])).collect();
    for rate in [10.0, 30.0, 1000.0] {
        let times = [&moved, &reversed].map(|goal| arrival(goal, rate));
        println!("{rate} Hz: 2.2 m in {:.2} s, reversed in {:.2} s", times[0], times[1]);
        assert!(times[0] < 4.5 && times[1] < 6.0, "{times:?}");
    }
}

#[test]
fn ticks_as_fast_as_slow_give_the_same_motion() {
    let goal = reaching(Vector::new(0.2, 0.08, 0.45));
    let times = [30.0, 1000.0].map(|rate| arrival(&goal, rate));
    assert!((times[0] - times[1]).abs() < 0.3, "{times:?}");
}

#[test]
fn motion_resumes_gently() {
    let settings = SafetySettings::default();
    let mut gate = gate(settings.clone());
    let goal: Vec<Point> = standing().iter().map(|p| p + Vector::new(3.0, 0.0, 0.0)).collect();
    let fastest = |gate: &mut handover_mesh::safety::SafetyGate, from: f64, to: f64, stop: bool| {
        let mut fastest = 0.0f64;
        let mut now = from;
        while now < to {
            let proposal = if stop {
                Proposal::Hold(HoldReason::Stopped)
            } else {
                Proposal::Move { poses: &goal, step: STEP }
            };
            let target = gate.admit(proposal, None, seconds(now)).unwrap();
            fastest = fastest.max(target.velocities()[0].norm());
            now += 0.01;
        }
        fastest
    };
    for start in [0.0, 10.0] {
        let gently = fastest(&mut gate, start, start + 0.2, false);
        let freely = fastest(&mut gate, start + 0.2, start + 1.5, false);
        assert!(
            gently < 0.6 * settings.speed && freely > 0.6 * settings.speed,
            "{gently} {freely}"
        );
        fastest(&mut gate, start + 1.5, start + 3.0, true);
    }
}

#[test]
fn a_late_tick_finds_the_robot_on_the_published_way() {
    let mut gate = gate(SafetySettings::default());
    let goal = reaching(Vector::new(0.2, 0.08, 0.45));
    let proposal = Proposal::Move { poses: &goal, step: STEP };
    let mut now = 0.0;
    for late in [0.01, 0.01, 0.033, 0.06, 0.12, 0.2, 0.01, 0.5, 30.0] {
        let target = gate.admit(proposal, None, seconds(now)).unwrap().clone();
        let mut promised = vec![Point::origin(); 15];
        let ahead = seconds(now + late) - seconds(now);
        target.positions_at(ahead, &mut promised);
        let mut last = promised.clone();
        target.positions_at(Span(i64::MAX), &mut last);
        now += late;
        let found = gate.admit(proposal, None, seconds(now)).unwrap();
        let off = found.positions().iter().zip(&promised).map(|(a, b)| (a - b).norm());
        assert!(off.fold(0.0, f64::max) < 1e-12);
        if ahead >= target.stands_in() {
            assert_eq!(promised, last, "stands");
        }
    }
}
