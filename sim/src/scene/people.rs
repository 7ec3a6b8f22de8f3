//! One person's joints in `pair`, from a handful of angles and the points their hands go to.
//!
//! The hips carry the trunk, which leans about the line through both hip joints and twists about
//! its own axis; arms and legs follow by two-bone inverse kinematics. Every bone is a rotated
//! constant, so its length never changes.

use handover_mesh::kinematics::{minimum_jerk, two_bone};
use handover_mesh::{Isometry, Point, Side, Vector};
use nalgebra::{Translation3, UnitQuaternion};

use crate::body::{Body, sign};
use crate::profile::{bell, step};

/// How a person stands at one instant, apart from hands and feet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stance {
    /// The hips' upright frame: origin midway between the hip joints, x ahead.
    pub(super) pair_from_hips: Isometry,
    /// Trunk ahead about the hips, `[rad]`.
    pub(super) lean: f64,
    /// Shoulders about the trunk's axis, `[rad]`, counter-clockwise.
    pub(super) twist: f64,
    /// Head down against the trunk, `[rad]`.
    pub(super) nod: f64,
}

/// A trunk: all joints that do not need inverse kinematics, `[m]` in `pair`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Trunk {
    pub(super) torso: Point,
    pub(super) neck: Point,
    pub(super) head: Point,
    /// Left, right.
    pub(super) shoulders: [Point; 2],
    /// Left, right.
    pub(super) hips: [Point; 2],
    /// Upright, turned as the shoulders are: arms hang by gravity, not along the trunk.
    pub(super) pair_from_shoulders: UnitQuaternion<f64>,
}

/// An arm, laid out.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limb {
    pub(super) middle: Point,
    pub(super) end: Point,
    pub(super) clamped: bool,
}

fn about(axis: nalgebra::Unit<Vector>, angle: f64) -> Isometry {
    let turn = UnitQuaternion::from_axis_angle(&axis, angle);
    Isometry::from_parts(Translation3::identity(), turn)
}

impl Trunk {
    /// The trunk of `body` standing so.
    pub(super) fn of(body: &Body, stance: &Stance) -> Self {
        let pair_from_hips = stance.pair_from_hips;
        let lean = about(Vector::y_axis(), stance.lean);
        let twist = about(Vector::z_axis(), stance.twist);
        let shift =
            |vector: Vector| Isometry::from_parts(vector.into(), UnitQuaternion::identity());
        let pair_from_torso = pair_from_hips * lean * shift(body.torso());
        let pair_from_neck = pair_from_torso * twist * shift(body.neck());
        // The head follows the shoulders by a third: it keeps looking at the partner.
        let look = about(Vector::z_axis(), -stance.twist * 2.0 / 3.0)
            * about(Vector::y_axis(), stance.nod);
        let origin = Point::origin();
        Self {
            torso: pair_from_torso * origin,
            neck: pair_from_neck * origin,
            head: pair_from_neck * look * Point::from(body.head()),
            shoulders: Side::BOTH.map(|side| pair_from_neck * Point::from(body.shoulder(side))),
            hips: Side::BOTH.map(|side| pair_from_hips * Point::from(body.hip(side))),
            pair_from_shoulders: pair_from_hips.rotation * twist.rotation,
        }
    }

    /// Where this side's hand rests, `[m]` in `pair`.
    ///
    /// - `carry`: 0 for an arm that hangs, 1 for a level forearm.
    /// - `swing`: of the hanging arm ahead, `[rad]`.
    pub(super) fn resting_hand(&self, body: &Body, side: Side, carry: f64, swing: f64) -> Point {
        // A little short of straight, and a little off the thigh.
        let ahead = 0.12 + swing;
        let outward = 0.09 * sign(side);
        let hanging =
            Vector::new(ahead.sin(), outward, -ahead.cos()).normalize() * body.arm() * 0.97;
        // Level ahead of the elbow, towards the middle of the body.
        let forearm = Vector::new(0.96, -0.28 * sign(side), 0.0) * body.forearm();
        let carrying = Vector::new(swing.sin(), 0.0, -1.0) * body.upper_arm() + forearm;
        let offset = hanging.lerp(&carrying, carry);
        self.shoulders[side as usize] + self.pair_from_shoulders * offset
    }

    /// The arm of this side with its hand at `target` (`[m]` in `pair`) or as near as it reaches.
    ///
    /// - `swivel`: the elbow's swing outwards, `[rad]`.
    pub(super) fn arm(&self, body: &Body, side: Side, target: Point, swivel: f64) -> Limb {
        // Down for a raised arm, back for a hanging one: no reach below the shoulders and ahead
        // of the body passes along this direction, so the elbow never flips.
        let down_and_back = Vector::new(-0.6, 0.0, -0.8) * swivel.cos();
        let pole = down_and_back + Vector::y() * sign(side) * swivel.sin();
        let pole = self.pair_from_shoulders * pole;
        let shoulder = self.shoulders[side as usize];
        let arm = two_bone(shoulder, target, body.upper_arm(), body.forearm(), pole);
        Limb { middle: arm.middle, end: arm.end, clamped: arm.clamped }
    }

    /// The leg of this side with its ankle at `target`, `[m]` in `pair`; the knee bends ahead.
    pub(super) fn leg(&self, body: &Body, stance: &Stance, side: Side, target: Point) -> Limb {
        let ahead = stance.pair_from_hips.rotation * Vector::x();
        let hip = self.hips[side as usize];
        let leg = two_bone(hip, target, body.thigh(), body.shank(), ahead);
        Limb { middle: leg.middle, end: leg.end, clamped: leg.clamped }
    }
}

/// Where an ankle is, `[m]` in the walker's upright frame at its goal (x ahead), before, during
/// and after a walk of `distance` `[m]` that is done by the part `part` of its duration.
///
/// Feet swing in turn, left first; each lands where the hips will be in the middle of its stand.
pub(super) fn ankle(body: &Body, side: Side, distance: f64, part: f64) -> Point {
    let swings = 2 * (distance / 0.7).ceil().max(1.0) as usize + 2;
    let length = 1.0 / swings as f64;
    let hips_at = |part: f64| distance * (minimum_jerk(part) - 1.0);
    let landing = |swing: usize| {
        // The last swing of either foot brings it beside the other.
        if swing + 2 >= swings { 0.0 } else { hips_at((swing as f64 + 1.5) * length) }
    };
    let own = |swing: &usize| swing % 2 == side as usize;
    let (mut ahead, mut lift) = (-distance, 0.0);
    for swing in (0..swings).filter(own) {
        let start = swing as f64 * length;
        let done = step(part, start, start + length);
        ahead += (landing(swing) - ahead) * done;
        lift += 0.06 * bell(part, start, start + length);
    }
    // Feet stand a little wider than the hips.
    let wide = body.hip(side) * 1.2;
    Point::new(ahead, wide.y, body.ankle_height() + if distance > 0.0 { lift } else { 0.0 })
}
