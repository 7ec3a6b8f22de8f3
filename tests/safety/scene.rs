//! A robot that stands, a partner, and a reach.

use std::sync::Arc;

use handover_mesh::kinematics::{minimum_jerk, two_bone};
use handover_mesh::safety::{PartnerBody, SafetyGate, SafetySettings};
use handover_mesh::{Part, Point, Side, Skeleton, Span, Stamp, Vector};

/// Someone standing at the origin and facing x, arms half bent.
pub(crate) fn standing() -> Vec<Point> {
    [
        [0.0, 0.0, 1.65],
        [0.0, 0.0, 1.45],
        [0.0, 0.0, 1.15],
        [0.0, 0.18, 1.42],
        [0.0, 0.2, 1.12],
        [0.2, 0.2, 0.97],
        [0.0, -0.18, 1.42],
        [0.0, -0.2, 1.12],
        [0.2, -0.2, 0.97],
        [0.0, 0.1, 0.92],
        [0.02, 0.1, 0.5],
        [0.0, 0.1, 0.08],
        [0.0, -0.1, 0.92],
        [0.02, -0.1, 0.5],
        [0.0, -0.1, 0.08],
    ]
    .map(Point::from)
    .to_vec()
}

pub(crate) fn lengths(skeleton: &Skeleton, pose: &[Point]) -> Vec<f64> {
    skeleton.bones().map(|b| (pose[b.child.index()] - pose[b.parent.index()]).norm()).collect()
}

/// A gate that stands as [`standing`] at stamp 0.
pub(crate) fn gate(settings: SafetySettings) -> SafetyGate {
    let (skeleton, pose) = (Skeleton::nite(), standing());
    let lengths = lengths(&skeleton, &pose);
    let mut gate = SafetyGate::new(skeleton.clone(), skeleton.root(), &lengths, settings).unwrap();
    assert!(gate.start(&pose, Stamp(0)));
    gate
}

pub(crate) fn right_hand(skeleton: &Arc<Skeleton>) -> usize {
    skeleton.part(Part::Hand(Side::Right)).unwrap().index()
}

/// [`standing`], with the right hand moved by `way` `[m]`.
pub(crate) fn reaching(way: Vector) -> Vec<Point> {
    let skeleton = Skeleton::nite();
    let [shoulder, elbow, hand] = skeleton.arm(Side::Right).unwrap().map(|joint| joint.index());
    let mut pose = standing();
    let length = |a: usize, b: usize| (standing()[a] - standing()[b]).norm();
    let (upper, lower) = (length(shoulder, elbow), length(elbow, hand));
    let goal = pose[hand] + way;
    let bent = two_bone(pose[shoulder], goal, upper, lower, -Vector::z());
    pose[elbow] = bent.middle;
    pose[hand] = bent.end;
    pose
}

/// A minimum-jerk reach along `way` in `duration` `[s]`, from `start` `[s]` on.
pub(crate) fn reach(way: Vector, start: f64, duration: f64) -> impl Fn(f64) -> Vec<Point> {
    move |time: f64| reaching(way * minimum_jerk((time - start) / duration))
}

/// Poses from `now` `[s]` on, at 30 Hz, 15 ahead.
pub(crate) fn window(pose: &impl Fn(f64) -> Vec<Point>, now: f64) -> Vec<Point> {
    (0..=15).flat_map(|k| pose(now + f64::from(k) / 30.0)).collect()
}

pub(crate) const STEP: Span = Span(33_333_333);

/// A partner who stands at a place and looks this way.
pub(crate) fn partner(x: f64, y: f64) -> PartnerBody {
    let at = |z: f64| Some(Point::new(x, y, z));
    PartnerBody { head: at(1.65), neck: at(1.45), torso: at(1.1) }
}

pub(crate) fn seconds(stamp: f64) -> Stamp {
    Stamp::from_seconds(stamp).unwrap()
}
