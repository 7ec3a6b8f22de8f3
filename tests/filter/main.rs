//! A stream of sightings of one person, clean, noisy, broken or hostile, and what the filter
//! makes of it.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "figures, and what was skipped")]

mod clean;
mod clocks;
mod hostile;
mod people;
mod real;
mod sides;
#[path = "../common/standing.rs"]
mod standing;
mod trouble;

use std::sync::Arc;

use handover_mesh::filter::{Doubt, Filter, FilterSettings, Partner, Sighting};
use handover_mesh::geometry::yaw_isometry;
use handover_mesh::kinematics::{minimum_jerk, two_bone};
use handover_mesh::{JointId, Part, Point, Side, Skeleton, Stamp, Vector};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use standing::STANDING;

/// Steps of a stream, in order of `[s]`.
pub(crate) fn times(rate: f64, from: f64, to: f64) -> impl Iterator<Item = f64> {
    let count = ((to - from) * rate).round() as i32;
    (0..count).map(move |k| from + f64::from(k) / rate)
}

pub(crate) fn stamp(seconds: f64) -> Stamp {
    Stamp::from_seconds(seconds).unwrap()
}

/// Somebody who sways, and whose right hand reaches half a metre forwards within 0.8 s from
/// second 1 on, and back from second 2.5 on.
pub(crate) fn pose(time: f64) -> Vec<Point> {
    let sway = Vector::new(0.05 * (1.3 * time).sin(), 0.08 * (0.9 * time).sin(), 0.0);
    let mut pose: Vec<Point> = STANDING.map(|[x, y, z]| Point::new(x, y, z) + sway).into();
    let reach = minimum_jerk((time - 1.0) / 0.8) - minimum_jerk((time - 2.5) / 0.8);
    let hand = pose[8] + Vector::new(0.3, 0.05, 0.4) * reach;
    let arm = two_bone(pose[6], hand, 0.275, 0.25, Vector::new(0.0, -1.0, -1.0));
    (pose[7], pose[8]) = (arm.middle, arm.end);
    pose
}

/// About normal noise of this deviation `[m]` on every coordinate.
pub(crate) fn noisy(pose: &[Point], deviation: f64, random: &mut ChaCha8Rng) -> Vec<Point> {
    let mut noise = || {
        let sum: f64 = (0..12).map(|_| random.random::<f64>()).sum();
        deviation * (sum - 6.0)
    };
    pose.iter().map(|p| p + Vector::new(noise(), noise(), noise())).collect()
}

pub(crate) fn random() -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(7)
}

/// A filter and what is sent to it.
pub(crate) struct Stream {
    pub(crate) skeleton: Arc<Skeleton>,
    pub(crate) filter: Filter,
    /// The number of the body that is sent.
    pub(crate) body: Option<u32>,
}

impl Stream {
    pub(crate) fn new() -> Self {
        let skeleton = Skeleton::nite();
        let settings = FilterSettings::default();
        let filter = Filter::new(skeleton.clone(), skeleton.root(), settings);
        Self { skeleton, filter, body: Some(1) }
    }

    /// Sends a pose, seen and received at once.
    pub(crate) fn send(&mut self, time: f64, positions: &[Point]) -> Result<Partner<'_>, Doubt> {
        self.send_at(stamp(time), stamp(time), positions)
    }

    pub(crate) fn send_at(
        &mut self,
        stamp: Stamp,
        now: Stamp,
        positions: &[Point],
    ) -> Result<Partner<'_>, Doubt> {
        let sighting = Sighting { stamp, body: self.body, positions, confidences: &[] };
        self.filter.update(Some(&sighting), now)
    }

    /// Sends the usual person at 30 Hz, who must not be doubted.
    #[track_caller]
    pub(crate) fn send_usual(&mut self, from: f64, to: f64) {
        for time in times(30.0, from, to) {
            let partner = self.send(time, &pose(time));
            assert!(partner.is_ok(), "{time} s: {:?}", partner.err());
        }
    }

    pub(crate) fn right_hand(&self) -> JointId {
        self.skeleton.part(Part::Hand(Side::Right)).unwrap()
    }
}

/// The largest distance between two poses `[m]`.
pub(crate) fn farthest(a: &[Point], b: &[Point]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// The pose turned about the vertical and shifted.
pub(crate) fn moved(pose: &[Point], yaw: f64, shift: Vector) -> Vec<Point> {
    let turn = yaw_isometry(yaw, shift);
    pose.iter().map(|p| turn * p).collect()
}
