//! What is measured of a trial, and so can be bounded.

/// A figure of a trial; [`Self::key`] has its unit.
///
/// "The hand" is the robot's active hand; its error is `‖gap − ḡ‖`: the gap from the partner's true
/// hand, in the partner's heading frame, against the demonstrations' mean at their contact. Instants
/// are those of the robot as it is, not of its targets, where nothing else is said.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Figure {
    /// The least error within 0.25 s of the scene's contact.
    Gap,
    /// The error at the scene's contact.
    GapAtContact,
    /// How long after the scene's contact the error is least, within 0.25 s of it.
    Timing,
    /// How long after the scene's contact the error is first at most 10 cm, counted from 0.25 s
    /// before it.
    ContactAfter,
    /// How much later than the scene's giver the hand has done 90 % of its reach; negative: sooner.
    Lag,
    /// Which share of the way from rest to the place of the giver's hand at the planned contact the
    /// hand does: 1 there, 0 if it gets no nearer.
    Reach,
    /// How far the hand gets from where it was before the scene's giver sets out.
    Early,
    /// Ticks without a target or with a reason to hold, as a share of all.
    Held,
    /// For how long the reason to hold is that the partner is, or would be, too near.
    HeldApart,
    /// Fastest target of any joint.
    Speed,
    /// Largest acceleration of any joint's target.
    Acceleration,
    /// Largest error of a bone's length in any target.
    Bone,
    /// Least distance of either hand to the partner's head, neck and torso.
    Separation,
    /// How far, in all, the robot's own motion brought a hand nearer to these while it was nearer
    /// than the gate is to keep.
    Crept,
    /// How far the hand gets, during what goes wrong at the sensor, from where it was.
    Disturbed,
    /// How long after the last message the target stands for good; undefined while messages come.
    StandsAfter,
    /// How far the hand is from rest at the end: from where it was at the start, or from where the
    /// giver's hangs after a handover.
    Rest,
    /// Fastest the hand is in the last half second.
    EndSpeed,
}

impl Figure {
    /// All of them, in the order tables show them.
    pub const ALL: [Self; 18] = [
        Self::Gap,
        Self::GapAtContact,
        Self::Timing,
        Self::ContactAfter,
        Self::Lag,
        Self::Reach,
        Self::Early,
        Self::Held,
        Self::HeldApart,
        Self::Speed,
        Self::Acceleration,
        Self::Bone,
        Self::Separation,
        Self::Crept,
        Self::Disturbed,
        Self::StandsAfter,
        Self::Rest,
        Self::EndSpeed,
    ];

    /// The name with its unit, as in results; bounds add `_most` or `_least`.
    pub fn key(self) -> &'static str {
        match self {
            Self::Gap => "gap_cm",
            Self::GapAtContact => "gap_at_contact_cm",
            Self::Timing => "timing_ms",
            Self::ContactAfter => "contact_after_s",
            Self::Lag => "lag_ms",
            Self::Reach => "reach_share",
            Self::Early => "early_m",
            Self::Held => "held_share",
            Self::HeldApart => "held_apart_s",
            Self::Speed => "speed_m_s",
            Self::Acceleration => "acceleration_m_s2",
            Self::Bone => "bone_mm",
            Self::Separation => "separation_m",
            Self::Crept => "crept_m",
            Self::Disturbed => "disturbed_m",
            Self::StandsAfter => "stands_after_s",
            Self::Rest => "rest_m",
            Self::EndSpeed => "end_speed_m_s",
        }
    }

    /// Whether it is of the scene's contact, which there is none of if the partner withdraws.
    pub fn needs_contact(self) -> bool {
        use Figure::{ContactAfter, Gap, GapAtContact, Lag, Timing};
        matches!(self, Gap | GapAtContact | Timing | ContactAfter | Lag)
    }
}
