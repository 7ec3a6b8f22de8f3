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
        let bones = robot_skeleton.bones().take(robot_skeleton.own() - 1).zip(bone_lengths);
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
        let skeleton = truth.robot().skeleton();
        let joints = skeleton.joints().take(skeleton.own());
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

    /// How much later than the human a hand has come 90 % of the human's way to contact `[ms]`;
    /// `None` if it never does.
    ///
    /// Seen along the line from where the human's hand was farthest to where it was at contact: how
    /// far a hand is off to the side is for other figures to say.
    fn late(&self, hand: impl Fn(usize) -> Point) -> Option<f64> {
        let (contact, frames) = (self.scene.contact, self.robot.len());
        let human = |frame: usize| self.robot.position(frame, self.scene.robot_hand);
        let left = |frame: usize| (human(frame) - human(contact)).norm();
        let start = (0..=contact).max_by(|a, b| left(*a).total_cmp(&left(*b)))?;
        let way = human(contact) - human(start);
        if way.norm() < SHORTEST_REACH {
            return None;
        }
        let come = |place: Point| (place - human(start)).dot(&way) / way.norm_squared();
        let own = (start..frames).find(|frame| come(hand(*frame)) >= 0.9)?;
        let human = (start..frames).find(|frame| come(human(*frame)) >= 0.9)?;
        let stamp = |frame: usize| self.robot.frames()[frame].stamp;
        Some((stamp(own) - stamp(human)).milliseconds())
    }
}

fn mean(sum: f64, count: usize) -> Option<f64> {
    (count > 0).then(|| sum / count as f64)
}

fn centimetres(metres: f64) -> f64 {
    100.0 * metres
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::sync::Arc;

    use super::*;
    use crate::kinematics::minimum_jerk;
    use crate::skeleton::{Frame, Person, Recording, Side, Skeleton};
    use crate::time::Stamp;

    const FRAMES: usize = 60;
    const PERIOD: i64 = 33_333_333;

    /// Two who stand still but for their right hands, which meet in the middle at 1.5 s.
    fn handover() -> Demonstration {
        let skeleton = Skeleton::nite();
        let person = |name: &str, place: f64, towards: f64| {
            let frames = (0..FRAMES).map(|frame| {
                let joint = |at: usize| {
                    let height = 1.7 - 0.1 * at as f64;
                    Point::new(place, 0.1 * towards * (at % 3) as f64, height)
                };
                let mut positions: Vec<Point> = (0..15).map(joint).collect();
                let out = minimum_jerk((frame as f64 - 15.0) / 30.0);
                positions[8] += Vector::x() * (0.45 * towards * out);
                Frame { stamp: Stamp(frame as i64 * PERIOD), positions: positions.into() }
            });
            let motion = Sequence::new(skeleton.clone(), frames.collect()).unwrap();
            Person { name: name.to_owned(), motion }
        };
        let people = [person("giver", -0.5, 1.0), person("receiver", 0.5, -1.0)];
        let recording = Recording::new("clip".to_owned(), people, None, BTreeMap::new()).unwrap();
        Demonstration::new(Arc::new(recording), "giver", "torso").unwrap()
    }

    #[test]
    fn a_hand_is_as_late_as_it_is_behind_and_one_that_stays_never_comes() {
        let truth = handover();
        let hands = Hands { robot: Side::Right, partner: Side::Right };
        let scene = KnownScene::new(&truth, hands, Vector::zeros(), &[]).unwrap();
        let reach = |source: &dyn Fn(usize) -> usize| {
            let frames = truth.robot().frames();
            let predicted = (0..FRAMES).flat_map(|frame| frames[source(frame)].positions.iter());
            scene.figures(&predicted.copied().collect::<Vec<_>>()).get(Figure::Reach)
        };
        let ms = |frames: i64| Some((frames * PERIOD) as f64 / 1e6);
        assert_eq!(reach(&|frame| frame), ms(0));
        assert_eq!(reach(&|frame| frame.saturating_sub(9)), ms(9));
        assert_eq!(reach(&|frame| (frame + 4).min(FRAMES - 1)), ms(-4));
        // After contact, too, it may come; half-way it has not.
        assert_eq!(reach(&|frame| frame.saturating_sub(17)), ms(17));
        assert_eq!(reach(&|_| 0), None);
        assert_eq!(reach(&|frame| frame.min(30)), None);
    }
}
