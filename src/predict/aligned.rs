//! Demonstrations on an observation's time and place, and the mean of the nearest.
//!
//! Time: dynamic time warping on the observed partner alone. Place: one turn about the vertical
//! that lays both people's bases on theirs, then each person shifted frame by frame so that the
//! bases coincide. The robot role's truth is never looked at.

use nalgebra::{Complex, UnitComplex};

use crate::align::{WarpSettings, warp};
use crate::demonstration::{Demonstration, Hands, Observation};
use crate::geometry::{Isometry, Point, Vector, yaw_alignment, yaw_isometry};
use crate::skeleton::{JointId, Sequence};

use super::{PredictSettings, Shapes, mean_turn};
use crate::blend::Apart;

/// One demonstration on an observation's time and place.
#[derive(Debug, Clone)]
pub struct Aligned {
    /// Which demonstration, in the predictor's order.
    pub demonstration: usize,
    /// How far the partners' motions differ: mean distance of a joint `[m]`.
    pub cost: f64,
    /// Which hands met in it.
    pub hands: Hands,
    /// The observation's frame (fractional) at which they did.
    pub contact: f64,
    /// The partner's joints `[m]`, `frames × joints`, the base where the observed one is.
    pub partner: Vec<Point>,
    /// The robot role's joints `[m]`, `frames × joints`, the base where the robot's is.
    pub robot: Vec<Point>,
    /// How the demonstration was turned about the vertical.
    pub turn: UnitComplex<f64>,
    /// From the partner's base to the robot's `[m]` at each frame, as demonstrated, turned.
    pub between: Vec<Vector>,
}

/// An observation with all demonstrations on it, nearest first.
#[derive(Debug, Clone)]
pub struct Alignment {
    /// All demonstrations.
    pub all: Vec<Aligned>,
    /// The hands that will meet: what the nearest demonstrations agree on.
    pub hands: Hands,
    /// `(index into all, weight)` of the demonstrations that make the reference; weights sum to 1.
    pub nearest: Vec<(usize, f64)>,
}

impl Alignment {
    /// The weighted mean of `part` over the nearest demonstrations, in their order.
    fn mean<'a>(&'a self, part: impl Fn(&'a Aligned) -> &'a [Point]) -> Vec<Point> {
        let mut sum = vec![Point::origin(); part(&self.all[self.nearest[0].0]).len()];
        for (at, weight) in &self.nearest {
            let points = part(&self.all[*at]);
            sum.iter_mut().zip(points).for_each(|(sum, p)| *sum += *weight * p.coords);
        }
        sum
    }

    /// The reference's partner: `[m]`, `frames × joints`.
    pub fn mean_partner(&self) -> Vec<Point> {
        self.mean(|aligned| &aligned.partner)
    }

    /// The reference's robot: `[m]`, `frames × joints`; its bones shrink where people differ.
    pub fn mean_robot(&self) -> Vec<Point> {
        self.mean(|aligned| &aligned.robot)
    }

    /// The blend of the nearest demonstrations: the robot and its partner, `[m]`, `frames × joints`.
    pub(super) fn blend(&self, shapes: &Shapes) -> [Vec<Point>; 2] {
        let (mut robot, mut partner) = (self.mean_robot(), self.mean_partner());
        let nearest = || self.nearest.iter().map(|(at, weight)| (&self.all[*at], *weight));
        let here_from_shape =
            |aligned: &Aligned| aligned.turn * shapes.turn(aligned.demonstration).inverse();
        let mean_turn = mean_turn(nearest().map(|(aligned, w)| (here_from_shape(aligned), w)));
        let frames = self.all[self.nearest[0].0].between.len();
        let [robot_joints, partner_joints] = [robot.len() / frames, partner.len() / frames];
        let mut workspace = shapes.workspace();
        let rows = robot.chunks_exact_mut(robot_joints);
        let rows = rows.zip(partner.chunks_exact_mut(partner_joints)).enumerate();
        for (frame, (robot, partner)) in rows {
            let poses: Vec<(f64, Apart)> = nearest()
                .map(|(aligned, weight)| {
                    let robot = &aligned.robot[frame * robot_joints..][..robot_joints];
                    let partner = &aligned.partner[frame * partner_joints..][..partner_joints];
                    let turn = here_from_shape(aligned).inverse();
                    (weight, shapes.apart(turn, aligned.between[frame], robot, partner))
                })
                .collect();
            let between = nearest().map(|(aligned, weight)| weight * aligned.between[frame]).sum();
            let poses = poses.iter().map(|(weight, apart)| (*weight, apart));
            shapes.blend(poses, mean_turn, between, robot, partner, &mut workspace);
        }
        [robot, partner]
    }

    /// The observation's frame (fractional) at which the reference's hands meet.
    pub fn contact(&self) -> f64 {
        self.nearest.iter().map(|(at, weight)| weight * self.all[*at].contact).sum()
    }
}

/// What the time alignment compares: the partner's joints from its base, turned to its heading,
/// and how far the two bases are apart. `[m]`, scaled so that the Euclidean distance of two rows
/// is a mean distance of a joint.
pub(super) fn features(
    partner: &Sequence,
    partner_base: JointId,
    base: impl Fn(usize) -> Point,
    distance_weight: f64,
) -> Vec<Vec<f64>> {
    // What rides on a joint tells nothing that the joint does not.
    let joints = partner.skeleton().own();
    let scale = 1.0 / (joints as f64).sqrt();
    let rows = (0..partner.len()).map(|frame| {
        let place = partner.position(frame, partner_base);
        let heading_from_world = yaw_isometry(-partner.heading(frame), Vector::zeros());
        let positions = &partner.frames()[frame].positions[..joints];
        let pose = positions.iter().map(|p| heading_from_world * (p - place) * scale);
        let apart = (base(frame) - place).xy().norm() * distance_weight;
        pose.flat_map(|p| [p.x, p.y, p.z]).chain([apart]).collect()
    });
    rows.collect()
}

/// Positions of a sequence at a fractional frame.
fn at_fraction(sequence: &Sequence, frame: f64) -> impl Iterator<Item = Point> + '_ {
    let (low, high) = (frame.floor() as usize, frame.ceil() as usize);
    let (low, high) = (&sequence.frames()[low].positions, &sequence.frames()[high].positions);
    low.iter().zip(high).map(move |(a, b)| a + (b - a) * frame.fract())
}

/// Lays one demonstration on an observation.
pub(super) fn align(
    observation: &Observation,
    observed: &[Vec<f64>],
    index: usize,
    demonstration: &Demonstration,
    demonstrated: &[Vec<f64>],
    settings: WarpSettings,
) -> Option<Aligned> {
    let distance = |target: usize, source: usize| -> f64 {
        let pairs = observed[target].iter().zip(&demonstrated[source]);
        pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    };
    let warp = warp(observed.len(), demonstrated.len(), settings, distance)?;
    let (partner_base, robot_base) =
        (demonstration.partner_base().index(), demonstration.robot_base().index());
    let frames = warp.source.iter().map(|source| {
        let partner: Vec<Point> = at_fraction(demonstration.partner(), *source).collect();
        let robot: Vec<Point> = at_fraction(demonstration.robot(), *source).collect();
        (partner, robot)
    });
    let mut frames: Vec<(Vec<Point>, Vec<Point>)> = frames.collect();
    let places: Vec<[Point; 4]> = frames
        .iter()
        .enumerate()
        .map(|(k, (partner, robot))| {
            let demonstrated = [partner[partner_base], robot[robot_base]];
            [demonstrated[0], observation.partner_place(k), demonstrated[1], observation.base[k]]
        })
        .collect();
    let here_from_demonstration =
        yaw_alignment(places.iter().flat_map(|[a, b, c, d]| [(a, b), (c, d)]));
    for (k, (partner, robot)) in frames.iter_mut().enumerate() {
        place(partner, partner_base, &here_from_demonstration, observation.partner_place(k));
        place(robot, robot_base, &here_from_demonstration, observation.base[k]);
    }
    let between = places
        .iter()
        .map(|[partner, _, robot, _]| here_from_demonstration.rotation * (robot - partner));
    let between = between.collect();
    let turned = here_from_demonstration.rotation * Vector::x();
    let turn = Complex::new(turned.x, turned.y);
    let contact = demonstration.contact();
    let moment = contact.frame as f64;
    let met = warp.source.iter().map(|source| (source - moment).abs());
    // Where the warp rests on the moment, its middle.
    let nearest = met.clone().fold(f64::INFINITY, f64::min);
    let (sum, count) = met
        .enumerate()
        .filter(|(_, off)| *off <= nearest + 1e-9)
        .fold((0.0, 0.0), |(sum, count), (frame, _)| (sum + frame as f64, count + 1.0));
    let (partner, robot): (Vec<_>, Vec<_>) = frames.into_iter().unzip();
    Some(Aligned {
        demonstration: index,
        cost: warp.cost,
        hands: contact.hands,
        contact: sum / count,
        partner: partner.concat(),
        robot: robot.concat(),
        turn: UnitComplex::new_normalize(turn),
        between,
    })
}

/// Turns a pose and shifts it so that its base is at `base_place`.
fn place(pose: &mut [Point], base: usize, here_from_there: &Isometry, base_place: Point) {
    pose.iter_mut().for_each(|p| *p = here_from_there * *p);
    let shift = base_place - pose[base];
    pose.iter_mut().for_each(|p| *p += shift);
}

/// Sorts by cost, lets the nearest vote on the hands unless they are known, and weighs those that
/// agree; if none has those hands, all of them.
pub(super) fn choose(
    mut all: Vec<Aligned>,
    hands: Option<Hands>,
    settings: &PredictSettings,
) -> Option<Alignment> {
    all.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.demonstration.cmp(&b.demonstration)));
    let voters = &all[..all.len().min(settings.demonstrations)];
    let votes = |hands: Hands| -> f64 {
        voters.iter().filter(|a| a.hands == hands).map(|a| 1.0 / a.cost.max(1e-6)).sum()
    };
    // Of equal votes the nearest demonstration's wins.
    let voted = voters
        .iter()
        .map(|a| a.hands)
        .reduce(|best, next| if votes(next) > votes(best) { next } else { best })?;
    let hands = hands.unwrap_or(voted);
    let known = all.iter().any(|a| a.hands == hands);
    let agreeing = all.iter().enumerate().filter(|(_, a)| a.hands == hands || !known);
    let nearest: Vec<(usize, f64)> = agreeing
        .take(settings.demonstrations)
        .map(|(at, aligned)| (at, aligned.cost.max(1e-6).powi(-2)))
        .collect();
    let total: f64 = nearest.iter().map(|(_, weight)| weight).sum();
    let nearest = nearest.into_iter().map(|(at, weight)| (at, weight / total)).collect();
    Some(Alignment { all, hands, nearest })
}
