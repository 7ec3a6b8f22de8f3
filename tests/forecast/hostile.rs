//! Whatever the past, forecasts are numbers.

use std::sync::OnceLock;

use handover_mesh::forecast::{ForecastMethod, ForecastSettings, Forecaster, Moment};
use handover_mesh::{Frame, Point, Skeleton, Stamp};
use proptest::prelude::*;

use crate::{fit, root, wandering};

fn forecaster() -> &'static Forecaster {
    static FORECASTER: OnceLock<Forecaster> = OnceLock::new();
    FORECASTER.get_or_init(|| {
        let motions: Vec<_> = (0..4).map(|seed| wandering(seed, 60)).collect();
        fit(&motions, ForecastSettings::default()).unwrap()
    })
}

#[track_caller]
fn check_finite(past: &[Frame]) {
    let (skeleton, forecaster) = (Skeleton::nite(), forecaster());
    let mut moment = Moment::new(&skeleton, root());
    moment.observe(&skeleton, past, forecaster.velocity_window());
    let mut workspace = forecaster.workspace();
    for method in ForecastMethod::ALL {
        let said = forecaster.forecast(method, &moment, &mut workspace);
        assert_eq!(said.len(), 15 * forecaster.horizons().len());
        let finite = said.iter().all(|place| place.iter().all(|value| value.is_finite()));
        assert!(finite, "{}: {said:?}", method.name());
    }
}

fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -2.0..2.0, 1 => -1e3..1e3, 1 => Just(0.0), 1 => Just(1e3), 1 => Just(-1e-300)]
}

fn pose() -> impl Strategy<Value = Box<[Point]>> {
    let point = || [coordinate(), coordinate(), coordinate()].prop_map(Point::from);
    prop_oneof![
        prop::collection::vec(point(), 15).prop_map(Vec::into_boxed_slice),
        // All joints in one place: no heading, no skeleton.
        point().prop_map(|point| vec![point; 15].into()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]
    #[test]
    fn any_finite_past_has_a_finite_future(
        poses in prop::collection::vec((pose(), 1..4_usize), 1..6),
        gaps in prop::collection::vec(
            prop_oneof![1..100_i64, 1_000_000..50_000_000_i64, 1_000_000_000..10_000_000_000_i64],
            18,
        ),
        start in prop_oneof![Just(0_i64), Just(i64::MIN), Just(1_700_000_000_000_000_000)],
    ) {
        let mut stamp = start;
        // The same pose may be seen several times.
        let poses = poses.into_iter().flat_map(|(pose, times)| vec![pose; times]);
        let past = poses.zip(gaps).map(|(positions, gap)| {
            stamp += gap;
            Frame { stamp: Stamp(stamp), positions }
        });
        check_finite(&past.collect::<Vec<_>>());
    }
}

#[test]
fn places_as_far_as_numbers_go_have_a_finite_future() {
    let frame = |stamp: i64, place: f64| Frame {
        stamp: Stamp(stamp),
        positions: (0..15).map(|j| Point::new(place, -place * f64::from(j), 1.0)).collect(),
    };
    for place in [1e3, 1e12, 1e48] {
        check_finite(&[frame(i64::MIN, place)]);
        check_finite(&[frame(0, place), frame(1, -place)]);
        check_finite(&[frame(i64::MIN, 0.0), frame(i64::MAX, place)]);
    }
}
