//! Exact bones: joints moved until every bone has its length, hands where they were solved.

use crate::geometry::{Point, Vector, direction_or};
use crate::kinematics::two_bone;
use crate::skeleton::{JointId, Side, Skeleton};

/// Gives every bone its exact length.
///
/// Root outwards, a child goes along the solved direction from its parent's new place. That alone
/// would shift a hand by all the errors above it; so an arm is laid between its shoulder's new place
/// and its solved hand by two-bone inverse kinematics, bent the way it was solved. A hand out
/// of reach is as near as it can be. (Legs are left: nearly straight, their knees would flutter.)
///
/// - `positions`: `[m]`, one person's joints in one frame, changed in place; the root stays.
/// - `lengths`: `[m]`, in the skeleton's bone order.
///
/// A bone of no length points down. Allocates nothing.
///
/// # Panics
/// If `positions` or `lengths` do not fit the skeleton: the caller's bug.
pub fn project_bones(skeleton: &Skeleton, lengths: &[f64], positions: &mut [Point]) {
    assert_eq!(positions.len(), skeleton.len(), "one position per joint");
    assert_eq!(lengths.len(), skeleton.bones().len(), "one length per bone");
    // What each joint has moved: directions are taken from the solution, so that a joint's shift
    // never turns the bones beyond it.
    let mut shifts = [Vector::zeros(); Skeleton::MAX_JOINTS];
    let arms = Side::BOTH.map(|side| Arm::of(skeleton, lengths, side));
    for (bone, length) in skeleton.bones().zip(lengths) {
        let (parent, child) = (bone.parent, bone.child);
        let new_parent = positions[parent.index()];
        let along = positions[child.index()] - (new_parent - shifts[parent.index()]);
        if arms.iter().flatten().any(|arm| arm.hand == child) {
            // Has had its turn with its elbow.
        } else if let Some(arm) = arms.iter().flatten().find(|arm| arm.elbow == child) {
            let hand = positions[arm.hand.index()];
            let bent = two_bone(new_parent, hand, arm.upper, arm.lower, along);
            shift(positions, &mut shifts, arm.elbow, bent.middle);
            shift(positions, &mut shifts, arm.hand, bent.end);
        } else {
            let place = new_parent + direction_or(along, -Vector::z()) * *length;
            shift(positions, &mut shifts, child, place);
        }
    }
}

fn shift(positions: &mut [Point], shifts: &mut [Vector], joint: JointId, place: Point) {
    shifts[joint.index()] = place - positions[joint.index()];
    positions[joint.index()] = place;
}

/// A shoulder's two bones `[m]`, where elbow and hand hang from it one behind the other.
struct Arm {
    elbow: JointId,
    hand: JointId,
    upper: f64,
    lower: f64,
}

impl Arm {
    fn of(skeleton: &Skeleton, lengths: &[f64], side: Side) -> Option<Self> {
        let [shoulder, elbow, hand] = skeleton.arm(side)?;
        let length = |parent, child| {
            let mut bones = skeleton.bones().zip(lengths);
            let found = bones.find(|(bone, _)| bone.parent == parent && bone.child == child);
            found.map(|(_, length)| *length)
        };
        Some(Self { elbow, hand, upper: length(shoulder, elbow)?, lower: length(elbow, hand)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn solved(noise: &[f64]) -> Vec<Point> {
        let joint = |i: usize| Point::new(noise[3 * i], noise[3 * i + 1], noise[3 * i + 2]);
        (0..15).map(joint).collect()
    }

    proptest! {
        #[test]
        fn lengths_become_exact_and_reachable_hands_stay(
            noise in prop::collection::vec(-0.5f64..0.5, 45),
            scale in 0.1f64..0.6,
        ) {
            let skeleton = Skeleton::nite();
            let lengths: Vec<f64> = (0..14).map(|i| scale + 0.01 * f64::from(i)).collect();
            let solved = solved(&noise);
            let mut exact = solved.clone();
            project_bones(&skeleton, &lengths, &mut exact);
            prop_assert_eq!(exact[skeleton.root().index()], solved[skeleton.root().index()]);
            for (bone, length) in skeleton.bones().zip(&lengths) {
                let along = exact[bone.child.index()] - exact[bone.parent.index()];
                prop_assert!((along.norm() - length).abs() < 1e-12);
            }
            for side in Side::BOTH {
                let [root, _, end] = skeleton.arm(side).unwrap();
                let Arm { upper, lower, .. } = Arm::of(&skeleton, &lengths, side).unwrap();
                let away = (solved[end.index()] - exact[root.index()]).norm();
                let reach = (away - (upper + lower)).max((upper - lower).abs() - away).max(0.0);
                let off = (exact[end.index()] - solved[end.index()]).norm();
                prop_assert!((off - reach).abs() < 1e-9, "{off} {reach}");
            }
            // The trunk keeps its solved directions.
            let [torso, neck] = [2, 1];
            let turned = (exact[neck] - exact[torso]).normalize() - (solved[neck] - solved[torso]).normalize();
            prop_assert!(turned.norm() < 1e-9);
        }

        /// Joints beyond a hand go with it.
        #[test]
        fn fingers_keep_their_bones(noise in prop::collection::vec(-0.5f64..0.5, 15)) {
            let names = ["torso", "left_shoulder", "left_elbow", "left_hand", "finger"];
            let bones = [[0, 1], [1, 2], [2, 3], [3, 4]];
            let skeleton = Skeleton::new(names.map(String::from).to_vec(), &bones).unwrap();
            let mut positions: Vec<Point> =
                noise.chunks_exact(3).map(|p| Point::new(p[0], p[1], p[2])).collect();
            let lengths = [0.2, 0.3, 0.25, 0.1];
            project_bones(&skeleton, &lengths, &mut positions);
            for (bone, length) in skeleton.bones().zip(lengths) {
                let along = positions[bone.child.index()] - positions[bone.parent.index()];
                prop_assert!((along.norm() - length).abs() < 1e-12);
            }
        }

        #[test]
        fn exact_bones_are_left_alone(noise in prop::collection::vec(-0.5f64..0.5, 45)) {
            let skeleton = Skeleton::nite();
            let exact = solved(&noise);
            let bones = skeleton.bones();
            let lengths: Vec<f64> =
                bones.map(|b| (exact[b.child.index()] - exact[b.parent.index()]).norm()).collect();
            let mut again = exact.clone();
            project_bones(&skeleton, &lengths, &mut again);
            // A nearly straight arm's elbow is the worst conditioned: square root of rounding.
            prop_assert!(exact.iter().zip(&again).all(|(a, b)| (a - b).norm() < 1e-6));
        }
    }
}
