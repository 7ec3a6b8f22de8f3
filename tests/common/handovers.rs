//! Made-up handovers of two people, each a little different, and what is learned from them; what
//! tests and benches of the online tick share; included by path.
//!
//! The giver stands at negative x and looks along x, the receiver opposite. Both reach for one
//! point, meet there, and go back. Everything that differs follows from a seed.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use handover_mesh::demonstration::{Demonstration, Hands};
use handover_mesh::geometry::yaw_isometry;
use handover_mesh::kinematics::{minimum_jerk, two_bone};
use handover_mesh::mesh::{Edge, Pair};
use handover_mesh::online::{OnlineModel, OnlineSettings, Pipeline};
use handover_mesh::predict::{LearnedEdge, LearnedEdges, PredictSettings, Predictor};
use handover_mesh::retarget::{RetargetSettings, Transform};
use handover_mesh::{
    Frame, Part, Person, Point, Recording, Role, Sequence, Side, Skeleton, Stamp, Vector,
};
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

#[path = "standing.rs"]
mod standing;

/// How long a handover lasts `[s]`.
pub(crate) const DURATION: f64 = 4.0;

/// From frame to frame of recordings `[ns]`.
pub(crate) const FRAME: i64 = 33_333_333;

/// The role that the robot takes; its partner is the receiver.
pub(crate) const ROBOT: &str = "giver";

/// One handover: all that tells it from another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Handover {
    /// The hands that meet.
    pub(crate) hands: Hands,
    /// When they meet `[s]`.
    pub(crate) contact: f64,
    /// How long a reach takes `[s]`.
    reach: f64,
    /// How long the hands stay together `[s]`.
    stay: f64,
    /// How much later the giver starts than the receiver `[s]`.
    later: f64,
    /// Half the way between the two `[m]`.
    half: f64,
    /// Where they meet `[m]`.
    meeting: Point,
    /// How far the chests lean forward `[m]`.
    lean: f64,
    /// Phases of the people's swaying.
    sway: [f64; 2],
    /// How much taller the people are than usual `[-]`.
    size: [f64; 2],
}

impl Handover {
    /// The handover of a seed: right hands.
    pub(crate) fn new(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut number = |low: f64, high: f64| random.random_range(low..high);
        Self {
            hands: Hands { robot: Side::Right, partner: Side::Right },
            contact: number(1.6, 2.0),
            reach: number(0.8, 1.1),
            stay: number(0.2, 0.4),
            later: number(0.05, 0.15),
            half: number(0.52, 0.6),
            meeting: Point::new(number(-0.04, 0.04), number(-0.05, 0.05), number(1.05, 1.2)),
            lean: number(0.03, 0.08),
            sway: [number(0.0, TAU), number(0.0, TAU)],
            size: [number(0.97, 1.03), number(0.97, 1.03)],
        }
    }

    /// The same with other hands.
    pub(crate) fn with_hands(self, robot: Side, partner: Side) -> Self {
        Self { hands: Hands { robot, partner }, ..self }
    }

    /// How far out the hands are, 0 to 1, at a time `[s]`.
    pub(crate) fn part(&self, time: f64) -> f64 {
        let out = minimum_jerk((time - self.contact + self.reach) / self.reach);
        out - minimum_jerk((time - self.contact - self.stay) / self.reach)
    }

    /// The giver's joints at a time `[s]`: `[m]`.
    pub(crate) fn giver(&self, time: f64) -> Vec<Point> {
        let place = yaw_isometry(0.0, Vector::x() * -self.half);
        let sway = self.sway[0] + 0.3 * TAU * time;
        // Both arrive at once.
        let part = self.part(time - self.later * (1.0 - self.part(time)));
        let pose = self.pose(self.hands.robot, place.inverse() * self.meeting, part, sway, 0);
        pose.map(|joint| place * joint).to_vec()
    }

    /// The receiver's joints at a time `[s]`: `[m]`.
    pub(crate) fn receiver(&self, time: f64) -> Vec<Point> {
        let place = yaw_isometry(PI, Vector::x() * self.half);
        let sway = self.sway[1] + 0.3 * TAU * time;
        let meeting = place.inverse() * self.meeting;
        let pose = self.pose(self.hands.partner, meeting, self.part(time), sway, 1);
        pose.map(|joint| place * joint).to_vec()
    }

    /// Joints of somebody at the origin who looks along x.
    fn pose(&self, side: Side, goal: Point, part: f64, sway: f64, who: usize) -> [Point; 15] {
        let standing = standing::STANDING.map(|joint| Point::from(joint) * self.size[who]);
        let mut pose = standing;
        for joint in &mut pose {
            // The higher, the farther.
            let height = ((joint.z - 0.9) / 0.7).max(0.0);
            joint.x += height * (self.lean * part + 0.008 * sway.sin());
            joint.y += height * 0.008 * (1.3 * sway).cos();
        }
        let [shoulder, elbow, hand] = match side {
            Side::Left => [3, 4, 5],
            Side::Right => [6, 7, 8],
        };
        let length = |a: usize, b: usize| (standing[a] - standing[b]).norm();
        let target = pose[hand] + (goal - pose[hand]) * part;
        let outwards = if side == Side::Left { 1.0 } else { -1.0 };
        let pole = Vector::new(-0.3, 0.5 * outwards, -1.0);
        let (upper, lower) = (length(shoulder, elbow), length(elbow, hand));
        let arm = two_bone(pose[shoulder], target, upper, lower, pole);
        [pose[elbow], pose[hand]] = [arm.middle, arm.end];
        pose
    }

    /// It as recorded at 30 Hz.
    pub(crate) fn recording(&self, name: &str) -> Recording {
        let person = |name: &str, pose: &dyn Fn(f64) -> Vec<Point>| {
            let frame = |k: i64| {
                let positions = pose((k * FRAME) as f64 / 1e9).into();
                Frame { stamp: Stamp(k * FRAME), positions }
            };
            let frames = (0..=(DURATION * 1e9) as i64 / FRAME).map(frame).collect();
            let motion = Sequence::new(Skeleton::nite(), frames).unwrap();
            Person { name: name.to_owned(), motion }
        };
        let giver = person("giver", &|time| self.giver(time));
        let receiver = person("receiver", &|time| self.receiver(time));
        Recording::new(name, [giver, receiver], None, Default::default()).unwrap()
    }
}

/// So many handovers to learn from: every third is between left hands.
pub(crate) fn demonstrations(count: u64) -> Vec<Arc<Demonstration>> {
    let one = |seed: u64| {
        let handover = Handover::new(seed);
        let handover =
            if seed % 3 == 2 { handover.with_hands(Side::Left, Side::Left) } else { handover };
        let recording = handover.recording(&format!("handover_{seed}"));
        Arc::new(Demonstration::new(Arc::new(recording), ROBOT, "torso").unwrap())
    };
    (0..count).map(one).collect()
}

/// What is learned of demonstrations, with one edge, between the hands that meet.
pub(crate) fn model(
    demonstrations: Vec<Arc<Demonstration>>,
    transform: Transform,
    settings: OnlineSettings,
) -> Arc<OnlineModel> {
    let retarget = RetargetSettings { transform, ..RetargetSettings::default() };
    model_of(demonstrations, PredictSettings { retarget, ..PredictSettings::default() }, settings)
}

/// The same with other settings.
pub(crate) fn model_of(
    demonstrations: Vec<Arc<Demonstration>>,
    predict: PredictSettings,
    settings: OnlineSettings,
) -> Arc<OnlineModel> {
    let pair = Pair::of(demonstrations[0].recording());
    let hands = Hands { robot: Side::Right, partner: Side::Right };
    let hand = |role: Role| {
        let skeleton = pair.skeleton(role).clone();
        pair.vertex(role, skeleton.part(Part::Hand(Side::Right)).unwrap())
    };
    let edge = Edge::new(hand(Role::First), hand(Role::Second));
    let edge = LearnedEdge { edge, factors: vec![0.2, 1.0, 1.0, 0.5] };
    let edges = LearnedEdges::new(&pair, hands, 4, vec![edge]).unwrap();
    let predictor = Predictor::fit(demonstrations, predict).unwrap().with_edges(edges);
    Arc::new(OnlineModel::new(&predictor, settings).unwrap())
}

/// The bones of a pose `[m]`, in order.
pub(crate) fn lengths(pose: &[Point]) -> Vec<f64> {
    let length =
        |bone: handover_mesh::Bone| (pose[bone.child.index()] - pose[bone.parent.index()]).norm();
    Skeleton::nite().bones().map(length).collect()
}

/// A tick's room for a robot with this giver's bones.
pub(crate) fn pipeline(model: &Arc<OnlineModel>, robot: &[Point]) -> Pipeline {
    Pipeline::new(model.clone(), &lengths(robot), true).unwrap()
}
