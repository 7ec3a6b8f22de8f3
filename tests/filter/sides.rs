//! Left and right under each other's names.

use handover_mesh::Point;

use super::{Stream, farthest, moved, pose, times};

const ARMS: [[usize; 2]; 3] = [[3, 6], [4, 7], [5, 8]];
const LEGS: [[usize; 2]; 3] = [[9, 12], [10, 13], [11, 14]];

fn exchanged(pose: &[Point], pairs: &[[usize; 2]]) -> Vec<Point> {
    let mut pose = pose.to_vec();
    pairs.iter().for_each(|[left, right]| pose.swap(*left, *right));
    pose
}

#[track_caller]
fn check_mended(pairs: &[[usize; 2]]) {
    for rate in [15.0, 30.0, 120.0] {
        let mut stream = Stream::new();
        for time in times(rate, 0.0, 4.0) {
            let is_wrong = (1.2..1.7).contains(&time);
            let seen = if is_wrong { exchanged(&pose(time), pairs) } else { pose(time) };
            let partner = stream.send(time, &seen).unwrap();
            assert_eq!(partner.swapped(), is_wrong, "{rate} Hz, {time} s");
            let off = farthest(partner.positions(), &pose(time));
            assert!(off < 0.04, "{rate} Hz, {time} s: {off} m");
        }
    }
}

#[test]
fn exchanged_arms_are_mended() {
    check_mended(&ARMS);
}

#[test]
fn an_exchanged_body_is_mended() {
    check_mended(&[ARMS, LEGS].concat());
}

#[test]
fn labels_exchanged_for_long_are_believed_once() {
    let mut stream = Stream::new();
    stream.send_usual(0.0, 1.5);
    let mut news = 0;
    for time in times(30.0, 1.5, 4.0) {
        let seen = exchanged(&pose(time), &ARMS);
        let partner = stream.send(time, &seen).unwrap();
        assert_eq!(partner.swapped(), time < 2.51, "{time} s");
        news += i32::from(partner.is_new());
        if time > 2.51 {
            assert!(farthest(partner.positions(), &seen) < 0.04, "{time} s");
        }
    }
    assert_eq!(news, 1);
}

#[test]
fn wrong_labels_at_the_start_are_not_kept() {
    for wrong in [0.03, 0.1, 0.3] {
        let mut stream = Stream::new();
        for time in times(30.0, 0.0, 2.0) {
            let is_wrong = time < wrong;
            let seen = if is_wrong { exchanged(&pose(time), &ARMS) } else { pose(time) };
            let partner = stream.send(time, &seen).unwrap();
            if time > 2.0 * wrong + 0.1 {
                assert!(!partner.swapped());
                assert!(farthest(partner.positions(), &pose(time)) < 0.04, "{wrong} s, {time} s");
            }
        }
    }
}

#[test]
fn a_body_that_turns_keeps_its_sides() {
    // A whole turn within a second; to the left, then to the right.
    for rate in [15.0, 30.0, 120.0] {
        let mut stream = Stream::new();
        for time in times(rate, 0.0, 4.0) {
            let turned = (time - 1.0).clamp(0.0, 1.0) - (time - 2.0).clamp(0.0, 1.0);
            let seen =
                moved(&pose(0.0), turned * std::f64::consts::TAU, handover_mesh::Vector::zeros());
            let partner = stream.send(time, &seen).unwrap();
            assert!(!partner.swapped(), "{rate} Hz, {time} s");
            let off = farthest(partner.positions(), &seen);
            assert!(off < 0.15, "{rate} Hz, {time} s: {off} m");
        }
    }
}

#[test]
fn crossed_hands_keep_their_sides() {
    for rate in [15.0, 30.0] {
        let mut stream = Stream::new();
        for time in times(rate, 0.0, 4.0) {
            // The hands pass each other in front, four times.
            let across = 0.3 * (std::f64::consts::PI * time).cos();
            let mut seen = pose(0.0);
            seen[5] = Point::new(0.2, across, 1.1);
            seen[8] = Point::new(0.25, -across, 1.1);
            seen[4].y = 0.22 + 0.3 * (across - 0.3).abs() * 0.5;
            let partner = stream.send(time, &seen).unwrap();
            assert!(!partner.swapped(), "{rate} Hz, {time} s");
        }
    }
}
