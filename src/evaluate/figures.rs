//! The figures of one clip: how far a prediction is from what the human did.

use crate::demonstration::{Contact, Demonstration, Hands, Observation};
use crate::geometry::{Point, Vector};
use crate::skeleton::{JointId, Part};

/// Within this long of the true contact the hands may meet `[s]`.
const CONTACT_WINDOW: f64 = 0.25;

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
    /// Largest deviation of a bone from the robot's own length `[mm]`.
    Bone,
    /// Mean jerk of the active hand `[m/s³]`.
    Jerk,
}

impl Figure {
    /// All of them, in the order tables show them.
    pub const ALL: [Self; 8] = [
        Self::Joint,
        Self::Hand,
        Self::Contact,
        Self::Gap,
        Self::GapAtContact,
        Self::Timing,
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
}

/// What a clip's predictions are measured against: the same for every method.
#[derive(Debug, Clone)]
pub struct Scene<'a> {
    truth: &'a Demonstration,
    observation: Observation,
    contact: Contact,
    hands: [JointId; 2],
    mean_gap: Vector,
    measured_joints: Vec<JointId>,
}

impl<'a> Scene<'a> {
    /// - `hands`: which hands are active, decided without the robot role's truth.
    /// - `mean_gap`: ḡ `[m]`, in the partner's heading frame.
    /// - `ignored`: the robot's joints that no figure counts, beside its base.
    ///
    /// `None` if a skeleton lacks an active hand.
    pub fn new(
        truth: &'a Demonstration,
        hands: Hands,
        mean_gap: Vector,
        ignored: &[JointId],
    ) -> Option<Self> {
        let robot_hand = truth.robot().skeleton().part(Part::Hand(hands.robot))?;
        let partner_hand = truth.partner().skeleton().part(Part::Hand(hands.partner))?;
        let joints = truth.robot().skeleton().joints();
        let measured = joints.filter(|j| *j != truth.robot_base() && !ignored.contains(j));
        Some(Self {
            truth,
            observation: truth.observation(),
            contact: truth.contact_of(hands)?,
            hands: [robot_hand, partner_hand],
            mean_gap,
            measured_joints: measured.collect(),
        })
    }

    /// The figures of a prediction: `[m]`, `frames × joints`.
    ///
    /// # Panics
    /// If the prediction has not one position per frame and joint.
    pub fn figures(&self, predicted: &[Point]) -> Figures {
        let (robot, partner) = (self.truth.robot(), self.truth.partner());
        let joints = robot.skeleton().len();
        let frames = robot.len();
        assert_eq!(predicted.len(), frames * joints, "one position per frame and joint");
        let at = |frame: usize, joint: JointId| predicted[frame * joints + joint.index()];
        let [hand, partner_hand] = self.hands;
        let miss =
            |frame: usize, joint: JointId| (at(frame, joint) - robot.position(frame, joint)).norm();
        let mean = |sum: f64, count: usize| (count > 0).then(|| sum / count as f64);
        let centimetres = |metres: f64| 100.0 * metres;

        let joint: f64 =
            (0..frames).flat_map(|k| self.measured_joints.iter().map(move |j| miss(k, *j))).sum();
        let whole: f64 = (0..frames).map(|k| miss(k, hand)).sum();
        let gap = |frame: usize| {
            let gap = at(frame, hand) - partner.position(frame, partner_hand);
            (self.observation.gap_in_heading(frame, gap) - self.mean_gap).norm()
        };
        let contact = self.contact.frame;
        let moment = robot.frames()[contact].stamp;
        let since = |frame: usize| robot.frames()[frame].stamp - moment;
        let best = (0..frames)
            .filter(|k| since(*k).seconds().abs() <= CONTACT_WINDOW)
            .min_by(|a, b| gap(*a).total_cmp(&gap(*b)));
        let bones = robot.skeleton().bones().zip(&self.observation.bone_lengths);
        let bone = bones
            .flat_map(|(bone, length)| {
                let lengths =
                    (0..frames).map(move |k| (at(k, bone.child) - at(k, bone.parent)).norm());
                lengths.map(move |found| (found - length).abs())
            })
            .fold(0.0, f64::max);
        let duration = (robot.frames()[frames - 1].stamp - robot.frames()[0].stamp).seconds();
        let step = duration / (frames.max(2) - 1) as f64;
        let jerk = (3..frames).map(|k| {
            let third = (at(k, hand) - at(k - 3, hand)) - 3.0 * (at(k - 1, hand) - at(k - 2, hand));
            third.norm() / step.powi(3)
        });
        Figures([
            mean(joint, frames * self.measured_joints.len()).map(centimetres),
            mean(whole, frames).map(centimetres),
            Some(centimetres(miss(contact, hand))),
            best.map(|k| centimetres(gap(k))),
            Some(centimetres(gap(contact))),
            best.map(|k| since(k).milliseconds()),
            Some(1000.0 * bone),
            mean(jerk.sum(), frames.saturating_sub(3)),
        ])
    }
}
