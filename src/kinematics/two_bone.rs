//! Root, target and two bone lengths → middle joint and end: `[m]` in any one frame.
//!
//! The middle joint lies on a circle about the line from root to target; by the law of cosines
//! `cos α = (a² + d² − b²) / 2ad` at the root, for bones `a`, `b` and distance `d`, and the pole
//! direction picks the place on the circle (Tolani, Goswami, Badler 2000, without their wrist).
//!
//! Knows no joint limits and remembers nothing: the same input gives the same pose.

use crate::geometry::{Point, Vector, direction_or};

/// Outside the annulus by less than this `[m]` is rounding, not an unreachable target.
const ROUNDING: f64 = 1e-12;

/// An arm (or leg) laid out by [`two_bone`]: `[m]`, in the frame of its input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoBone {
    /// The middle joint: elbow or knee.
    pub middle: Point,
    /// The end: hand or foot. The target itself (to rounding) where that can be reached.
    pub end: Point,
    /// Whether the target lay outside the reachable annulus, so that `end` is the point of the
    /// annulus nearest to it.
    pub clamped: bool,
}

/// Lays two bones from `root` so that their end is at `target`, or as near as it can be.
///
/// - `root`, `target`: `[m]` in one common frame.
/// - `upper`, `lower`: bone lengths `[m]`, from the root outwards, ≥ 0; anything else counts as 0.
/// - `pole`: the direction (any length) towards which the middle joint bends.
///
/// Total: both lengths hold to 1e-12 for any input of human size, and every finite input has one
/// finite answer. A target beyond `upper + lower` or within `|upper − lower|` of the root is
/// moved along its ray into the annulus. Where a direction is undefined a fixed one is taken:
/// a target at the root is looked for along `pole`, a pole along the limb (or zero) is replaced
/// by a world axis across it, and a target that is not finite counts as out of reach along
/// `pole`. The answer is continuous in all arguments away from these three cases.
///
/// ```
/// use handover_mesh::kinematics::two_bone;
/// use handover_mesh::{Point, Vector};
/// let down = -Vector::z();
/// let arm = two_bone(Point::origin(), Point::new(0.4, 0.0, 0.0), 0.25, 0.25, down);
/// assert!((arm.middle - Point::new(0.2, 0.0, -0.15)).norm() < 1e-12 && !arm.clamped);
/// let straight = two_bone(Point::origin(), Point::new(2.0, 0.0, 0.0), 0.25, 0.25, down);
/// assert!((straight.end - Point::new(0.5, 0.0, 0.0)).norm() < 1e-12 && straight.clamped);
/// ```
pub fn two_bone(root: Point, target: Point, upper: f64, lower: f64, pole: Vector) -> TwoBone {
    let [upper, lower] = [upper, lower].map(|l| if l.is_finite() { l.max(0.0) } else { 0.0 });
    let pole = if pole.norm().is_finite() { pole } else { Vector::zeros() };
    let wanted = target - root;
    let distance = wanted.norm();
    // A norm that is infinite (or NaN) leaves no ray to follow.
    let finite = distance.is_finite();
    let ray = if finite { wanted } else { Vector::zeros() };
    let along = direction_or(ray, direction_or(pole, Vector::x()));

    let (nearest, farthest) = ((upper - lower).abs(), upper + lower);
    let reached = if finite { distance.clamp(nearest, farthest) } else { farthest };
    let clamped = !finite || (distance - reached).abs() > ROUNDING;

    let across = across(pole, along);
    let twice = 2.0 * upper * reached;
    // With no upper bone, or folded back to the root, any angle will do: take the square one.
    let cosine = if twice > 0.0 {
        ((upper * upper + reached * reached - lower * lower) / twice).clamp(-1.0, 1.0)
    } else {
        0.0
    };
    let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
    let middle = root + (along * cosine + across * sine) * upper;
    // From the middle joint, not from the root: the lower bone's length is then exact, and the
    // end misses the target by rounding only.
    let onward = direction_or(root + along * reached - middle, along);
    TwoBone { middle, end: middle + onward * lower, clamped }
}

/// The unit direction across `along` that `pole` points to most.
fn across(pole: Vector, along: Vector) -> Vector {
    let pole = direction_or(pole, Vector::zeros());
    let part = pole - along * pole.dot(&along);
    // A pole within 1e-9 rad of the limb says nothing but rounding.
    if part.norm() > 1e-9 {
        // Twice is enough: the first subtraction leaves some of `along` where they are near.
        let unit = part.normalize();
        return direction_or(unit - along * unit.dot(&along), unit);
    }
    let axis = [Vector::x(), Vector::y(), Vector::z()][along.iamin()];
    direction_or(axis - along * axis.dot(&along), axis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vector> {
        [-1.0..1.0, -1.0..1.0, -1.0..1.0].prop_map(|[x, y, z]: [f64; 3]| Vector::new(x, y, z))
    }

    #[track_caller]
    fn check_lengths(root: Point, pose: &TwoBone, upper: f64, lower: f64) {
        assert!(((pose.middle - root).norm() - upper).abs() < 1e-12, "{pose:?}");
        assert!(((pose.end - pose.middle).norm() - lower).abs() < 1e-12, "{pose:?}");
    }

    proptest! {
        #[test]
        fn lengths_hold_and_the_end_is_on_a_reachable_target(
            root in vector(), wanted in vector(), pole in vector(),
            upper in 0.05..0.6, lower in 0.05..0.6,
        ) {
            let root = Point::from(root);
            let target = root + wanted;
            let pose = two_bone(root, target, upper, lower, pole);
            check_lengths(root, &pose, upper, lower);
            let reach = (upper - lower).abs()..upper + lower;
            prop_assert_eq!(pose.clamped, !reach.contains(&wanted.norm()));
            if pose.clamped {
                // On the ray, at the nearer rim.
                let rim = if wanted.norm() > reach.end { reach.end } else { reach.start };
                prop_assert!((pose.end - root - wanted.normalize() * rim).norm() < 1e-9);
            } else {
                prop_assert!((pose.end - target).norm() < 1e-12);
            }
            // The middle joint is on the pole's side of the limb.
            let along = wanted.normalize();
            let bend = pose.middle - root - along * along.dot(&(pose.middle - root));
            prop_assert!(bend.dot(&pole) >= -1e-12);
        }

        #[test]
        fn a_small_move_of_the_target_moves_the_limb_little(
            wanted in vector(), pole in vector(), step in vector(),
            upper in 0.1..0.6, lower in 0.1..0.6,
        ) {
            // Away from the three undefined directions.
            let (pole, along) = (pole.normalize(), wanted.normalize());
            prop_assume!(wanted.norm() > 0.1 && along.cross(&pole).norm() > 0.1);
            let root = Point::origin();
            let here = two_bone(root, root + wanted, upper, lower, pole);
            let there = two_bone(root, root + wanted + step * 1e-8, upper, lower, pole);
            // At the rims the bend grows with the root of the distance: √1e-8, times a factor.
            prop_assert!((here.middle - there.middle).norm() < 1e-3);
            prop_assert!((here.end - there.end).norm() < 1e-6);
        }
    }

    #[test]
    fn undefined_directions_have_a_fixed_answer() {
        let root = Point::new(0.3, -0.2, 1.4);
        let poles = [Vector::zeros(), Vector::x(), -Vector::z(), Vector::new(f64::NAN, 0.0, 0.0)];
        let far = [f64::NAN, f64::INFINITY, 1e300].map(|x| root + Vector::new(x, 0.0, 0.0));
        let near = [0.0, 1e-13, -1e-14, 0.5, -0.5].map(|x| root + Vector::new(x, 0.0, 0.0));
        for pole in poles {
            for (upper, lower) in [(0.3, 0.3), (0.3, 0.2), (0.2, 0.3), (0.0, 0.3), (0.3, 0.0)] {
                for target in far.into_iter().chain(near) {
                    let pose = two_bone(root, target, upper, lower, pole);
                    check_lengths(root, &pose, upper, lower);
                }
                assert!(far.iter().all(|far| two_bone(root, *far, upper, lower, pole).clamped));
            }
        }
        let odd = two_bone(root, root, f64::NAN, -1.0, Vector::z());
        check_lengths(root, &odd, 0.0, 0.0);
    }

    #[test]
    fn a_straight_arm_is_reached_and_a_folded_one_too() {
        let (root, ray) = (Point::origin(), Vector::new(1.0, 2.0, -2.0) / 3.0);
        for (distance, clamped) in [(0.5, false), (0.1, false), (0.51, true), (0.09, true)] {
            let pose = two_bone(root, root + ray * distance, 0.3, 0.2, Vector::z());
            assert_eq!(pose.clamped, clamped, "{distance}");
            check_lengths(root, &pose, 0.3, 0.2);
            assert!((pose.middle.coords.cross(&ray)).norm() < 1e-7, "not on the line: {pose:?}");
        }
    }
}
