//! One reference motion to learn from: a retargeting whose right answer is known.

use std::sync::Arc;

use super::{LearnError, LearnSettings};
use crate::demonstration::{Demonstration, Hands};
use crate::geometry::{Point, Vector};
use crate::mesh::{Edge, InitialEdges, Pair};
use crate::predict::{PredictSettings, Problem, edge_for_hands};
use crate::retarget::{Prepared, Retargeter, Variation};
use crate::skeleton::{JointId, Part};

/// How far from its limit a solve may be whose slope is taken `[m]`.
const CONVERGED: f64 = 1e-7;

/// A retargeting with what the person in the robot's role really did, and every candidate edge in
/// its mesh.
#[derive(Debug, Clone)]
pub struct Lesson {
    name: String,
    pub(super) prepared: Prepared,
    /// Of each candidate: its place among this mesh' edges.
    edges: Vec<usize>,
    /// Of each candidate, whether Delaunay tetrahedra of both people's first frame have it.
    initial: Vec<bool>,
    /// Of each candidate and frame: the kernel's weight. `candidates × frames`.
    kernel: Vec<f64>,
    /// What really happened `[m]`: `frames × vertices`.
    truth: Vec<Point>,
    /// ωᵢ `[-]`, `frames × vertices`.
    weights: Vec<f64>,
    /// Of each frame, its phase.
    phases: Vec<usize>,
}

impl Lesson {
    /// Puts all candidates into the problem's mesh, with weight 0.
    ///
    /// - `truth`: the reference motion.
    /// - `candidates`: edges that join the people, named for the active hands `named_for`.
    /// - `ignored`: the robot's joints that do not count.
    ///
    /// # Errors
    /// [`LearnError`] if mesh or solve refuse the motion.
    pub fn new(
        truth: &Demonstration,
        problem: &Problem,
        (candidates, named_for): (&[Edge], Hands),
        ignored: &[JointId],
        predict: &PredictSettings,
        settings: &LearnSettings,
    ) -> Result<Self, LearnError> {
        let (pair, role, hands) = (problem.pair(), problem.robot_role(), problem.hands());
        let here = |edge: &Edge| edge_for_hands(*edge, pair, role, named_for, hands);
        let here: Vec<Edge> = candidates.iter().map(here).collect();
        let both = problem.topology(InitialEdges::BothPeople)?;
        let topology = problem.topology(InitialEdges::EachPerson)?;
        let topology = Arc::new(topology.with(here.iter().copied())?);
        let edges: Vec<usize> = here.iter().filter_map(|edge| topology.find(*edge)).collect();
        let mut mesh = problem.mesh(topology.clone())?;
        let frames = problem.frames();
        let mut kernel = Vec::with_capacity(edges.len() * frames);
        for edge in &edges {
            kernel.extend((0..frames).map(|frame| mesh.weights().get(frame, *edge)));
        }
        for edge in &edges {
            mesh.switch_off(*edge)?;
        }
        let retargeter = Retargeter::new(topology, problem.constraints(), predict.retarget)?;
        let (targets, lengths) = (problem.targets().to_vec(), problem.lengths().to_vec());
        Ok(Self {
            name: truth.recording().name().to_owned(),
            prepared: Prepared::new(retargeter, mesh, targets, lengths)?,
            edges,
            initial: here.iter().map(|edge| both.find(*edge).is_some()).collect(),
            kernel,
            truth: pair.positions(truth.recording()),
            weights: weights(truth, pair, hands, ignored, settings),
            phases: (0..frames).map(|frame| problem.phase(settings.phases, frame)).collect(),
        })
    }

    /// The reference's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The number of frames.
    pub fn frames(&self) -> usize {
        self.phases.len()
    }

    /// Whether Delaunay tetrahedra of both people's first frame have a candidate.
    pub fn is_initial(&self, candidate: usize) -> bool {
        self.initial[candidate]
    }

    /// A candidate's weight in all frames, where it is on.
    pub(super) fn kernel(&self, candidate: usize) -> &[f64] {
        &self.kernel[candidate * self.frames()..(candidate + 1) * self.frames()]
    }

    /// Room for [`Self::distance_with`]; a change of edges makes it useless.
    pub fn room(&self) -> Variation {
        self.prepared.variation()
    }

    /// Gives every candidate its factors of the kernel's weight: `candidates × phases`.
    ///
    /// # Errors
    /// [`LearnError::Mesh`] if one is not finite or negative.
    pub fn set_factors(&mut self, factors: &[f64], phases: usize) -> Result<(), LearnError> {
        let Self { prepared, edges, kernel, phases: phase_of, .. } = self;
        let frames = phase_of.len();
        let weights = |candidate: usize, weights: &mut [f64]| {
            let factors = &factors[candidate * phases..(candidate + 1) * phases];
            let kernel = &kernel[candidate * frames..(candidate + 1) * frames];
            for ((weight, kernel), phase) in weights.iter_mut().zip(kernel).zip(&*phase_of) {
                *weight = factors[*phase] * kernel;
            }
        };
        Ok(prepared.reweigh(edges, weights)?)
    }

    /// The distance `[m]` as the edges stand.
    ///
    /// # Errors
    /// [`LearnError::Retarget`] if the mesh has no solution.
    pub fn distance(&self, room: &mut Variation) -> Result<f64, LearnError> {
        self.prepared.solve(room)?;
        Ok(self.distance_of(room.solved()))
    }

    /// The distance `[m]` with one candidate switched on or off, the others as they stand.
    ///
    /// # Errors
    /// [`LearnError::Retarget`] if the mesh has no solution.
    pub fn distance_with(
        &self,
        candidate: usize,
        on: bool,
        room: &mut Variation,
    ) -> Result<f64, LearnError> {
        let edge = self.edges[candidate];
        let weights = if on { Some(self.kernel(candidate)) } else { None };
        self.prepared.solve_with(edge, weights, room)?;
        Ok(self.distance_of(room.solved()))
    }

    /// The distance `[m]` of the converged solve as the edges stand, and its derivative by every
    /// candidate's factors: `candidates × phases`.
    ///
    /// # Errors
    /// [`LearnError::Retarget`], [`LearnError::NoDerivative`].
    pub(super) fn slopes(&self, phases: usize) -> Result<(f64, Vec<f64>), LearnError> {
        let mut room = self.room();
        self.prepared.converge(CONVERGED, &mut room)?;
        let off = room.solved().iter().zip(&self.truth).zip(&self.weights);
        // Where there is no error any more every direction is as good.
        let slope = off.map(|((a, b), weight)| {
            let off = a - b;
            off * (weight / off.norm().max(f64::MIN_POSITIVE))
        });
        let slope: Vec<Vector> = slope.collect();
        let distance = self.distance_of(room.solved());
        let by_weight = self.prepared.slopes(&slope, &self.edges, &mut room)?;
        let mut slopes = vec![0.0; self.edges.len() * phases];
        let by_edge =
            by_weight.chunks_exact(self.frames()).zip(self.kernel.chunks_exact(self.frames()));
        for (candidate, (by_weight, kernel)) in by_edge.enumerate() {
            for ((slope, kernel), phase) in by_weight.iter().zip(kernel).zip(&self.phases) {
                slopes[candidate * phases + phase] += slope * kernel;
            }
        }
        Ok((distance, slopes))
    }

    /// `Σᵢ ωᵢ ‖vᵢ − v'ᵢ‖` `[m]` of `frames × vertices` positions (Thai 2014, eq. 3.9).
    pub fn distance_of(&self, solved: &[Point]) -> f64 {
        let pairs = solved.iter().zip(&self.truth).zip(&self.weights);
        let counted = pairs.filter(|(_, weight)| **weight > 0.0);
        counted.map(|((a, b), weight)| weight * (a - b).norm()).sum()
    }
}

/// ω of every vertex in every frame: the robot's joints count, but for its base and those ignored;
/// the active hand and the frames around contact count more.
fn weights(
    truth: &Demonstration,
    pair: &Pair,
    hands: Hands,
    ignored: &[JointId],
    settings: &LearnSettings,
) -> Vec<f64> {
    let role = truth.robot_role();
    let mut joints = vec![0.0; pair.len()];
    let hand = pair.skeleton(role).part(Part::Hand(hands.robot));
    for joint in pair.skeleton(role).joints().take(pair.skeleton(role).own()) {
        if joint != truth.robot_base() && !ignored.contains(&joint) {
            joints[pair.vertex(role, joint).index()] =
                if Some(joint) == hand { settings.hand_weight } else { 1.0 };
        }
    }
    let (observation, contact) = (truth.observation(), truth.contact().frame as f64);
    let frames = (0..observation.len()).map(|frame| {
        let near = observation.nearness(frame, contact, settings.contact_fade);
        1.0 + settings.contact_weight * near
    });
    frames.flat_map(|frame| joints.iter().map(move |joint| frame * joint)).collect()
}
