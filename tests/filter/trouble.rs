//! Joints that are missing or somewhere else.

use handover_mesh::filter::{Doubt, Sighting};
use handover_mesh::{Point, Vector};

use super::{Stream, pose, stamp, times};

const NOWHERE: Point = Point::new(f64::NAN, f64::NAN, f64::NAN);

/// Hides joints for some time in the middle of the reach; how far off the right hand then is at
/// most `[m]`.
fn hide(joints: &[usize], span: f64) -> f64 {
    let mut stream = Stream::new();
    let hand = stream.right_hand();
    stream.send_usual(0.0, 1.2);
    let mut worst: f64 = 0.0;
    for time in times(30.0, 1.2, 1.2 + span) {
        let mut seen = pose(time);
        joints.iter().for_each(|joint| seen[*joint] = NOWHERE);
        let partner = stream.send(time, &seen).unwrap();
        assert!(!partner.is_tracked(hand) && !partner.is_lost(hand));
        worst = worst.max((partner.positions()[8] - pose(time)[8]).norm());
    }
    let time = 1.2 + span;
    let partner = stream.send(time, &pose(time)).unwrap();
    assert!(partner.is_tracked(hand));
    let after = (partner.positions()[8] - pose(time)[8]).norm();
    assert!(after < 0.05, "when it is back: {after} m");
    worst
}

#[test]
fn a_short_gap_of_a_hand_is_bridged() {
    let hand = hide(&[8], 0.2);
    let arm = hide(&[6, 7, 8], 0.2);
    println!(
        "reaching hand hidden for 0.2 s: {:.1} cm off, with its arm {:.1}",
        1e2 * hand,
        1e2 * arm
    );
    // It goes 20 cm in that time, as fast as in any reach.
    assert!(hand < 0.17 && arm < 0.19, "{hand} m, {arm} m");
}

#[test]
fn a_hand_away_for_long_is_lost_and_the_person_is_not() {
    let mut stream = Stream::new();
    let hand = stream.right_hand();
    stream.send_usual(0.0, 1.0);
    for time in times(30.0, 1.0, 2.0) {
        let mut seen = pose(time);
        seen[8] = NOWHERE;
        let partner = stream.send(time, &seen).unwrap();
        // Since 1.0 - 1/30 s it was not seen.
        assert_eq!(partner.is_lost(hand), time > 0.97 + 0.3, "{time}");
        let length = (partner.positions()[8] - partner.positions()[7]).norm();
        assert!((length - 0.25).abs() < 0.03, "fore-arm of {length} m");
    }
}

#[test]
fn a_person_without_base_or_trunk_is_lost() {
    for hidden in [&[2][..], &[0, 1, 3], &[0, 1, 2, 3, 4, 5, 6, 7, 8]] {
        let mut stream = Stream::new();
        stream.send_usual(0.0, 0.5);
        for time in times(30.0, 0.51, 1.2) {
            let mut seen = pose(time);
            hidden.iter().for_each(|joint| seen[*joint] = NOWHERE);
            let found = stream.send(time, &seen).map(|partner| {
                assert!((partner.positions()[2] - pose(time)[2]).norm() < 0.03);
            });
            let expected = if time < 0.77 { Ok(()) } else { Err(Doubt::Lost) };
            assert_eq!(found, expected, "{time} s without {hidden:?}");
        }
        stream.send_usual(1.2, 1.5);
    }
}

#[test]
fn legs_need_never_be_seen_and_arms_once() {
    let mut stream = Stream::new();
    for time in times(30.0, 0.0, 1.0) {
        let mut seen = pose(time);
        seen[9..].fill(NOWHERE);
        if time < 0.5 {
            seen[5] = NOWHERE;
            assert_eq!(stream.send(time, &seen).err(), Some(Doubt::Lost));
            continue;
        }
        let partner = stream.send(time, &seen).unwrap();
        assert_eq!(partner.is_new(), time == 0.5);
        // Nothing is kept of when the hand had no place.
        let mut out = seen.clone();
        partner.at(stamp(0.0), &mut out);
        assert!((out[5] - pose(0.5)[5]).norm() < 0.02);
        let feet = [11, 14].map(|foot| partner.positions()[foot]);
        assert!(feet.iter().all(|foot| foot.z.abs() < 0.2), "{feet:?}");
    }
}

#[test]
fn a_joint_seen_elsewhere_is_left_out_until_it_stays_there() {
    let mut stream = Stream::new();
    let hand = stream.right_hand();
    stream.send_usual(0.0, 0.9);
    let off = Vector::new(0.1, -0.5, 0.3);
    // Once, and it goes on.
    let mut seen = pose(0.9);
    seen[8] += off;
    let partner = stream.send(0.9, &seen).unwrap();
    assert!(!partner.is_tracked(hand));
    assert!((partner.positions()[8] - pose(0.9)[8]).norm() < 0.02);
    stream.send_usual(0.9 + 1.0 / 30.0, 4.0);
    assert!(stream.filter.partner().unwrap().is_tracked(hand));
    // For long.
    for time in times(30.0, 4.0, 5.0) {
        let mut seen = pose(time);
        seen[8] += off;
        let partner = stream.send(time, &seen).unwrap();
        assert_eq!(partner.is_tracked(hand), time > 4.29, "{time} s");
        if time > 4.5 {
            assert!((partner.positions()[8] - seen[8]).norm() < 0.02);
        }
    }
}

#[test]
fn the_torso_that_jumps_is_not_its_neighbours() {
    let mut stream = Stream::new();
    stream.send_usual(0.0, 0.9);
    let mut seen = pose(0.9);
    seen[2].z -= 0.3;
    let partner = stream.send(0.9, &seen).unwrap();
    let untracked: Vec<usize> = (0..15)
        .zip(partner.positions())
        .filter(|(joint, place)| (**place - pose(0.9)[*joint]).norm() > 0.02)
        .map(|(joint, _)| joint)
        .collect();
    assert!(untracked.is_empty(), "{untracked:?}");
}

#[test]
fn joints_of_little_confidence_are_not_seen() {
    let mut stream = Stream::new();
    stream.send_usual(0.0, 0.5);
    for (confidence, expected) in [(0.9, true), (0.1, false), (f64::NAN, false), (1e300, true)] {
        let mut filter = stream.filter.clone();
        let mut confidences = [1.0; 15];
        confidences[8] = confidence;
        let positions = pose(0.5);
        let sighting = Sighting {
            stamp: stamp(0.5),
            body: None,
            positions: &positions,
            confidences: &confidences,
        };
        let partner = filter.update(Some(&sighting), stamp(0.5)).unwrap();
        assert_eq!(partner.is_tracked(stream.right_hand()), expected, "{confidence}");
    }
}
