//! Our own: the reference's interaction mesh, retargeted to the partner and the base as they are.

use std::sync::Arc;

use super::aligned::Alignment;
use super::{KnownJoints, PredictError, PredictSettings};
use crate::demonstration::{Hands, Observation};
use crate::geometry::Point;
use crate::mesh::{Edge, EdgeWeights, InitialEdges, InteractionMesh, Pair, Topology};
use crate::retarget::{Constraint, Retargeter, project_bones};
use crate::skeleton::{Part, Role};

/// - `hands`: the interperson edges, between hands.
pub(super) fn predict(
    observation: &Observation,
    alignment: &Alignment,
    hands: &[Hands],
    settings: &PredictSettings,
) -> Result<Vec<Point>, PredictError> {
    let robot_role = observation.robot_role;
    let partner_role = robot_role.partner();
    let (robot_skeleton, partner_skeleton) =
        (&observation.robot_skeleton, observation.partner.skeleton());
    let pair =
        Arc::new(Pair::new(in_order(robot_role, robot_skeleton.clone(), partner_skeleton.clone())));
    let frames = observation.len();
    // Both people frame by frame, in the pair's order.
    let interleave = |robot: &[Point], partner: &[Point]| {
        let robot = robot.chunks_exact(robot_skeleton.len());
        let partner = partner.chunks_exact(partner_skeleton.len());
        let both = robot.zip(partner).map(|(robot, partner)| in_order(robot_role, robot, partner));
        both.flat_map(|[first, second]| first.iter().chain(second).copied()).collect::<Vec<_>>()
    };
    let (robot, partner) = (alignment.mean_robot(), alignment.mean_partner());
    let reference = interleave(&robot, &partner);
    let topology =
        Topology::initial(pair.clone(), &reference[..pair.len()], InitialEdges::EachPerson)?;
    let edges = hands.iter().filter_map(|hands| {
        let robot = pair.vertex(robot_role, robot_skeleton.part(Part::Hand(hands.robot))?);
        let partner = pair.vertex(partner_role, partner_skeleton.part(Part::Hand(hands.partner))?);
        Some(Edge::new(robot, partner))
    });
    let topology = Arc::new(topology.with(edges)?);
    let weights =
        EdgeWeights::by_kernel(&topology, &reference, settings.kernel, settings.time_weight);
    let mesh = InteractionMesh::new(topology.clone(), reference, weights)?;

    let base = pair.vertex(robot_role, observation.robot_base);
    let known = |vertex| pair.role(vertex) == partner_role || vertex == base;
    let frame: Vec<Constraint> = pair
        .vertices(Role::First)
        .chain(pair.vertices(Role::Second))
        .map(|vertex| match settings.known {
            _ if !known(vertex) => Constraint::Free,
            KnownJoints::Eliminated => Constraint::Fixed,
            KnownJoints::Soft => Constraint::Soft(1.0),
        })
        .collect();
    let constraints = frame.repeat(frames);
    let observed: Vec<Point> =
        observation.partner.frames().iter().flat_map(|f| f.positions.iter().copied()).collect();
    // The robot's targets count at its base only, where the reference already stands.
    let targets = interleave(&robot, &observed);
    let partner_lengths = observation.partner.bone_lengths();
    let lengths = in_order(robot_role, &observation.bone_lengths, &partner_lengths);
    let lengths = lengths.map(|lengths| lengths.as_slice()).concat();
    // A bone that has no length in the data still has two ends.
    let lengths: Vec<f64> = lengths.into_iter().map(|length| length.max(1e-6)).collect();

    let retargeter = Retargeter::new(topology, &constraints, settings.retarget)?;
    let mut workspace = retargeter.workspace();
    retargeter.assemble(&mesh, &mut workspace)?;
    retargeter.factor(&mut workspace)?;
    let mut solved = targets.clone();
    retargeter.solve(&mesh, &targets, &lengths, &mut workspace, &mut solved)?;

    let mut predicted = Vec::with_capacity(frames * robot_skeleton.len());
    for frame in solved.chunks_exact(pair.len()) {
        let first = predicted.len();
        predicted.extend(pair.vertices(robot_role).map(|vertex| frame[vertex.index()]));
        project_bones(robot_skeleton, &observation.bone_lengths, &mut predicted[first..]);
    }
    Ok(predicted)
}

/// The robot's and the partner's share in the order of the recording's people.
fn in_order<T>(robot_role: Role, robot: T, partner: T) -> [T; 2] {
    match robot_role {
        Role::First => [robot, partner],
        Role::Second => [partner, robot],
    }
}
