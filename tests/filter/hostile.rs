//! Whatever comes in: no panic, finite places within bounds, no allocation; and the same wherever
//! the person stands.

use handover_mesh::filter::{Doubt, Filter, FilterSettings, Sighting};
use handover_mesh::{Point, Skeleton, Stamp, Vector};
use proptest::prelude::*;

use super::{Stream, farthest, moved, noisy, pose, random, stamp, times};

/// What happens at a step.
#[derive(Debug, Clone)]
struct Event {
    /// To the stamp `[ms]`, and to `now`.
    steps: [i64; 2],
    /// Joints set to a value.
    broken: Vec<(usize, usize, f64)>,
    shift: f64,
    body: Option<u32>,
    is_nothing: bool,
}

fn value() -> impl Strategy<Value = f64> {
    let special = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e6, 1e-300, 0.0];
    prop_oneof![prop::sample::select(special.to_vec()), -3.0..3.0]
}

fn event() -> impl Strategy<Value = Event> {
    let step =
        || prop_oneof![20 => Just(33), 2 => -3000_i64..3000, 1 => Just(0), 1 => any::<i64>()];
    let broken = prop_oneof![
        3 => Just(Vec::new()),
        2 => prop::collection::vec((0..15_usize, 0..3_usize, value()), 0..30),
    ];
    let shift = prop_oneof![8 => Just(0.0), 1 => -5.0..5.0];
    let body = prop_oneof![6 => Just(Some(1)), 1 => Just(None), 1 => any::<u32>().prop_map(Some)];
    (step(), any::<prop::sample::Index>(), step(), broken, shift, body, prop::bool::weighted(0.1))
        .prop_map(|(both, own, now, broken, shift, body, is_nothing)| Event {
            // Mostly both clocks go together.
            steps: if own.index(10) == 0 { [both, now] } else { [both, both] },
            broken,
            shift,
            body,
            is_nothing,
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn any_stream_gives_finite_places_or_a_doubt(events in prop::collection::vec(event(), 1..150)) {
        let skeleton = Skeleton::nite();
        let mut filter = Filter::new(skeleton.clone(), skeleton.root(), FilterSettings::default());
        let (mut seen, mut now) = (0_i64, 0_i64);
        let mut out = vec![Point::origin(); 15];
        for (k, event) in events.iter().enumerate() {
            seen = seen.saturating_add(event.steps[0].saturating_mul(1_000_000));
            now = now.saturating_add(event.steps[1].saturating_mul(1_000_000));
            let mut positions = moved(&pose(k as f64 / 30.0), 0.0, Vector::x() * event.shift);
            for (joint, coordinate, value) in &event.broken {
                positions[*joint][*coordinate] = *value;
            }
            let sighting =
                Sighting { stamp: Stamp(seen), body: event.body, positions: &positions, confidences: &[] };
            let sighting = (!event.is_nothing).then_some(&sighting);
            let mut failed = None;
            let allocations = allocation_counter::measure(|| {
                let Ok(partner) = filter.update(sighting, Stamp(now)) else { return };
                let mut speeds = partner.velocities().iter().map(|v| v.norm());
                if !speeds.all(|speed| speed < 100.0) {
                    failed = Some("a velocity");
                }
                for ahead in [-400_000_000, -10, 0, 50_000_000, i64::MAX] {
                    partner.at(Stamp(partner.stamp().0.saturating_add(ahead)), &mut out);
                    // People here stay within 5 m, but for joints at the edge of what is a place.
                    if !out.iter().all(|p| p.coords.amax() < 1.1e6) {
                        failed = Some("a place");
                    }
                }
            });
            prop_assert_eq!(allocations.count_total, 0);
            prop_assert_eq!(failed, None, "step {}", k);
        }
        // Whatever was, a person who is seen well is known soon.
        let mut last = Err(Doubt::Nobody);
        filter.update(None, Stamp(0)).ok();
        for time in times(30.0, 0.0, 3.2) {
            let positions = pose(time);
            let sighting =
                Sighting { stamp: stamp(time), body: None, positions: &positions, confidences: &[] };
            last = filter.update(Some(&sighting), stamp(time)).map(|partner| {
                farthest(partner.positions(), &positions)
            });
        }
        prop_assert!(last.is_ok_and(|off| off < 0.1), "{:?}", last);
    }

    #[test]
    fn the_same_wherever_the_person_stands(
        yaw in -3.2..3.2_f64,
        shift in prop::array::uniform3(-50.0..50.0_f64),
        hidden in prop::collection::vec((0..15_usize, 10..90_usize, 1..20_usize), 0..6),
        swaps in prop::collection::vec(30..90_usize, 0..3),
    ) {
        let shift = Vector::from(shift);
        let mut streams = [Stream::new(), Stream::new()];
        let mut random = random();
        for (k, time) in times(30.0, 0.0, 4.0).enumerate() {
            let mut seen = noisy(&pose(time), 0.01, &mut random);
            for (joint, from, count) in &hidden {
                if (*from..from + count).contains(&k) {
                    seen[*joint] = Point::new(f64::NAN, 0.0, 0.0);
                }
            }
            if swaps.iter().any(|from| (*from..from + 5).contains(&k)) {
                (3..6).for_each(|left| seen.swap(left, left + 3));
            }
            let there = moved(&seen, yaw, shift);
            let [here, other] = &mut streams;
            match (here.send(time, &seen), other.send(time, &there)) {
                (Ok(here), Ok(other)) => {
                    let off = farthest(&moved(here.positions(), yaw, shift), other.positions());
                    prop_assert!(off < 1e-6, "{} s: {} m", time, off);
                    prop_assert_eq!(here.swapped(), other.swapped());
                }
                (here, other) => prop_assert_eq!(here.err(), other.err()),
            }
        }
    }
}

#[test]
fn updates_allocate_nothing() {
    let mut stream = Stream::new();
    let poses: Vec<Vec<Point>> = times(30.0, 0.0, 4.0).map(pose).collect();
    let mut out = vec![Point::origin(); 15];
    let allocations = allocation_counter::measure(|| {
        for (k, pose) in poses.iter().enumerate() {
            let partner = stream.send(k as f64 / 30.0, pose).unwrap();
            partner.at(stamp(k as f64 / 30.0 + 0.1), &mut out);
        }
        stream.filter.reset();
    });
    assert_eq!(allocations.count_total, 0);
}

#[test]
#[should_panic(expected = "joints of the sighting")]
fn a_sighting_of_another_skeleton_is_the_callers_bug() {
    Stream::new().send(0.0, &[Point::origin(); 3]).ok();
}
