//! Our own: the reference's interaction mesh, retargeted to the partner and the base as they are.
//!
//! Reference (mean of the nearest demonstrations) → mesh (each person's Delaunay edges of the
//! first frame, the bones, and one distance-weighted edge between the hands that meet) → solve
//! with the partner's joints and the robot's base known → exact bones.

use std::sync::Arc;

use super::aligned::Alignment;
use super::{KnownJoints, PredictError, PredictSettings};
use crate::demonstration::{Hands, Observation};
use crate::geometry::Point;
use crate::mesh::{Edge, EdgeWeights, InitialEdges, InteractionMesh, Pair, Topology};
use crate::retarget::{Constraint, Retargeter, project_bones};
use crate::skeleton::{Part, Role};

/// - `hands`: the hands that an edge between the people joins, if any does.
pub(super) fn predict(
    observation: &Observation,
    alignment: &Alignment,
    hands: Option<Hands>,
    settings: &PredictSettings,
) -> Result<Vec<Point>, PredictError> {
    let people = People::of(observation);
    let pair = &people.pair;
    let (mut robot, partner) = (alignment.mean_robot(), alignment.mean_partner());
    if let Some(hands) = hands {
        hold_contact_gap(
            observation,
            alignment,
            hands,
            settings.contact_fade,
            &mut robot,
            &partner,
        );
    }
    let reference = people.interleave(&robot, &partner);
    let first_frame = &reference[..pair.len()];
    let topology = Topology::initial(pair.clone(), first_frame, InitialEdges::EachPerson)?;
    let topology = Arc::new(topology.with(hands.and_then(|hands| people.edge(hands)))?);
    let weights =
        EdgeWeights::by_kernel(&topology, &reference, settings.kernel, settings.time_weight);
    let mesh = InteractionMesh::new(topology.clone(), reference, weights)?;

    let constraints = people.constraints(observation, settings.known).repeat(observation.len());
    let observed = observation.partner.frames().iter().flat_map(|f| f.positions.iter().copied());
    // The robot's targets count at its base only, where the reference already stands.
    let targets = people.interleave(&robot, &observed.collect::<Vec<_>>());
    let lengths = people.bone_lengths(observation);

    let retargeter = Retargeter::new(topology, &constraints, settings.retarget)?;
    let mut workspace = retargeter.workspace();
    retargeter.assemble(&mesh, &mut workspace)?;
    retargeter.factor(&mut workspace)?;
    let mut solved = targets.clone();
    retargeter.solve(&mesh, &targets, &lengths, &mut workspace, &mut solved)?;

    let mut predicted = Vec::with_capacity(robot.len());
    for frame in solved.chunks_exact(pair.len()) {
        let first = predicted.len();
        predicted.extend(pair.vertices(people.robot).map(|vertex| frame[vertex.index()]));
        let (skeleton, lengths) = (&observation.robot_skeleton, &observation.bone_lengths);
        project_bones(skeleton, lengths, &mut predicted[first..]);
    }
    Ok(predicted)
}

/// Near the reference's contact, brings its hands to the gap that the demonstrations had at theirs.
///
/// Time alignment misses the moment by a tenth of a second or two, and the mean of hands that meet
/// a little earlier and a little later is hands that do not meet.
fn hold_contact_gap(
    observation: &Observation,
    alignment: &Alignment,
    hands: Hands,
    fade: f64,
    robot: &mut [Point],
    partner: &[Point],
) {
    let (robot_skeleton, partner_skeleton) =
        (&observation.robot_skeleton, observation.partner.skeleton());
    let (Some(robot_hand), Some(partner_hand)) = (
        robot_skeleton.part(Part::Hand(hands.robot)),
        partner_skeleton.part(Part::Hand(hands.partner)),
    ) else {
        return;
    };
    let (gap, contact) = (alignment.contact_gap(), alignment.contact());
    let robot = robot.chunks_exact_mut(robot_skeleton.len());
    let partner = partner.chunks_exact(partner_skeleton.len());
    for (frame, (robot, partner)) in robot.zip(partner).enumerate() {
        let share = observation.nearness(frame, contact, fade);
        let goal = partner[partner_hand.index()] + observation.gap_in_world(frame, gap);
        let hand = &mut robot[robot_hand.index()];
        *hand += (goal - *hand) * share;
    }
}

/// The robot and its partner in the order of the recording's people.
struct People {
    pair: Arc<Pair>,
    robot: Role,
}

impl People {
    fn of(observation: &Observation) -> Self {
        let robot = observation.robot_role;
        let skeletons =
            [observation.robot_skeleton.clone(), observation.partner.skeleton().clone()];
        Self { pair: Arc::new(Pair::new(in_order(robot, skeletons))), robot }
    }

    /// Both people's joints frame by frame, of `frames × joints` each.
    fn interleave(&self, robot: &[Point], partner: &[Point]) -> Vec<Point> {
        let frames = |role: Role| self.pair.skeleton(role).len();
        let robot = robot.chunks_exact(frames(self.robot));
        let partner = partner.chunks_exact(frames(self.robot.partner()));
        let both = robot.zip(partner).map(|(r, p)| in_order(self.robot, [r, p]));
        both.flat_map(|[first, second]| first.iter().chain(second).copied()).collect()
    }

    fn edge(&self, hands: Hands) -> Option<Edge> {
        let hand = |role: Role, side| {
            let joint = self.pair.skeleton(role).part(Part::Hand(side))?;
            Some(self.pair.vertex(role, joint))
        };
        Some(Edge::new(hand(self.robot, hands.robot)?, hand(self.robot.partner(), hands.partner)?))
    }

    /// One frame's constraints: the partner and the robot's base are known.
    fn constraints(&self, observation: &Observation, known: KnownJoints) -> Vec<Constraint> {
        let known = match known {
            KnownJoints::Eliminated => Constraint::Fixed,
            KnownJoints::Soft => Constraint::Soft(1.0),
        };
        let base = self.pair.vertex(self.robot, observation.robot_base);
        let vertices =
            [Role::First, Role::Second].into_iter().flat_map(|role| self.pair.vertices(role));
        let is_known = |vertex| self.pair.role(vertex) != self.robot || vertex == base;
        vertices.map(|v| if is_known(v) { known } else { Constraint::Free }).collect()
    }

    /// Both people's bone lengths `[m]`, in the pair's order.
    fn bone_lengths(&self, observation: &Observation) -> Vec<f64> {
        let lengths = [observation.bone_lengths.clone(), observation.partner.bone_lengths()];
        // A bone that has no length in the data still has two ends.
        in_order(self.robot, lengths).concat().into_iter().map(|l| l.max(1e-6)).collect()
    }
}

/// `[robot's, partner's]` → `[first person's, second person's]`.
fn in_order<T>(robot: Role, [of_robot, of_partner]: [T; 2]) -> [T; 2] {
    match robot {
        Role::First => [of_robot, of_partner],
        Role::Second => [of_partner, of_robot],
    }
}
