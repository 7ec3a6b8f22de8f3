//! Our own: the reference's interaction mesh, retargeted to the partner and the base as they are.
//!
//! Reference (mean of the nearest demonstrations, the gap at contact held) → mesh (each person's
//! Delaunay edges of the first frame, the bones, and the learned edges between the people) → solve
//! with the partner's joints and the robot's base known → exact bones.

use std::sync::Arc;

use super::aligned::Alignment;
use super::{KnownJoints, LearnedEdges, PredictError, PredictSettings, Shapes, phase};
use crate::demonstration::{Hands, Observation};
use crate::geometry::{Point, Vector};
use crate::mesh::{EdgeWeights, InitialEdges, InteractionMesh, Kernel, MeshError, Pair, Topology};
use crate::retarget::{Constraint, Retargeter, project_bones};
use crate::skeleton::{Part, Role};

/// A retargeting to be done: the reference on an observation's time and place, what is known of
/// the people, and the robot's bones. Everything but the edges between the people.
#[derive(Debug, Clone)]
pub struct Problem {
    people: People,
    hands: Hands,
    /// The reference's contact, in frames.
    contact: f64,
    reference: Vec<Point>,
    targets: Vec<Point>,
    constraints: Vec<Constraint>,
    lengths: Vec<f64>,
    kernel: Kernel,
    time_weight: f64,
}

impl Problem {
    /// - `shapes`: what the demonstrations are shapes of, if the reference is their blend; else it is
    ///   their mean.
    /// - `contact_gap`: the gap `[m]` that the reference holds at its contact, in the partner's
    ///   heading frame; without one the reference stays as it is.
    pub fn new(
        observation: &Observation,
        alignment: &Alignment,
        shapes: Option<&Shapes>,
        contact_gap: Option<Vector>,
        settings: &PredictSettings,
    ) -> Self {
        let people = People::of(observation);
        let [mut robot, partner] = match shapes {
            Some(shapes) => alignment.blend(shapes),
            None => [alignment.mean_robot(), alignment.mean_partner()],
        };
        if let Some(gap) = contact_gap {
            let fade = settings.contact_fade;
            hold_contact_gap(observation, alignment, gap, fade, &mut robot, &partner);
        }
        let observed =
            observation.partner.frames().iter().flat_map(|f| f.positions.iter().copied());
        // The robot's targets count at its base only, where the reference already stands.
        let targets = people.interleave(&robot, &observed.collect::<Vec<_>>());
        Self {
            hands: alignment.hands,
            contact: alignment.contact(),
            reference: people.interleave(&robot, &partner),
            targets,
            constraints: people.constraints(observation, settings.known).repeat(observation.len()),
            lengths: people.bone_lengths(observation),
            kernel: settings.kernel,
            time_weight: settings.time_weight,
            people,
        }
    }

    /// Both people's skeletons.
    pub fn pair(&self) -> &Arc<Pair> {
        &self.people.pair
    }

    /// The role the robot takes.
    pub fn robot_role(&self) -> Role {
        self.people.robot
    }

    /// The hands that will meet.
    pub fn hands(&self) -> Hands {
        self.hands
    }

    /// The reference: `[m]`, `frames × vertices` of both people.
    pub fn reference(&self) -> &[Point] {
        &self.reference
    }

    /// Where the known joints are: `[m]`, `frames × vertices`.
    pub fn targets(&self) -> &[Point] {
        &self.targets
    }

    /// Who is known, `frames × vertices`.
    pub fn constraints(&self) -> &[Constraint] {
        &self.constraints
    }

    /// Both people's bone lengths `[m]`, in the pair's order.
    pub fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// The number of frames.
    pub fn frames(&self) -> usize {
        self.reference.len() / self.pair().len()
    }

    /// Which of `phases` parts of the interaction a frame belongs to.
    pub fn phase(&self, phases: usize, frame: usize) -> usize {
        phase(phases, frame as f64, self.contact, self.frames())
    }

    /// The edges of the first frame's Delaunay tetrahedra.
    ///
    /// # Errors
    /// [`MeshError::Delaunay`].
    pub fn topology(&self, edges: InitialEdges) -> Result<Topology, MeshError> {
        let first_frame = &self.reference[..self.pair().len()];
        Topology::initial(self.pair().clone(), first_frame, edges)
    }

    /// The reference as a mesh, weighted by the kernel.
    ///
    /// # Errors
    /// [`MeshError`].
    pub fn mesh(&self, topology: Arc<Topology>) -> Result<InteractionMesh, MeshError> {
        let weights =
            EdgeWeights::by_kernel(&topology, &self.reference, self.kernel, self.time_weight);
        InteractionMesh::new(topology, self.reference.clone(), weights)
    }

    /// The robot's joints with these edges between the people: `[m]`, `frames × joints`.
    ///
    /// # Errors
    /// [`PredictError::Mesh`], [`PredictError::Retarget`].
    pub fn solve(
        &self,
        edges: &LearnedEdges,
        observation: &Observation,
        settings: &PredictSettings,
    ) -> Result<Vec<Point>, PredictError> {
        let edges = edges.for_hands(self.pair(), self.robot_role(), self.hands);
        let between = edges.edges().iter().map(|learned| learned.edge);
        let topology = Arc::new(self.topology(InitialEdges::EachPerson)?.with(between)?);
        let mut weights =
            EdgeWeights::by_kernel(&topology, &self.reference, self.kernel, self.time_weight);
        for learned in edges.edges() {
            let Some(edge) = topology.find(learned.edge) else { continue };
            for frame in 0..self.frames() {
                let factor = learned.factors[self.phase(edges.phases(), frame)];
                weights.set(frame, edge, factor * weights.get(frame, edge));
            }
        }
        let mesh = InteractionMesh::new(topology.clone(), self.reference.clone(), weights)?;
        let retargeter = Retargeter::new(topology, &self.constraints, settings.retarget)?;
        let mut workspace = retargeter.workspace();
        retargeter.assemble(&mesh, &mut workspace)?;
        retargeter.factor(&mut workspace)?;
        let mut solved = self.targets.clone();
        retargeter.solve(&mesh, &self.targets, &self.lengths, &mut workspace, &mut solved)?;

        let pair = self.pair();
        let robot = pair.vertices(self.robot_role());
        let mut predicted = Vec::with_capacity(self.frames() * robot.len());
        for frame in solved.chunks_exact(pair.len()) {
            let first = predicted.len();
            predicted.extend(robot.clone().map(|vertex| frame[vertex.index()]));
            let (skeleton, lengths) = (&observation.robot_skeleton, &observation.bone_lengths);
            project_bones(skeleton, lengths, &mut predicted[first..]);
        }
        Ok(predicted)
    }
}

/// Near the reference's contact, brings its hands to the gap that the demonstrations had at theirs.
///
/// Time alignment misses the moment by a tenth of a second or two, and the mean of hands that meet
/// a little earlier and a little later is hands that do not meet.
fn hold_contact_gap(
    observation: &Observation,
    alignment: &Alignment,
    gap: Vector,
    fade: f64,
    robot: &mut [Point],
    partner: &[Point],
) {
    let hands = alignment.hands;
    let (robot_skeleton, partner_skeleton) =
        (&observation.robot_skeleton, observation.partner.skeleton());
    let (Some(robot_hand), Some(partner_hand)) = (
        robot_skeleton.part(Part::Hand(hands.robot)),
        partner_skeleton.part(Part::Hand(hands.partner)),
    ) else {
        return;
    };
    let contact = alignment.contact();
    let robot = robot.chunks_exact_mut(robot_skeleton.len());
    let partner = partner.chunks_exact(partner_skeleton.len());
    for (frame, (robot, partner)) in robot.zip(partner).enumerate() {
        let share = observation.nearness(frame, contact, fade);
        let goal = partner[partner_hand.index()] + observation.gap_in_world(frame, gap);
        let by = (goal - robot[robot_hand.index()]) * share;
        robot_skeleton.shift_with_riders(robot_hand, by, robot);
    }
}

/// The robot and its partner in the order of the recording's people.
#[derive(Debug, Clone)]
struct People {
    pair: Arc<Pair>,
    robot: Role,
}

impl People {
    fn of(observation: &Observation) -> Self {
        let robot = observation.robot_role;
        let skeletons =
            [observation.robot_skeleton.clone(), observation.partner.skeleton().clone()];
        Self { pair: Arc::new(Pair::new(robot.in_order(skeletons))), robot }
    }

    /// Both people's joints frame by frame, of `frames × joints` each.
    fn interleave(&self, robot: &[Point], partner: &[Point]) -> Vec<Point> {
        let frames = |role: Role| self.pair.skeleton(role).len();
        let robot = robot.chunks_exact(frames(self.robot));
        let partner = partner.chunks_exact(frames(self.robot.partner()));
        let both = robot.zip(partner).map(|(r, p)| self.robot.in_order([r, p]));
        both.flat_map(|[first, second]| first.iter().chain(second).copied()).collect()
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
        self.robot.in_order(lengths).concat().into_iter().map(|l| l.max(1e-6)).collect()
    }
}
