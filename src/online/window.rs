//! The mesh over a few frames of past and future, solved for the robot's joints.
//!
//! As [`crate::predict::Problem`] does for a whole interaction: the partner's joints and the
//! robot's base are known and, unless soft, eliminated; their Laplacian rows stay; bones are made
//! exact behind the solve. Pattern and workspace are made once per pair of hands.

use std::sync::Arc;

use super::reference::ahead;
use super::{OnlineError, OnlineModel, Reference, Scene};
use crate::demonstration::Hands;
use crate::geometry::Point;
use crate::mesh::{EdgeWeights, InitialEdges, InteractionMesh, Topology, Vertex};
use crate::predict::{KnownJoints, phase};
use crate::retarget::{
    Constraint, Residual, RetargetSettings, Retargeter, Transform, Workspace, project_bones,
};
use crate::skeleton::{JointId, Role};
use crate::track::{Belief, Followed, Who};

/// One pair of hands' mesh: who neighbours whom, and the room to solve it.
#[derive(Debug, Clone)]
struct System {
    retargeter: Retargeter,
    workspace: Workspace,
    mesh: InteractionMesh,
    between: Vec<Between>,
    is_factored: bool,
}

/// An edge between the people.
#[derive(Debug, Clone)]
struct Between {
    /// Its place in the topology.
    edge: usize,
    ends: [usize; 2],
    /// What the kernel's weight is multiplied by `[-]`, one per phase of the interaction.
    factors: Vec<f64>,
    /// Its weights as of now `[-]`, one per frame: room to find out whether they changed.
    weights: Vec<f64>,
}

/// Solves windows; all it needs it holds.
#[derive(Debug, Clone)]
pub struct Window {
    /// One for each pair of hands, by [`Hands::index`].
    systems: Vec<System>,
    positions: Vec<Point>,
    targets: Vec<Point>,
    solved: Vec<Point>,
    /// Whose hands the last solution was for, if there is one to start from.
    warm: Option<Hands>,
    /// Both people's bones, in the pair's order `[m]`.
    lengths: Vec<f64>,
    robot_lengths: Vec<f64>,
    /// The robot's joints now and at each later frame `[m]`.
    poses: Vec<Point>,
}

impl Window {
    /// Lays out the systems of all pairs of hands.
    ///
    /// - `robot_lengths`: the robot's bones `[m]`, in its skeleton's bone order, > 0.
    /// - `edges`: whether the edges between the people count.
    ///
    /// # Errors
    /// [`OnlineError::Mesh`], [`OnlineError::Retarget`].
    pub fn new(
        model: &OnlineModel,
        robot_lengths: &[f64],
        edges: bool,
    ) -> Result<Self, OnlineError> {
        let frames = model.settings.past + 1 + model.settings.future;
        let pair = &model.pair;
        let library = &model.library;
        let first = |who: Who| -> Vec<Point> {
            let joints = library.skeleton(who).joints();
            joints.map(|joint| library.position(0, who, 0.0, joint)).collect()
        };
        let first_frame = model.robot.in_order([first(Who::Robot), first(Who::Partner)]).concat();
        let positions = first_frame.repeat(frames);
        let base = pair.vertex(model.robot, library.base(Who::Robot));
        let vertices = [Role::First, Role::Second].into_iter().flat_map(|role| pair.vertices(role));
        let known = match model.predict.known {
            KnownJoints::Eliminated => Constraint::Fixed,
            KnownJoints::Soft => Constraint::Soft(1.0),
        };
        let constraints: Vec<Constraint> = vertices
            .map(|vertex| {
                let is_known = pair.role(vertex) != model.robot || vertex == base;
                if is_known { known } else { Constraint::Free }
            })
            .collect();
        let constraints = constraints.repeat(frames);
        let mut systems = Vec::new();
        for hands in Hands::all() {
            let learned = model.edges.for_hands(pair, model.robot, hands);
            let learned = if edges { learned.edges() } else { &[] };
            let topology = Topology::initial(pair.clone(), &first_frame, InitialEdges::EachPerson)?
                .with(learned.iter().map(|learned| learned.edge))?;
            let topology = Arc::new(topology);
            let between = learned.iter().filter_map(|learned| {
                Some(Between {
                    edge: topology.find(learned.edge)?,
                    ends: learned.edge.ends().map(Vertex::index),
                    factors: learned.factors.clone(),
                    weights: vec![0.0; frames],
                })
            });
            let between = between.collect();
            let (kernel, time) = (model.predict.kernel, model.predict.time_weight);
            let weights = EdgeWeights::by_kernel(&topology, &positions, kernel, time);
            let mesh = InteractionMesh::new(topology.clone(), positions.clone(), weights)?;
            let settings =
                RetargetSettings { steps: model.settings.steps, ..model.predict.retarget };
            let retargeter = Retargeter::new(topology, &constraints, settings)?;
            let workspace = retargeter.workspace();
            systems.push(System { retargeter, workspace, mesh, between, is_factored: false });
        }
        let partner_lengths = library.skeleton(Who::Partner).bones().map(|bone| {
            let place = |joint: JointId| library.position(0, Who::Partner, 0.0, joint);
            (place(bone.child) - place(bone.parent)).norm().max(1e-6)
        });
        let lengths = [robot_lengths.to_vec(), partner_lengths.collect()];
        let joints = library.skeleton(Who::Robot).len();
        Ok(Self {
            systems,
            targets: positions.clone(),
            solved: positions.clone(),
            positions,
            warm: None,
            lengths: model.robot.in_order(lengths).concat(),
            robot_lengths: robot_lengths.to_vec(),
            poses: vec![Point::origin(); (model.settings.future + 1) * joints],
        })
    }

    /// Forgets the last solution and factor: the next solve is as a new window's.
    pub fn reset(&mut self) {
        self.warm = None;
        self.systems.iter_mut().for_each(|system| system.is_factored = false);
    }

    /// The robot's joints now and at each later frame of the last window: `[m]`,
    /// `(1 + future) × joints`, bones exact.
    pub fn poses(&self) -> &[Point] {
        &self.poses
    }

    /// Bends the reference to where the partner and the robot's base are.
    ///
    /// Without allocation.
    ///
    /// # Errors
    /// [`OnlineError`] where a place is not finite or nothing known holds a joint.
    pub fn solve(
        &mut self,
        model: &OnlineModel,
        belief: &Belief,
        scene: &Scene,
        reference: &Reference,
    ) -> Result<Residual, OnlineError> {
        interleave(model, &reference.robot, &reference.partner, &mut self.positions);
        interleave(model, &reference.robot, &scene.partner, &mut self.targets);
        let system = &mut self.systems[belief.hands.index()];
        system.mesh.set_positions(&self.positions)?;
        system.weigh(model, belief)?;
        // The rows of an implicit transform hold the reference itself, which every tick changes.
        if !system.is_factored || model.predict.retarget.transform == Transform::Implicit {
            // Only a system whose factorisation succeeded counts as factored.
            system.is_factored = false;
            system.retargeter.assemble(&system.mesh, &mut system.workspace)?;
            system.retargeter.factor(&mut system.workspace)?;
            system.is_factored = true;
        }
        let System { retargeter, workspace, mesh, .. } = system;
        // Bones point nearly as they did a tick ago, as long as the same hands are to meet.
        let is_warm = self.warm.replace(belief.hands) == Some(belief.hands);
        let (targets, lengths, solved) = (&self.targets, &self.lengths, &mut self.solved);
        let residual = if is_warm {
            retargeter.solve_on(mesh, targets, lengths, workspace, solved)
        } else {
            retargeter.solve(mesh, targets, lengths, workspace, solved)
        };
        let residual = residual.inspect_err(|_| self.warm = None)?;
        let robot = model.library.skeleton(Who::Robot);
        let vertices = model.pair.vertices(model.robot);
        let frames = self.solved.chunks_exact(model.pair.len()).skip(model.settings.past);
        for (pose, frame) in self.poses.chunks_exact_mut(robot.len()).zip(frames) {
            for (place, vertex) in pose.iter_mut().zip(vertices.clone()) {
                *place = frame[vertex.index()];
            }
            project_bones(robot, &self.robot_lengths, pose);
        }
        Ok(residual)
    }
}

impl System {
    /// Gives the edges between the people their weights, and notes whether that undoes the factor.
    ///
    /// Weights that changed by less than [`super::OnlineSettings::refactor`] stay as they were.
    fn weigh(&mut self, model: &OnlineModel, belief: &Belief) -> Result<(), OnlineError> {
        let kernel = model.predict.kernel;
        let vertices = model.pair.len();
        let mut changed = !self.is_factored;
        for Between { edge, ends, factors, weights } in &mut self.between {
            let places = self.mesh.positions().chunks_exact(vertices);
            for (frame, (weight, places)) in weights.iter_mut().zip(places).enumerate() {
                let distance = (places[ends[0]] - places[ends[1]]).norm();
                *weight = factor(model, belief, factors, frame) * kernel.weight(distance);
                let before = self.mesh.weights().get(frame, *edge);
                changed |= (*weight - before).abs() > model.settings.refactor * before;
            }
        }
        if changed {
            self.is_factored = false;
            for between in &self.between {
                self.mesh.reweigh(between.edge, &between.weights)?;
            }
        }
        Ok(())
    }
}

/// The factor of an edge's weight in a frame of the window: the mean over the demonstrations
/// followed, each at the phase that it is believed to be in by then.
///
/// - `factors`: one per phase.
fn factor(model: &OnlineModel, belief: &Belief, factors: &[f64], frame: usize) -> f64 {
    let ahead = ahead(model, belief, frame);
    let of_one = |followed: &Followed| {
        let exemplar = &model.library.exemplars()[followed.exemplar];
        let at = followed.frame + ahead;
        followed.weight * factors[phase(factors.len(), at, exemplar.contact, exemplar.len())]
    };
    belief.followed.iter().map(of_one).sum()
}

/// Both people's joints frame by frame, in the recordings' order.
fn interleave(model: &OnlineModel, robot: &[Point], partner: &[Point], both: &mut [Point]) {
    let joints = |who| model.library.skeleton(who).len();
    let robot = robot.chunks_exact(joints(Who::Robot));
    let partner = partner.chunks_exact(joints(Who::Partner));
    for (frame, (robot, partner)) in both.chunks_exact_mut(model.pair.len()).zip(robot.zip(partner))
    {
        let [first, second] = model.robot.in_order([robot, partner]);
        let (front, back) = frame.split_at_mut(first.len());
        front.copy_from_slice(first);
        back.copy_from_slice(second);
    }
}
