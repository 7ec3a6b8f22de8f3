//! The baseline `attach`: what is done by hand where there is no learning.
//!
//! The body replays the nearest demonstration; the active arm is led by two-bone inverse
//! kinematics to the partner's hand plus the mean gap, faded in before contact and out after it.

use super::aligned::Alignment;
use crate::demonstration::Observation;
use crate::geometry::{Point, Vector};
use crate::kinematics::two_bone;
use crate::skeleton::{Part, Side, Skeleton};

/// - `gap`: robot's hand minus partner's `[m]`, in the partner's heading frame.
/// - `fade`: `[s]` before and after contact.
pub(super) fn predict(
    observation: &Observation,
    alignment: &Alignment,
    gap: Vector,
    fade: f64,
) -> Vec<Point> {
    let nearest = &alignment.all[alignment.nearest[0].0];
    let mut predicted = nearest.robot.clone();
    let skeleton = &observation.robot_skeleton;
    let hands = alignment.hands;
    let Some(partner_hand) = observation.partner.skeleton().part(Part::Hand(hands.partner)) else {
        return predicted;
    };
    for (k, pose) in predicted.chunks_exact_mut(skeleton.len()).enumerate() {
        let share = observation.nearness(k, nearest.contact, fade);
        let goal = observation.partner.position(k, partner_hand) + observation.gap_in_world(k, gap);
        lead_hand(skeleton, &observation.bone_lengths, hands.robot, pose, goal, share);
    }
    predicted
}

/// Leads a pose's hand by a share of its way to a goal, the arm bent as it was; a skeleton without
/// such an arm stays as it is.
///
/// - `lengths`: `[m]`, in the skeleton's bone order.
/// - `pose`: `[m]`, one per joint, changed in place.
/// - `goal`: `[m]`.
/// - `share`: `[-]`, 0 to 1.
pub fn lead_hand(
    skeleton: &Skeleton,
    lengths: &[f64],
    side: Side,
    pose: &mut [Point],
    goal: Point,
    share: f64,
) {
    let Some([shoulder, elbow, hand]) = skeleton.arm(side) else { return };
    let length = |child| {
        let mut bones = skeleton.bones().zip(lengths);
        bones.find(|(bone, _)| bone.child == child).map_or(0.0, |(_, length)| *length)
    };
    let (root, now) = (pose[shoulder.index()], pose[hand.index()]);
    let pole = pose[elbow.index()] - root;
    let arm = two_bone(root, now + (goal - now) * share, length(elbow), length(hand), pole);
    pose[elbow.index()] = arm.middle;
    skeleton.shift_with_riders(hand, arm.end - now, pose);
    pose[hand.index()] = arm.end;
}
