//! A path through the latent space: velocities between poses, followed step by step.
//!
//! A pose's velocity is `(x_{i+1} − x_i)/2`, at a sequence's end `(x_i − x_{i−1})/2`; between poses
//! it is the mean of the neighbours' by their weights, and a path takes whole steps of it
//! (Gauch & Peters III-D to III-F, their halving).

use std::ops::Range;

use super::Rows;
use super::neighbourhood::{Around, Neighbours};
use super::rows::distance;

/// When a path ends.
#[derive(Debug, Clone, PartialEq)]
pub struct FollowSettings {
    /// Steps at most.
    pub steps: usize,
    /// A step shorter than this, in the latent space's unit, is standing still; ≥ 0.
    pub still: f64,
    /// A latent point to arrive at, and how near counts as there.
    pub goal: Option<(Vec<f64>, f64)>,
}

/// Why a path ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// All steps are taken.
    Steps,
    /// The field stands still there.
    Still,
    /// The goal is reached.
    Goal,
}

/// A path that follows the field.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// The latent points passed, the start first.
    pub points: Rows,
    /// How many of its steps were taken outside the hull, by the nearest poses; 0 where the
    /// neighbourhood has no hull.
    pub outside: usize,
    /// Why it ended.
    pub stop: Stop,
}

/// Every pose's velocity: latent units per frame, halved as in the paper; 0 of a lone pose.
pub(super) fn velocities(points: &Rows, sequences: &[Range<usize>]) -> Rows {
    let mut velocities = vec![0.0; points.values().len()];
    let width = points.width();
    for sequence in sequences.iter().filter(|sequence| sequence.len() > 1) {
        for pose in sequence.clone() {
            let next = (pose + 1).min(sequence.end - 1);
            let [from, to] = [next - 1, next].map(|row| points.row(row));
            let velocity = &mut velocities[pose * width..][..width];
            for (axis, value) in velocity.iter_mut().enumerate() {
                *value = 0.5 * (to[axis] - from[axis]);
            }
        }
    }
    Rows::computed(width, velocities)
}

/// The mean of the neighbours' velocities by their weights; zero without neighbours.
pub(super) fn mean_velocity(around: &Around, velocities: &Rows, velocity: &mut [f64]) {
    assert_eq!(velocity.len(), velocities.width(), "one number per dimension");
    velocity.fill(0.0);
    for neighbour in around.neighbours() {
        let of = velocities.row(neighbour.pose as usize);
        velocity.iter_mut().zip(of).for_each(|(mean, v)| *mean += neighbour.weight * v);
    }
}

/// Follows the field from a latent point.
pub(super) fn follow(
    neighbours: &Neighbours,
    velocities: &Rows,
    start: &[f64],
    settings: &FollowSettings,
) -> Path {
    if let Some((goal, _)) = &settings.goal {
        assert_eq!(goal.len(), start.len(), "one number per dimension");
    }
    let mut around = neighbours.around();
    let mut place = start.to_vec();
    let mut velocity = vec![0.0; place.len()];
    let mut points = place.clone();
    let mut outside = 0;
    let arrived = |place: &[f64]| {
        settings.goal.as_ref().is_some_and(|(goal, near)| distance(place, goal) <= *near)
    };
    let mut stop = Stop::Steps;
    for _ in 0..settings.steps {
        if arrived(&place) {
            stop = Stop::Goal;
            break;
        }
        neighbours.find(&place, &mut around);
        mean_velocity(&around, velocities, &mut velocity);
        let length = velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        if length == 0.0 || length < settings.still {
            stop = Stop::Still;
            break;
        }
        outside += usize::from(around.is_outside());
        place.iter_mut().zip(&velocity).for_each(|(x, v)| *x += v);
        points.extend_from_slice(&place);
    }
    if stop == Stop::Steps && arrived(&place) {
        stop = Stop::Goal;
    }
    Path { points: Rows::computed(start.len(), points), outside, stop }
}
