//! A well-seen person passes with little lag, and noise is less than before.

use handover_mesh::Point;

use super::{Stream, farthest, noisy, pose, random, stamp, times};

/// What a stream of this rate and noise `[m]` becomes: root mean square of the right hand's error
/// `[m]` raw and filtered, of its velocity's `[m/s]`, and the lag `[s]` at which the error is least.
fn measure(rate: f64, deviation: f64, jitter: f64) -> [f64; 4] {
    let (mut stream, mut random) = (Stream::new(), random());
    let hand = stream.right_hand().index();
    let mut shown = Vec::new();
    let mut squares = [0.0; 2];
    for (k, time) in times(rate, 0.0, 4.0).enumerate() {
        let time = time + jitter * [0.3, -0.4, 0.0, 0.5, -0.2][k % 5] / rate;
        let seen = noisy(&pose(time.max(0.0)), deviation, &mut random);
        let partner = stream.send(time.max(0.0), &seen).unwrap();
        if time > 0.5 {
            squares[0] += (seen[hand] - pose(time)[hand]).norm_squared();
            let slope = (pose(time + 1e-4)[hand] - pose(time - 1e-4)[hand]) / 2e-4;
            squares[1] += (partner.velocities()[hand] - slope).norm_squared();
            shown.push((time, partner.positions()[hand]));
        }
    }
    let count = shown.len() as f64;
    let error = |lag: f64| {
        let square = |(time, place): &(f64, Point)| (place - pose(time - lag)[hand]).norm_squared();
        (shown.iter().map(square).sum::<f64>() / count).sqrt()
    };
    let lags = (-20..=60).map(|ms| f64::from(ms) * 1e-3);
    let lag = lags.min_by(|a, b| error(*a).total_cmp(&error(*b))).unwrap();
    [(squares[0] / count).sqrt(), error(0.0), (squares[1] / count).sqrt(), lag]
}

#[test]
fn a_clean_reach_passes_with_a_small_lag() {
    for (rate, most) in [(15.0, 0.012), (30.0, 0.008), (31.0, 0.008), (120.0, 0.008)] {
        for jitter in [0.0, 0.5] {
            let [_, error, speed_error, lag] = measure(rate, 0.0, jitter);
            println!(
                "{rate} Hz, jitter {jitter}: lag {:.0} ms, error {:.2} cm, of velocity {speed_error:.2} m/s",
                1e3 * lag,
                1e2 * error
            );
            assert!(lag.abs() <= 0.015 && error < most, "{rate} Hz: lag {lag} s, {error} m");
        }
    }
}

#[test]
fn noise_is_reduced() {
    for (rate, most) in [(15.0, 0.97), (30.0, 0.9), (120.0, 0.7)] {
        let [raw, filtered, speed_error, lag] = measure(rate, 0.015, 0.0);
        println!(
            "{rate} Hz, noise 1.5 cm a coordinate: raw {:.2}, filtered {:.2} cm, velocity {speed_error:.2} m/s, lag {:.0} ms",
            1e2 * raw,
            1e2 * filtered,
            1e3 * lag
        );
        assert!(filtered < most * raw, "{rate} Hz: {raw} to {filtered} m");
    }
}

#[test]
fn any_instant_of_the_last_moments_is_interpolated_and_the_next_extrapolated() {
    for rate in [15.0, 30.0, 120.0] {
        let mut stream = Stream::new();
        for time in times(rate, 0.0, 3.0) {
            let mut out = vec![Point::origin(); 15];
            let partner = stream.send(time, &pose(time)).unwrap();
            partner.at(stamp(time), &mut out);
            assert!(farthest(&out, partner.positions()) < 1e-12);
            // Before the first sighting it is as at the first.
            for back in [0.05, 0.3, 0.6] {
                partner.at(stamp(time - back), &mut out);
                let off = farthest(&out, &pose((time - back).max(0.0)));
                assert!(off < 0.04, "{rate} Hz, {time} s, {back} s ago: {off} m");
            }
            partner.at(stamp(time + 0.1), &mut out);
            let off = farthest(&out, &pose(time + 0.1));
            assert!(off < 0.09, "{rate} Hz, {time} s, ahead: {off} m");
            let mut later = out.clone();
            partner.at(stamp(time + 0.2), &mut out);
            partner.at(stamp(time + 1e6), &mut later);
            assert_eq!(out, later, "carried no further");
        }
    }
}
