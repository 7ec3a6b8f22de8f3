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
    // Directions are those of the solution, so a child's shift never turns its own children.
    let mut shifts = [Vector::zeros(); Skeleton::MAX_JOINTS];
    let arms = Side::BOTH.map(|side| skeleton.arm(side));
    for (bone, length) in skeleton.bones().zip(lengths) {
        let (parent, child) = (bone.parent, bone.child);
        let solved = |joint: JointId| positions[joint.index()] - shifts[joint.index()];
        let arm =
            arms.into_iter().flatten().find(|[_, elbow, hand]| [elbow, hand].contains(&&child));
        let lower = arm.and_then(|[_, elbow, hand]| length_between(skeleton, lengths, elbow, hand));
        let places = match (arm, lower) {
            // The upper arm's turn: elbow and hand together.
            (Some([shoulder, elbow, hand]), Some(lower))
                if [shoulder, elbow] == [parent, child] =>
            {
                let (root, pole) = (positions[shoulder.index()], solved(elbow) - solved(shoulder));
                let arm = two_bone(root, positions[hand.index()], *length, lower, pole);
                [Some((elbow, arm.middle)), Some((hand, arm.end))]
            }
            // The forearm has had its turn, if its upper arm is a bone too.
            (Some([shoulder, elbow, hand]), Some(_))
                if [elbow, hand] == [parent, child]
                    && length_between(skeleton, lengths, shoulder, elbow).is_some() =>
            {
                [None, None]
            }
            _ => {
                let along = direction_or(positions[child.index()] - solved(parent), -Vector::z());
                [Some((child, positions[parent.index()] + along * *length)), None]
            }
        };
        for (joint, place) in places.into_iter().flatten() {
            shifts[joint.index()] = place - positions[joint.index()];
            positions[joint.index()] = place;
        }
    }
}

/// The length of the bone between two joints, if there is one.
fn length_between(
    skeleton: &Skeleton,
    lengths: &[f64],
    parent: JointId,
    child: JointId,
) -> Option<f64> {
    let mut bones = skeleton.bones().zip(lengths);
    let found = bones.find(|(bone, _)| bone.parent == parent && bone.child == child);
    found.map(|(_, length)| *length)
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
            for [root, middle, end] in Side::BOTH.map(|side| skeleton.arm(side).unwrap()) {
                let upper = length_between(&skeleton, &lengths, root, middle).unwrap();
                let lower = length_between(&skeleton, &lengths, middle, end).unwrap();
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
