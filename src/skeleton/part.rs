//! Joint names → body parts: which name means a left hand, and what each part hangs from.
//!
//! Files name joints as their sensor's maker did; the code asks for parts. The default names are
//! OpenNI/NiTE's; OptiTrack's (`LUArm`: a bone is placed at its proximal joint) are known too.

/// The person's own left or right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// The person's left.
    Left,
    /// The person's right.
    Right,
}

impl Side {
    /// Both, left first: the order in which ties are broken.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }

    /// The other one.
    pub fn opposite(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }
}

/// A place on the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Part {
    /// Head.
    Head,
    /// Neck, between the shoulders.
    Neck,
    /// Upper spine.
    Chest,
    /// Middle of the spine: NiTE's centre of the trunk.
    Torso,
    /// Lower spine.
    Abdomen,
    /// Between the hips.
    Pelvis,
    /// Inner end of the collar bone.
    Clavicle(Side),
    /// Shoulder joint.
    Shoulder(Side),
    /// Elbow.
    Elbow(Side),
    /// Hand or wrist: the arm's last joint.
    Hand(Side),
    /// Hip joint.
    Hip(Side),
    /// Knee.
    Knee(Side),
    /// Foot or ankle: the leg's last joint.
    Foot(Side),
}

/// The spine from the ground up; the lowest one present is a skeleton's root.
pub(super) const SPINE: [Part; 6] =
    [Part::Pelvis, Part::Abdomen, Part::Torso, Part::Chest, Part::Neck, Part::Head];

use Part::{Clavicle, Elbow, Foot, Hand, Hip, Knee, Shoulder};
use Side::{Left, Right};

/// Every known name; the first one of a part is its default. The order is the joints' canonical
/// order in a skeleton read from a file (NiTE's own for its fifteen).
const NAMES: [(&str, Part); 33] = [
    ("head", Part::Head),
    ("neck", Part::Neck),
    ("chest", Part::Chest),
    ("torso", Part::Torso),
    ("ab", Part::Abdomen),
    ("abdomen", Part::Abdomen),
    ("hip", Part::Pelvis),
    ("pelvis", Part::Pelvis),
    ("LShoulder", Clavicle(Left)),
    ("left_clavicle", Clavicle(Left)),
    ("left_shoulder", Shoulder(Left)),
    ("LUArm", Shoulder(Left)),
    ("left_elbow", Elbow(Left)),
    ("LFArm", Elbow(Left)),
    ("left_hand", Hand(Left)),
    ("left_wrist", Hand(Left)),
    ("LHand", Hand(Left)),
    ("RShoulder", Clavicle(Right)),
    ("right_clavicle", Clavicle(Right)),
    ("right_shoulder", Shoulder(Right)),
    ("RUArm", Shoulder(Right)),
    ("right_elbow", Elbow(Right)),
    ("RFArm", Elbow(Right)),
    ("right_hand", Hand(Right)),
    ("right_wrist", Hand(Right)),
    ("RHand", Hand(Right)),
    ("left_hip", Hip(Left)),
    ("left_knee", Knee(Left)),
    ("left_foot", Foot(Left)),
    ("left_ankle", Foot(Left)),
    ("right_hip", Hip(Right)),
    ("right_knee", Knee(Right)),
    ("right_foot", Foot(Right)),
];

/// Every name [`Part::from_name`] knows, in canonical joint order.
pub(super) fn known_names() -> impl Iterator<Item = &'static str> {
    NAMES.iter().map(|(name, _)| *name)
}

/// Where `name` stands in the canonical joint order.
pub(super) fn canonical_rank(name: &str) -> Option<usize> {
    NAMES.iter().position(|(known, _)| *known == name)
}

impl Part {
    /// The part a joint of this name is, if the name is known (names are case-sensitive).
    pub fn from_name(name: &str) -> Option<Self> {
        canonical_rank(name).map(|rank| NAMES[rank].1)
    }

    /// The same part on the other side; a part of the spine is its own.
    pub fn mirrored(self) -> Self {
        match self {
            Clavicle(side) => Clavicle(side.opposite()),
            Shoulder(side) => Shoulder(side.opposite()),
            Elbow(side) => Elbow(side.opposite()),
            Hand(side) => Hand(side.opposite()),
            Hip(side) => Hip(side.opposite()),
            Knee(side) => Knee(side.opposite()),
            Foot(side) => Foot(side.opposite()),
            spine => spine,
        }
    }

    /// What this part hangs from: candidates, nearest first; a skeleton takes the first it has.
    pub(super) fn parents(self) -> Vec<Self> {
        let spine_down_from = |top: Self| {
            let end = SPINE.iter().position(|part| *part == top).map_or(0, |at| at + 1);
            SPINE[..end].iter().rev().copied().collect::<Vec<_>>()
        };
        let mut parents = match self {
            Hand(side) => vec![Elbow(side), Shoulder(side), Clavicle(side)],
            Elbow(side) => vec![Shoulder(side), Clavicle(side)],
            Shoulder(side) => vec![Clavicle(side)],
            Foot(side) => vec![Knee(side), Hip(side)],
            Knee(side) => vec![Hip(side)],
            _ => Vec::new(),
        };
        match self {
            Clavicle(_) => parents.extend(spine_down_from(Self::Chest)),
            Hand(_) | Elbow(_) | Shoulder(_) => parents.extend(spine_down_from(Self::Neck)),
            // Legs hang from the lowest part of the spine there is.
            Hip(_) | Knee(_) | Foot(_) => parents.extend(SPINE),
            spine => parents.extend(spine_down_from(spine).into_iter().skip(1)),
        }
        parents
    }
}
