//! How the robot goes with a partner who is slower, faster, stops, or withdraws.

use crate::handovers::Handover;
use crate::runs::{HAND, HELD_OUT, Said, follow, off};

/// What was said nearest to a time `[s]`.
fn at(said: &[Said], time: f64) -> &Said {
    said.iter().min_by(|a, b| (a.now - time).abs().total_cmp(&(b.now - time).abs())).unwrap()
}

#[test]
fn whoever_is_slower_or_faster_is_met() {
    for seed in HELD_OUT..HELD_OUT + 4 {
        let handover = Handover::new(seed);
        for tempo in [0.6, 1.0, 1.6] {
            let said = follow(&handover, |now| tempo * now, handover.contact / tempo + 0.8);
            let meeting = handover.contact / tempo;
            let there = at(&said, meeting);
            let later = at(&said, meeting + 0.15);
            println!(
                "seed {seed}, tempo {tempo}: hand off {:.3} m at contact, {:.3} m 0.15 s later; \
                 contact in {:.2} s, tempo {:.2}",
                off(there, &handover, handover.contact),
                off(later, &handover, handover.contact),
                there.contact_in,
                there.tempo,
            );
            // A reach 1.6 times as fast is faster than the robot's hand may be.
            let [in_time, later] =
                [there, later].map(|said| off(said, &handover, handover.contact));
            assert!(later < 0.2 && (tempo > 1.0 || in_time < 0.2), "{in_time} m, {later} m");
        }
    }
}

/// NOTE: how far time goes on before it stands is printed only: the tracker takes who stands half
/// way for who has met already.
#[test]
fn while_the_partner_stands_the_robot_comes_to_stand() {
    for seed in HELD_OUT..HELD_OUT + 4 {
        let handover = Handover::new(seed);
        let half = handover.contact - 0.45;
        let said = follow(&handover, |now| now.min(half), half + 6.0);
        let contacts: Vec<String> = [0.0, 0.2, 0.4, 0.6, 1.0, 1.5, 2.0, 3.0, 6.0]
            .iter()
            .map(|later| {
                let said = at(&said, half + later);
                let out = (said.places[HAND] - handover.giver(0.0)[HAND]).norm();
                format!("{later}: {:.2} s, {out:.2} m, {:.2}", said.contact_in, said.tempo)
            })
            .collect();
        println!("seed {seed}: {}", contacts.join("; "));
        let [before, last] = [5.7, 6.0].map(|later| &at(&said, half + later).places[HAND]);
        assert!((last - before).norm() < 0.03, "the hand stands");
    }
}

#[test]
fn whoever_withdraws_is_left() {
    for seed in HELD_OUT..HELD_OUT + 4 {
        let handover = Handover::new(seed);
        let half = handover.contact - 0.35;
        // Back as they came.
        let time = |now: f64| if now < half { now } else { (2.0 * half - now).max(0.2) };
        let said = follow(&handover, time, 2.0 * half + 1.5);
        let out: Vec<String> = (0..12)
            .map(|k| 0.2 * f64::from(k))
            .map(|later| {
                let said = at(&said, half + later);
                let out = (said.places[HAND] - handover.giver(0.0)[HAND]).norm();
                format!("{later:.1}: {:.2} s, {out:.2} m", said.contact_in)
            })
            .collect();
        println!("seed {seed}: {}", out.join("; "));
        // A giver leads: once the other one stands there again, it may offer anew.
        let later = said.iter().filter(|said| said.now > half && said.now < half + 1.5);
        let out = later.map(|said| (said.places[HAND] - handover.giver(0.0)[HAND]).norm());
        assert!(out.fold(f64::INFINITY, f64::min) < 0.1, "the hand goes back");
    }
}
