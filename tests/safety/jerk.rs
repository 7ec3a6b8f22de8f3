//! Jerk between the moments at which anybody looks.

use handover_mesh::safety::{Proposal, SafetySettings};
use handover_mesh::{Point, Span, Vector};

use crate::scene::{gate, seconds, standing};

/// Of finite differences over so many nanoseconds.
const FINE: i64 = 100_000;

/// The largest jerk `[m/s³]` of plans from rest that follow these poses, ticked at 1 kHz.
///
/// - `ways`: how far along x `[m]` the robot is to be moved at each pose.
/// - `step`: from one to the next.
fn largest_jerk(settings: &SafetySettings, ways: &[f64], step: Span) -> f64 {
    let mut gate = gate(settings.clone());
    let pose = |way: f64| standing().into_iter().map(move |p| p + Vector::x() * way);
    let poses: Vec<Point> = ways.iter().copied().flat_map(pose).collect();
    let mut largest = 0.0f64;
    for tick in 0..4 {
        let now = seconds(f64::from(tick) / 1000.0);
        let target = gate.admit(Proposal::Move { poses: &poses, step }, None, now).unwrap();
        let count = target.stands_in().0 / FINE;
        let mut joints = standing();
        let mut place = |k: i64| {
            target.positions_at(Span(k * FINE), &mut joints);
            joints[2].x
        };
        let mut window = [place(0), place(1), place(2)];
        for k in 3..count {
            let next = place(k);
            let third = next - 3.0 * (window[2] - window[1]) - window[0];
            largest = largest.max(third.abs() / Span(FINE).seconds().powi(3));
            window = [window[1], window[2], next];
        }
    }
    largest
}

#[test]
fn no_jerk_hides_between_samples() {
    let usual = SafetySettings { recover: 0.0, ..SafetySettings::default() };
    let bound = usual.jerk * 1.002;
    let short = SafetySettings { lead: 0.005, aim: 0.05, ..usual.clone() };
    let ways = [-39.97, 5.40, -3.254, -11.91, -39.97];
    let jerk = largest_jerk(&short, &ways, Span(25_000_000));
    assert!(jerk < bound, "{jerk} m/s³");

    let leads = [(0.005, 0.05), (0.01, 0.1), (0.02, 0.1), (0.03, 0.1), (0.05, 0.1), (0.05, 0.06)];
    for (lead, aim) in leads {
        for acceleration in [usual.acceleration, 30.0] {
            let settings = SafetySettings { lead, aim, acceleration, ..usual.clone() };
            let mut largest = 0.0f64;
            // A jerk that is `end` where the lead starts and ends, and `peak` in the middle of each
            // of so many parts of it, or as near to that as a parabola comes.
            for (peak, end) in (0..80).map(|k| (300.0 * f64::from(k / 5), 475.0 * f64::from(k % 5)))
            {
                for parts in [1.0, 2.0, 4.0] {
                    let (end, width) = (end - 950.0, lead / parts);
                    let bend = 4.0 * (peak - end) / (width * width);
                    let (j0, j1, j2) = (end, bend * width, -2.0 * bend);
                    let t = aim;
                    let place = (j0 / 6.0 + (j1 / 24.0 + j2 / 120.0 * t) * t) * t * t * t;
                    let velocity = (j0 / 2.0 + (j1 / 6.0 + j2 / 24.0 * t) * t) * t * t;
                    let bent = (j0 + (j1 / 2.0 + j2 / 6.0 * t) * t) * t;
                    // As the gate takes differences of poses around the aim.
                    let step = aim / 2.0;
                    let ways = [
                        0.0,
                        0.0,
                        place,
                        2.0 * step * velocity,
                        4.0 * step * step * bent + 2.0 * place,
                    ];
                    let step = Span((step * 1e9) as i64);
                    largest = largest.max(largest_jerk(&settings, &ways, step));
                }
            }
            println!("lead {lead}, aim {aim}, acceleration {acceleration}: jerk {largest:.0} m/s³");
            assert!(largest < bound, "lead {lead}, aim {aim}: {largest} m/s³");
            assert!(largest > 0.5 * usual.jerk, "nothing was tried");
        }
    }
}
