//! A skeleton → what the filter asks of its joints: parents, sides, trunk and legs.

use crate::geometry::{Point, Vector, direction_or};
use crate::skeleton::{JointId, Part, Side, Skeleton};

/// What the filter asks of one joint.
#[derive(Debug, Clone)]
pub(super) struct Joint {
    /// What it hangs from: none for the root.
    pub(super) parent: Option<usize>,
    /// Of the spine or the shoulders, or the base: where the person is.
    pub(super) is_trunk: bool,
    /// Of the legs: need never be seen.
    pub(super) is_leg: bool,
    /// Where an unseen one is guessed from its parent `[m]`: towards the left, and down.
    guess: [f64; 2],
}

/// A skeleton as the filter looks at it.
#[derive(Debug, Clone)]
pub(super) struct Body {
    pub(super) joints: Box<[Joint]>,
    /// All joints, parents first.
    pub(super) order: Box<[usize]>,
    /// Whose place is the person's.
    pub(super) base: usize,
    /// `[left, right]` joints of the arms, and of the legs.
    pub(super) pairs: [Box<[[usize; 2]]>; 2],
    shoulders: Option<[usize; 2]>,
}

impl Body {
    pub(super) fn new(skeleton: &Skeleton, base: JointId) -> Self {
        let mut parents = vec![None; skeleton.len()];
        for bone in skeleton.bones() {
            parents[bone.child.index()] = Some(bone.parent.index());
        }
        let joint = |id: JointId| {
            let part = skeleton.part_of(id);
            let parent = parents[id.index()];
            Joint {
                parent,
                is_trunk: id == base || part.is_some_and(is_trunk),
                // What a person stands by cannot be guessed.
                is_leg: id != base && parent.is_some() && part.is_some_and(is_leg),
                guess: part.map_or([0.0; 2], guess),
            }
        };
        let order = [skeleton.root().index()].into_iter();
        let order = order.chain(skeleton.bones().map(|bone| bone.child.index()));
        Self {
            joints: skeleton.joints().map(joint).collect(),
            order: order.collect(),
            base: base.index(),
            pairs: [
                pairs(skeleton, &[Part::Clavicle, Part::Shoulder, Part::Elbow, Part::Hand]),
                pairs(skeleton, &[Part::Hip, Part::Knee, Part::Foot]),
            ],
            shoulders: pairs(skeleton, &[Part::Shoulder]).first().copied(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.joints.len()
    }

    /// Where a joint that was never seen hangs from its parent `[m]`: as on an upright grown-up.
    pub(super) fn guessed_offset(&self, joint: usize, place: impl Fn(usize) -> Point) -> Vector {
        let [left, down] = self.joints[joint].guess;
        let line = self.shoulders.map_or(Vector::zeros(), |[l, r]| place(l) - place(r));
        let line = direction_or(Vector::new(line.x, line.y, 0.0), Vector::zeros());
        line * left - Vector::z() * down
    }
}

fn is_leg(part: Part) -> bool {
    matches!(part, Part::Hip(_) | Part::Knee(_) | Part::Foot(_))
}

fn is_trunk(part: Part) -> bool {
    !is_leg(part) && !matches!(part, Part::Elbow(_) | Part::Hand(_))
}

fn guess(part: Part) -> [f64; 2] {
    match part {
        Part::Hip(Side::Left) => [0.1, 0.2],
        Part::Hip(Side::Right) => [-0.1, 0.2],
        Part::Knee(_) | Part::Foot(_) => [0.0, 0.42],
        _ => [0.0, 0.0],
    }
}

fn pairs(skeleton: &Skeleton, parts: &[fn(Side) -> Part]) -> Box<[[usize; 2]]> {
    let pair = |part: &fn(Side) -> Part| {
        let [left, right] = Side::BOTH.map(|side| skeleton.part(part(side)));
        Some([left?.index(), right?.index()])
    };
    parts.iter().filter_map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arms_legs_and_trunk_of_nite() {
        let skeleton = Skeleton::nite();
        let body = Body::new(&skeleton, skeleton.root());
        let count = |is: fn(&Joint) -> bool| body.joints.iter().filter(|joint| is(joint)).count();
        assert_eq!((count(|j| j.is_trunk), count(|j| j.is_leg)), (5, 6));
        assert_eq!(body.pairs[0][..], [[3, 6], [4, 7], [5, 8]]);
        assert_eq!(body.pairs[1][..], [[9, 12], [10, 13], [11, 14]]);
        assert_eq!(body.order.len(), 15);
        for (at, &joint) in body.order.iter().enumerate() {
            assert!(
                body.joints[joint].parent.is_none_or(|parent| body.order[..at].contains(&parent))
            );
        }
    }
}
