//! The baseline `attach`: what is done by hand where there is no learning.
//!
//! The body replays the nearest demonstration; the active arm is led by two-bone inverse
//! kinematics to the partner's hand plus the mean gap, faded in before contact and out after it.

use super::aligned::Alignment;
use crate::demonstration::Observation;
use crate::geometry::{Point, Vector};
use crate::kinematics::two_bone;
use crate::skeleton::Part;

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
    let (Some([shoulder, elbow, hand]), Some(partner_hand)) =
        (skeleton.arm(hands.robot), observation.partner.skeleton().part(Part::Hand(hands.partner)))
    else {
        return predicted;
    };
    let length = |child| {
        let mut bones = skeleton.bones().zip(&observation.bone_lengths);
        bones.find(|(bone, _)| bone.child == child).map_or(0.0, |(_, length)| *length)
    };
    let (upper, lower) = (length(elbow), length(hand));
    for (k, pose) in predicted.chunks_exact_mut(skeleton.len()).enumerate() {
        let share = observation.nearness(k, nearest.contact, fade);
        let goal = observation.partner.position(k, partner_hand) + observation.gap_in_world(k, gap);
        let (root, replayed) = (pose[shoulder.index()], pose[hand.index()]);
        let pole = pose[elbow.index()] - root;
        let arm = two_bone(root, replayed + (goal - replayed) * share, upper, lower, pole);
        pose[elbow.index()] = arm.middle;
        pose[hand.index()] = arm.end;
    }
    predicted
}
