//! Joint names and bones of one kind of skeleton, checked to be a tree.

use std::fmt;
use std::sync::Arc;

use super::part::{SPINE, canonical_rank, known_names};
use super::{Part, Side};

/// A joint of a [`Skeleton`]: its place in the skeleton's order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JointId(u16);

impl JointId {
    /// The joint's place in a frame's positions.
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// A rigid link between two joints, named from the root outwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Bone {
    /// The end nearer the root.
    pub parent: JointId,
    /// The end farther from the root.
    pub child: JointId,
}

/// Named joints and the bones between them: a tree, shared by every frame of a sequence.
///
/// ```
/// use handover_mesh::{Part, Side, Skeleton};
/// let skeleton = Skeleton::nite();
/// assert_eq!((skeleton.len(), skeleton.bones().count()), (15, 14));
/// let hand = skeleton.part(Part::Hand(Side::Right)).unwrap();
/// assert_eq!(skeleton.name(hand), "right_hand");
/// assert_eq!(skeleton.name(skeleton.root()), "torso");
/// ```
#[derive(Clone, PartialEq, Eq)]
pub struct Skeleton {
    names: Box<[String]>,
    parts: Box<[Option<Part>]>,
    /// Root outwards: a bone's parent is the root or the child of an earlier bone.
    bones: Box<[Bone]>,
    root: JointId,
    /// The first of the attached joints, which are behind all others, as are their bones.
    own: u16,
}

/// Why some names and bones are no skeleton.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SkeletonError {
    /// Too few joints for a bone, or more than any person has.
    #[error("a skeleton has 2 to {} joints, got {count}", Skeleton::MAX_JOINTS)]
    Count {
        /// How many were given.
        count: usize,
    },
    /// Two joints share a name.
    #[error("joint '{name}' appears twice")]
    Repeated {
        /// The shared name.
        name: String,
    },
    /// No bone can be given to a joint whose name is not known.
    #[error("unknown joint '{name}'; known are: {}", known_names().collect::<Vec<_>>().join(" "))]
    Unknown {
        /// The name.
        name: String,
    },
    /// Two names mean the same part of the body.
    #[error("joints '{first}' and '{second}' are the same part of the body")]
    SamePart {
        /// The earlier name.
        first: String,
        /// The later name.
        second: String,
    },
    /// The bones do not join all joints in one tree.
    #[error("bones must join all joints in one tree; '{joint}' has {problem}")]
    NotATree {
        /// A joint at fault.
        joint: String,
        /// What is wrong there.
        problem: &'static str,
    },
}

impl Skeleton {
    /// More joints than any tracker gives a body.
    pub const MAX_JOINTS: usize = 64;

    /// The fifteen joints of OpenNI/NiTE, the product's default.
    pub fn nite() -> Arc<Self> {
        const NAMES: [&str; 15] = [
            "head",
            "neck",
            "torso",
            "left_shoulder",
            "left_elbow",
            "left_hand",
            "right_shoulder",
            "right_elbow",
            "right_hand",
            "left_hip",
            "left_knee",
            "left_foot",
            "right_hip",
            "right_knee",
            "right_foot",
        ];
        #[expect(clippy::unwrap_used, reason = "a constant that the tests hold")]
        Arc::new(Self::from_names(NAMES.map(String::from).to_vec()).unwrap())
    }

    /// A skeleton in this joint order, its bones by what each named part hangs from.
    ///
    /// A missing part is skipped: without a neck the shoulders hang from the torso.
    ///
    /// # Errors
    /// [`SkeletonError`] on an unknown or repeated name or part, or too few joints.
    pub fn from_names(names: Vec<String>) -> Result<Self, SkeletonError> {
        check_names(&names)?;
        let mut parts = Vec::with_capacity(names.len());
        for name in &names {
            let Some(part) = Part::from_name(name) else {
                return Err(SkeletonError::Unknown { name: name.clone() });
            };
            if let Some(first) = parts.iter().position(|known| *known == part) {
                let (first, second) = (names[first].clone(), name.clone());
                return Err(SkeletonError::SamePart { first, second });
            }
            parts.push(part);
        }
        let find = |wanted: &Part| parts.iter().position(|part| part == wanted);
        let root = SPINE.iter().find_map(find);
        let bones = parts.iter().enumerate().filter(|(child, _)| Some(*child) != root);
        let bones: Vec<[usize; 2]> = bones
            .filter_map(|(child, part)| Some([part.parents().iter().find_map(find)?, child]))
            .collect();
        Self::new(names, &bones)
    }

    /// A skeleton of these joints and `[parent, child]` bones (indices into `names`).
    ///
    /// Names may be any; only known ones are found by [`Self::part`].
    ///
    /// # Errors
    /// [`SkeletonError`] on a repeated name, a bad count, or bones that are not one tree.
    pub fn new(names: Vec<String>, bones: &[[usize; 2]]) -> Result<Self, SkeletonError> {
        check_names(&names)?;
        let fault = |joint: usize, problem| SkeletonError::NotATree {
            joint: names.get(joint).cloned().unwrap_or_else(|| format!("#{joint}")),
            problem,
        };
        let mut parents = vec![None; names.len()];
        for &[parent, child] in bones {
            if parent >= names.len() || child >= names.len() {
                return Err(fault(parent.max(child), "a bone but is no joint"));
            }
            if parents[child].replace(parent).is_some() {
                return Err(fault(child, "two parents"));
            }
        }
        let mut roots = (0..names.len()).filter(|&joint| parents[joint].is_none());
        let root = roots.next().ok_or_else(|| fault(0, "a cycle of bones above it"))?;
        if let Some(second) = roots.next() {
            return Err(fault(second, "no parent, and is not the only one"));
        }
        // Breadth first: whatever is not reached from the one root hangs in a cycle.
        let mut ordered = Vec::with_capacity(bones.len());
        let mut reached = vec![root];
        let mut at = 0;
        while let Some(&parent) = reached.get(at) {
            for child in (0..names.len()).filter(|&child| parents[child] == Some(parent)) {
                ordered.push(Bone { parent: id(parent), child: id(child) });
                reached.push(child);
            }
            at += 1;
        }
        if let Some(lost) = (0..names.len()).find(|joint| !reached.contains(joint)) {
            return Err(fault(lost, "a cycle of bones above it"));
        }
        let parts = names.iter().map(|name| Part::from_name(name)).collect();
        let own = names.len() as u16;
        Ok(Self { names: names.into(), parts, bones: ordered.into(), root: id(root), own })
    }

    /// The same with points that ride on a joint, behind all others: joints that are no part of the
    /// body, whatever they are called. See [`Riders`](super::Riders).
    ///
    /// # Errors
    /// [`SkeletonError::Repeated`], [`SkeletonError::Count`].
    pub fn with_attached(&self, joint: JointId, points: &[String]) -> Result<Self, SkeletonError> {
        let names = [&*self.names, points].concat();
        check_names(&names)?;
        let parts = self.parts.iter().copied().chain(points.iter().map(|_| None)).collect();
        let attached = (self.len()..names.len()).map(|at| Bone { parent: joint, child: id(at) });
        let bones = self.bones().chain(attached).collect();
        Ok(Self { names: names.into(), parts, bones, root: self.root, own: self.own })
    }

    /// The same without the points that ride on it.
    pub fn without_attached(&self) -> Self {
        let own = self.own();
        Self {
            names: self.names[..own].into(),
            parts: self.parts[..own].into(),
            // A tree has a bone less than joints.
            bones: self.bones[..own - 1].into(),
            ..self.clone()
        }
    }

    /// The number of the person's own joints: the first ones. Those behind are attached, and no
    /// figure counts them.
    pub fn own(&self) -> usize {
        usize::from(self.own)
    }

    /// The points that ride on a joint, in order.
    pub fn attached(&self) -> impl ExactSizeIterator<Item = JointId> + use<> {
        (self.own..self.len() as u16).map(JointId)
    }

    /// The number of joints, those attached among them.
    #[expect(clippy::len_without_is_empty, reason = "a skeleton has joints")]
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// All joints, in order.
    pub fn joints(&self) -> impl ExactSizeIterator<Item = JointId> + use<> {
        (0..self.len() as u16).map(JointId)
    }

    /// The bones, root outwards: a parent is the root or the child of an earlier bone.
    pub fn bones(&self) -> impl ExactSizeIterator<Item = Bone> + '_ {
        self.bones.iter().copied()
    }

    /// The joint all others hang from: the lowest part of the spine.
    pub fn root(&self) -> JointId {
        self.root
    }

    /// The joint's name, as its source spelled it.
    pub fn name(&self, joint: JointId) -> &str {
        &self.names[joint.index()]
    }

    /// All names, in joint order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The joint of this name.
    pub fn joint(&self, name: &str) -> Option<JointId> {
        self.names.iter().position(|known| known == name).map(id)
    }

    /// The joint that is this part of the body.
    pub fn part(&self, part: Part) -> Option<JointId> {
        self.parts.iter().position(|known| *known == Some(part)).map(id)
    }

    /// The part of the body this joint is, where its name is known.
    pub fn part_of(&self, joint: JointId) -> Option<Part> {
        self.parts[joint.index()]
    }

    /// Shoulder, elbow and hand of one arm, where the skeleton has all three.
    pub fn arm(&self, side: Side) -> Option<[JointId; 3]> {
        let [shoulder, elbow, hand] =
            [Part::Shoulder(side), Part::Elbow(side), Part::Hand(side)].map(|p| self.part(p));
        Some([shoulder?, elbow?, hand?])
    }

    /// `names` in canonical joint order; unknown ones keep their order behind the known.
    pub fn sort_names(names: &mut [String]) {
        names.sort_by_key(|name| canonical_rank(name).unwrap_or(usize::MAX));
    }
}

fn id(index: usize) -> JointId {
    // Held by check_names: at most MAX_JOINTS.
    JointId(index as u16)
}

fn check_names(names: &[String]) -> Result<(), SkeletonError> {
    if !(2..=Skeleton::MAX_JOINTS).contains(&names.len()) {
        return Err(SkeletonError::Count { count: names.len() });
    }
    match names.iter().enumerate().find(|(at, name)| names[..*at].contains(name)) {
        Some((_, name)) => Err(SkeletonError::Repeated { name: name.clone() }),
        None => Ok(()),
    }
}

impl fmt::Debug for Skeleton {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Skeleton[{}]", self.names.join(" "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(names: &str) -> Result<Skeleton, SkeletonError> {
        Skeleton::from_names(names.split(' ').map(String::from).collect())
    }

    #[track_caller]
    fn check_bones(names: &str, expected: &str) {
        let skeleton = named(names).unwrap();
        let bones = skeleton
            .bones()
            .map(|bone| format!("{}-{}", skeleton.name(bone.parent), skeleton.name(bone.child)));
        assert_eq!(bones.collect::<Vec<_>>().join(" "), expected);
    }

    #[test]
    fn bones_follow_the_parts_that_are_there() {
        check_bones(
            &Skeleton::nite().names().join(" "),
            "torso-neck torso-left_hip torso-right_hip neck-head neck-left_shoulder \
             neck-right_shoulder left_hip-left_knee right_hip-right_knee \
             left_shoulder-left_elbow right_shoulder-right_elbow left_knee-left_foot \
             right_knee-right_foot left_elbow-left_hand right_elbow-right_hand",
        );
        check_bones(
            "torso head left_shoulder left_hand",
            "torso-head torso-left_shoulder left_shoulder-left_hand",
        );
        check_bones(
            "hip ab chest neck head RShoulder RUArm RFArm RHand",
            "hip-ab ab-chest chest-neck chest-RShoulder neck-head RShoulder-RUArm RUArm-RFArm RFArm-RHand",
        );
    }

    #[test]
    fn what_is_no_skeleton_is_refused_by_name() {
        let text = |names| named(names).unwrap_err().to_string();
        assert!(text("head neck tail").contains("unknown joint 'tail'"));
        assert!(text("head neck head").contains("'head' appears twice"));
        assert!(text("torso left_hand left_wrist").contains("same part"));
        assert!(text("head").contains("got 1"));
        let names = |n: usize| (0..n).map(|i| format!("j{i}")).collect::<Vec<_>>();
        for bones in
            [&[[0, 1], [2, 1]][..], &[[0, 1]], &[[0, 1], [1, 0], [2, 2]], &[[0, 1], [0, 7]]]
        {
            assert!(Skeleton::new(names(3), bones).is_err(), "{bones:?}");
        }
        assert!(Skeleton::new(names(65), &[]).is_err());
    }
}
