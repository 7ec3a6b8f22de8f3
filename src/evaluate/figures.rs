//! The figures of one clip: how far a prediction is from what the human did, or from meeting the
//! partner's hand.

/// The figures a table may show, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Figure {
    /// Mean distance of a joint from the human's `[cm]`, known and ignored joints left out.
    Joint,
    /// Mean distance of the active hand `[cm]`.
    Hand,
    /// Distance of the active hand `[cm]` at the frame where the true hands are closest.
    Contact,
    /// Smallest deviation `[cm]` of the hands' gap from the demonstrations' mean gap, within
    /// ±0.25 s of the true contact.
    Gap,
    /// That deviation at the true contact itself `[cm]`.
    GapAtContact,
    /// When the gap deviates least, minus the true contact `[ms]`; summed up without sign.
    Timing,
    /// When the hand has come 90 % of the human's way to contact, minus when the human had `[ms]`:
    /// above 0 is late; summed up with sign, of hands that come so far at all.
    Reach,
    /// Largest deviation of a bone from the robot's own length `[mm]`.
    Bone,
    /// Mean jerk of the active hand `[m/s³]`.
    Jerk,
}

impl Figure {
    /// All of them, in the order tables show them.
    pub const ALL: [Self; 9] = [
        Self::Joint,
        Self::Hand,
        Self::Contact,
        Self::Gap,
        Self::GapAtContact,
        Self::Timing,
        Self::Reach,
        Self::Bone,
        Self::Jerk,
    ];

    /// The name in JSON, with the unit.
    pub fn name(self) -> &'static str {
        match self {
            Self::Joint => "joint_cm",
            Self::Hand => "hand_cm",
            Self::Contact => "contact_cm",
            Self::Gap => "gap_cm",
            Self::GapAtContact => "gap_at_contact_cm",
            Self::Timing => "timing_ms",
            Self::Reach => "reach_ms",
            Self::Bone => "bone_mm",
            Self::Jerk => "jerk_m_s3",
        }
    }
}

/// A clip's figures, in [`Figure::ALL`]'s order; undefined ones are `None`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Figures([Option<f64>; Figure::ALL.len()]);

impl Figures {
    /// One figure.
    pub fn get(&self, figure: Figure) -> Option<f64> {
        self.0[figure as usize]
    }

    /// The same with one figure more.
    pub(super) fn with(mut self, figure: Figure, value: Option<f64>) -> Self {
        self.0[figure as usize] = value;
        self
    }
}
