//! Stamps and receipts that repeat, run back, or are of another day.

use handover_mesh::filter::Doubt;
use handover_mesh::{Span, Stamp};

use super::{Stream, farthest, pose, stamp, times};

#[test]
fn without_news_the_person_is_stale() {
    let mut stream = Stream::new();
    assert_eq!(stream.filter.update(None, stamp(0.0)).err(), Some(Doubt::Nobody));
    stream.send_usual(0.0, 1.0);
    let last = 29.0 / 30.0;
    for since in [0.1, 0.19] {
        let partner = stream.filter.update(None, stamp(last + since)).unwrap();
        assert!(!partner.is_fresh() && partner.stamp() == stamp(last));
    }
    let doubt = stream.filter.update(None, stamp(last + 0.25)).unwrap_err();
    let Doubt::Stale(age) = doubt else { panic!("{doubt:?}") };
    assert!((age.seconds() - 0.25).abs() < 1e-6);
    let partner = stream.send(1.5, &pose(1.5)).unwrap();
    assert!(partner.is_fresh() && !partner.is_new());
    stream.filter.reset();
    assert_eq!(stream.filter.partner().err(), Some(Doubt::Nobody));
    // After a reset the clock may be any.
    assert!(stream.send(0.2, &pose(0.2)).unwrap().is_new());
}

#[test]
fn staleness_counts_from_receipt() {
    let mut stream = Stream::new();
    // Every message comes 0.3 s late.
    for time in times(30.0, 0.0, 1.0) {
        let found = stream.send_at(stamp(time), stamp(time + 0.3), &pose(time));
        assert!(found.is_ok(), "{:?}", found.err());
    }
}

#[test]
fn what_comes_twice_or_late_or_from_another_day_changes_nothing() {
    let mut stream = Stream::new();
    stream.send_usual(0.0, 1.0);
    let (last, now) = (stamp(29.0 / 30.0), stamp(1.0));
    let before = stream.filter.partner().unwrap().positions().to_vec();
    let wrong = [
        (last, Doubt::OutOfOrder),
        (Stamp(last.0 - 10), Doubt::OutOfOrder),
        (stamp(61.0), Doubt::FarFromNow(stamp(60.0) - stamp(0.0))),
        (Stamp(i64::MAX), Doubt::FarFromNow(Stamp(i64::MAX) - now)),
        (Stamp(i64::MIN), Doubt::FarFromNow(Span(i64::MIN))),
    ];
    for (seen, expected) in wrong {
        let partner = stream.send_at(seen, now, &pose(3.0)).unwrap();
        assert!(!partner.is_fresh() && partner.positions() == before, "{seen}");
        assert_eq!(stream.filter.ignored(), Some(expected));
    }
    stream.send_usual(1.0, 1.3);
    assert_eq!(stream.filter.ignored(), None);
    // Nothing else comes any more: then that is why.
    let late = stamp(1.2);
    for time in times(30.0, 1.3, 1.6) {
        let found = stream.send_at(late, stamp(time), &pose(0.5)).err();
        assert_eq!(found, (time > 1.48).then_some(Doubt::OutOfOrder), "{time} s");
    }
}

#[test]
fn a_clock_set_back_begins_anew() {
    let mut stream = Stream::new();
    stream.send_usual(500.0, 501.0);
    let mut doubts = 0;
    for time in times(30.0, 0.0, 1.5) {
        let found = stream.send(time, &pose(time));
        match found {
            // Until the person is stale they are shown as they were.
            Ok(partner) if !partner.is_fresh() => assert!(time < 0.21),
            Ok(partner) => {
                assert!(time > 0.49);
                assert_eq!(partner.is_new(), time < 0.51);
                assert!(farthest(partner.positions(), &pose(time)) < 0.03);
            }
            Err(doubt) => {
                assert_eq!(doubt, Doubt::OutOfOrder);
                assert!((0.2..0.5).contains(&time));
                doubts += 1;
            }
        }
    }
    assert!(doubts > 5);
}
