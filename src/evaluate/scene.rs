//! What a prediction is measured against: a [`Scene`] asks for the demonstrations' gap to the
//! partner's hand at the right moment, a [`KnownScene`] also for what the human did.

use super::{Figure, Figures};
use crate::demonstration::{Demonstration, Hands, Observation};
use crate::geometry::{Point, Vector};
use crate::skeleton::{JointId, Part, Sequence};

/// A hand that comes no farther than this before contact does not reach `[m]`.
const SHORTEST_REACH: f64 = 0.1;

/// Within this long of the true contact the hands may meet `[s]`.
const CONTACT_WINDOW: f64 = 0.25;

/// An interaction as it was seen, not smoothed, and where the robot's hand belongs in it.
///
/// Holds nothing that the human in the robot's role did but the moment of contact, so it may be one
/// that no human ever took part in.
#[derive(Debug, Clone)]
pub struct Scene {
    observation: Observation,
    contact: usize,
    robot_hand: JointId,
    partner_hand: JointId,
    mean_gap: Vector,
}

impl Scene {
    /// The scene of a recording.
    ///
    /// - `hands`: which hands are active, decided without the robot role's truth.
    /// - `mean_gap`: ḡ `[m]`, robot's hand minus partner's in the partner's heading frame.
    ///
    /// `None` if a skeleton lacks an active hand.
    pub fn new(truth: &Demonstration, hands: Hands, mean_gap: Vector) -> Option<Self> {
        Some(Self {
            observation: truth.observation(),
            contact: truth.contact_of(hands)?.frame,
            robot_hand: truth.robot().skeleton().part(Part::Hand(hands.robot))?,
            partner_hand: truth.partner().skeleton().part(Part::Hand(hands.partner))?,
            mean_gap,
        })
    }

    /// The same moment and hands where the observation is changed.
    pub(super) fn changed(self, change: impl FnOnce(Observation) -> Observation) -> Self {
        Self { observation: change(self.observation), ..self }
    }

    /// What was seen, not smoothed.
    pub fn observation(&self) -> &Observation {
        &self.observation
    }

    /// The frame at which the true hands were closest, counted from 0.
    pub fn contact(&self) -> usize {
        self.contact
    }

    /// Where the robot's active hand belongs at contact `[m]`: at the partner's, plus the mean gap.
    pub fn goal(&self) -> Point {
        self.observation.partner.position(self.contact, self.partner_hand)
            + self.observation.gap_in_world(self.contact, self.mean_gap)
    }

    /// Whether the robot's bones, stretched out, would bring its hand from its base to
    /// [`Self::goal`]: a bound that no method passes with its bones whole.
    pub fn within_reach(&self) -> bool {
        let distance = (self.goal() - self.observation.base[self.contact]).norm();
        distance <= self.observation.reach(self.robot_hand)
    }

    /// The figures of a prediction (`[m]`, `frames × joints`) that need no truth but the moment:
    /// gap, gap at contact, timing, bone and jerk; the others are undefined.
    ///
    /// # Panics
    /// If the prediction has not one position per frame and joint.
    pub fn figures(&self, predicted: &[Point]) -> Figures {
        let Observation { partner, robot_skeleton, bone_lengths, .. } = &self.observation;
        let joints = robot_skeleton.len();
        let frames = partner.len();
        assert_eq!(predicted.len(), frames * joints, "one position per frame and joint");
        let at = |frame: usize, joint: JointId| predicted[frame * joints + joint.index()];
        let hand = self.robot_hand;
        let gap = |frame: usize| {
            let gap = at(frame, hand) - partner.position(frame, self.partner_hand);
            (self.observation.gap_in_heading(frame, gap) - self.mean_gap).norm()
        };
        let moment = partner.frames()[self.contact].stamp;
        let since = |frame: usize| partner.frames()[frame].stamp - moment;
        let best = (0..frames)
            .filter(|k| since(*k).seconds().abs() <= CONTACT_WINDOW)
            .min_by(|a, b| gap(*a).total_cmp(&gap(*b)));
        let bones = robot_skeleton.bones().zip(bone_lengths);
        let bone = bones
            .flat_map(|(bone, length)| {
                let lengths =
                    (0..frames).map(move |k| (at(k, bone.child) - at(k, bone.parent)).norm());
                lengths.map(move |found| (found - length).abs())
            })
            .fold(0.0, f64::max);
        let duration = (partner.frames()[frames - 1].stamp - partner.frames()[0].stamp).seconds();
        let step = duration / (frames.max(2) - 1) as f64;
        let jerk = (3..frames).map(|k| {
            let third = (at(k, hand) - at(k - 3, hand)) - 3.0 * (at(k - 1, hand) - at(k - 2, hand));
            third.norm() / step.powi(3)
        });
        Figures::default()
            .with(Figure::Gap, best.map(|k| centimetres(gap(k))))
            .with(Figure::GapAtContact, Some(centimetres(gap(self.contact))))
            .with(Figure::Timing, best.map(|k| since(k).milliseconds()))
            .with(Figure::Bone, Some(1000.0 * bone))
            .with(Figure::Jerk, mean(jerk.sum(), frames.saturating_sub(3)))
    }
}

/// A scene of which it is known what the human in the robot's role did.
#[derive(Debug, Clone)]
pub struct KnownScene<'a> {
    scene: Scene,
    robot: &'a Sequence,
    measured_joints: Vec<JointId>,
}

impl<'a> KnownScene<'a> {
    /// As [`Scene::new`], with the human's motion.
    ///
    /// - `ignored`: the robot's joints that no figure counts, beside its base.
    ///
    /// `None` if a skeleton lacks an active hand.
    pub fn new(
        truth: &'a Demonstration,
        hands: Hands,
        mean_gap: Vector,
        ignored: &[JointId],
    ) -> Option<Self> {
        let joints = truth.robot().skeleton().joints();
        let measured = joints.filter(|j| *j != truth.robot_base() && !ignored.contains(j));
        Some(Self {
            scene: Scene::new(truth, hands, mean_gap)?,
            robot: truth.robot(),
            measured_joints: measured.collect(),
        })
    }

    /// The scene without the human.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// All figures of a prediction: `[m]`, `frames × joints`.
    ///
    /// # Panics
    /// If the prediction has not one position per frame and joint.
    pub fn figures(&self, predicted: &[Point]) -> Figures {
        let figures = self.scene.figures(predicted);
        let (joints, frames) = (self.robot.skeleton().len(), self.robot.len());
        let miss = |frame: usize, joint: JointId| {
            let predicted = predicted[frame * joints + joint.index()];
            (predicted - self.robot.position(frame, joint)).norm()
        };
        let hand = self.scene.robot_hand;
        let joint: f64 =
            (0..frames).flat_map(|k| self.measured_joints.iter().map(move |j| miss(k, *j))).sum();
        let whole: f64 = (0..frames).map(|k| miss(k, hand)).sum();
        figures
            .with(Figure::Joint, mean(joint, frames * self.measured_joints.len()).map(centimetres))
            .with(Figure::Hand, mean(whole, frames).map(centimetres))
            .with(Figure::Contact, Some(centimetres(miss(self.scene.contact, hand))))
            .with(Figure::Reach, self.late(|frame| predicted[frame * joints + hand.index()]))
    }

    /// How much later than the human a hand has done 90 % of its way to contact `[ms]`.
    fn late(&self, hand: impl Fn(usize) -> Point) -> Option<f64> {
        let contact = self.scene.contact;
        let own = arrival(contact, hand)?;
        let human = arrival(contact, |frame| self.robot.position(frame, self.scene.robot_hand))?;
        let stamp = |frame: usize| self.robot.frames()[frame].stamp;
        Some((stamp(own) - stamp(human)).milliseconds())
    }
}

/// The first frame, after the hand was farthest from where it is at `contact`, at which a tenth of
/// that way is left; `None` if it does not reach at all.
fn arrival(contact: usize, hand: impl Fn(usize) -> Point) -> Option<usize> {
    let left = |frame: usize| (hand(frame) - hand(contact)).norm();
    let start = (0..=contact).max_by(|a, b| left(*a).total_cmp(&left(*b)))?;
    let way = left(start);
    (way >= SHORTEST_REACH).then(|| (start..=contact).find(|k| left(*k) <= 0.1 * way))?
}

fn mean(sum: f64, count: usize) -> Option<f64> {
    (count > 0).then(|| sum / count as f64)
}

fn centimetres(metres: f64) -> f64 {
    100.0 * metres
}
