//! Somebody else under the same number, or the same person under another.

use handover_mesh::Vector;
use handover_mesh::filter::Doubt;

use super::{Stream, farthest, moved, pose, times};

const AWAY: Vector = Vector::new(1.2, 0.9, 0.0);

#[test]
fn another_number_at_the_same_place_is_the_same_person() {
    let mut stream = Stream::new();
    stream.send_usual(0.0, 1.0);
    stream.body = Some(9);
    stream.send_usual(1.0, 1.2);
    stream.body = None;
    stream.send_usual(1.2, 1.4);
    assert!(!stream.filter.partner().unwrap().is_new());
}

/// Somebody elsewhere from second 1 on, under a number.
#[track_caller]
fn check_stays_away(body: Option<u32>, expected: Doubt) {
    let mut stream = Stream::new();
    stream.send_usual(0.0, 1.0);
    stream.body = body;
    let mut news = Vec::new();
    for time in times(30.0, 1.0, 2.5) {
        let there = moved(&pose(time), 2.0, AWAY);
        match stream.send(time, &there) {
            Err(doubt) => {
                assert_eq!(doubt, expected, "{time} s");
                assert!(time < 1.49, "{time} s");
            }
            Ok(partner) => {
                assert!(time > 1.49 && farthest(partner.positions(), &there) < 0.06, "{time} s");
                news.extend(partner.is_new().then_some(time));
            }
        }
    }
    assert_eq!(news.len(), 1, "said once: {news:?}");
}

#[test]
fn whoever_stays_elsewhere_is_the_person_after_a_while() {
    check_stays_away(Some(1), Doubt::Jump);
    check_stays_away(None, Doubt::Jump);
    check_stays_away(Some(2), Doubt::Exchanged);
}

#[test]
fn whoever_is_back_was_never_away() {
    let mut stream = Stream::new();
    stream.send_usual(0.0, 1.0);
    for time in times(30.0, 1.0, 1.3) {
        assert_eq!(stream.send(time, &moved(&pose(time), 0.0, AWAY)).err(), Some(Doubt::Jump));
        // Between two sightings too.
        let between = stream.filter.update(None, super::stamp(time + 0.01));
        assert_eq!(between.err(), Some(Doubt::Jump));
    }
    let partner = stream.send(1.3, &pose(1.3)).unwrap();
    assert!(!partner.is_new());
    assert!(farthest(partner.positions(), &pose(1.3)) < 0.05);
}

#[test]
fn whoever_is_seen_all_over_the_room_is_nobody() {
    let mut stream = Stream::new();
    stream.send_usual(0.0, 1.0);
    for (k, time) in times(30.0, 1.0, 4.0).enumerate() {
        let shift = AWAY * (1.0 + (k % 3) as f64);
        assert_eq!(stream.send(time, &moved(&pose(time), 0.0, shift)).err(), Some(Doubt::Jump));
    }
}

#[test]
fn whoever_walks_is_not_doubted() {
    for rate in [15.0, 30.0, 120.0] {
        for speed in [1.0, 2.0] {
            let mut stream = Stream::new();
            for time in times(rate, 0.0, 4.0) {
                let way = Vector::x() * (speed * (time - 1.0).clamp(0.0, 1.5));
                let seen = moved(&pose(time), 0.0, way);
                let partner = stream.send(time, &seen).unwrap();
                assert_eq!(partner.is_new(), time == 0.0);
                assert!(farthest(partner.positions(), &seen) < 0.15, "{rate} Hz, {time} s");
            }
        }
    }
}
