//! References to learn from, and those held out: which demonstrations, on whose shoulders.

use std::sync::Arc;

use rayon::prelude::*;

use super::{LearnError, LearnSettings, Lesson};
use crate::demonstration::{Demonstration, Hands};
use crate::geometry::Vector;
use crate::mesh::{Edge, Pair};
use crate::predict::{LearnedEdge, LearnedEdges, PredictSettings, Predictor, Problem};
use crate::retarget::Variation;
use crate::skeleton::{JointId, Part, Role};

/// References over one set of candidate edges: all that join a joint of one person with a joint of
/// the other.
#[derive(Debug, Clone)]
pub struct Lessons {
    pair: Arc<Pair>,
    /// The hands that the candidates are named for.
    hands: Hands,
    candidates: Vec<Edge>,
    lessons: Vec<Lesson>,
    /// References not learned from: they only say how well the edges serve others.
    held_out: Vec<Lesson>,
}

/// One thread's room for all lessons.
pub type Room = Vec<Variation>;

impl Lessons {
    /// References out of a predictor's demonstrations: at most [`LearnSettings::references`] to
    /// learn from, and of other groups as many again held out, if there are so many. What is held
    /// out is no source of the others either.
    ///
    /// Each is retargeted from one demonstration of another group: the one with the same hands
    /// whose contact is farthest from its own. From the mean of the nearest, which is what
    /// [`Predictor::problem`] starts from, there would be little left for edges to bridge, and
    /// what they are for is the place that nobody has shown.
    ///
    /// The first reference is the one whose contact lies nearest the middle of all, the next
    /// always the one whose contact is farthest from those chosen (ties go to the first by name):
    /// few references that cover where people hand over. The contact's place is the partner's
    /// hand from the robot's base, in the partner's heading frame.
    ///
    /// - `groups`: one per demonstration; none learns from its own group.
    /// - `ignored`: the robot's joints that do not count.
    ///
    /// # Errors
    /// [`LearnError::NoLessons`] if no demonstration has others to be retargeted from;
    /// [`LearnError`] if one cannot be solved.
    /// # Panics
    /// If there is not one group per demonstration.
    pub fn of(
        predictor: &Predictor,
        groups: &[String],
        ignored: &[JointId],
        settings: &LearnSettings,
    ) -> Result<Self, LearnError> {
        let settings = &settings.with_own_phases();
        let demonstrations = predictor.demonstrations();
        assert_eq!(demonstrations.len(), groups.len(), "one group per demonstration");
        let met = met(demonstrations);
        let apart = |one: usize, other: usize| groups[one] != groups[other];
        let has_others = |at: &usize| met.iter().any(|other| apart(*other, *at));
        let usable: Vec<usize> = met.iter().copied().filter(has_others).collect();
        let chosen = spread(demonstrations, &usable, settings.references);
        let strangers =
            usable.iter().copied().filter(|at| chosen.iter().all(|one| apart(*at, *one)));
        let strangers: Vec<usize> = strangers.collect();
        let mut held_out = spread(demonstrations, &strangers, settings.references);
        // Whoever is held out is nobody's source; somebody must be left to learn from.
        let is_left = |held_out: &[usize], at: usize| {
            met.iter().any(|other| apart(*other, at) && !held_out.contains(other))
        };
        while chosen.iter().any(|at| !is_left(&held_out, *at)) && held_out.pop().is_some() {}
        let first = demonstrations.first().ok_or(LearnError::NoLessons)?;
        let hands = usual_hands(demonstrations).ok_or(LearnError::NoLessons)?;
        let pair = Arc::new(Pair::of(first.recording()));
        let candidates = candidates(&pair);
        let lesson = |at: &usize| {
            let known = |other: usize| apart(other, *at) && !held_out.contains(&other);
            let sources = |other: usize| known(other) && met.contains(&other);
            let from = farthest(demonstrations, *at, sources).ok_or(LearnError::NoLessons)?;
            let problem = predictor.practice(*at, from, known)?;
            let named = (candidates.as_slice(), hands);
            let (truth, predict) = (&demonstrations[*at], predictor.settings());
            Lesson::new(truth, &problem, named, ignored, predict, settings)
        };
        let lessons: Vec<Lesson> =
            chosen.par_iter().map(&lesson).collect::<Result<_, LearnError>>()?;
        let held_out: Vec<Lesson> =
            held_out.par_iter().map(&lesson).collect::<Result<_, LearnError>>()?;
        Self::new(pair, hands, lessons, held_out)
    }

    /// One reference, and how it is retargeted.
    ///
    /// - `truth`: the reference motion.
    /// - `hands`: those that the candidates are named for.
    /// - `ignored`: the robot's joints that do not count.
    ///
    /// # Errors
    /// [`LearnError`] if it cannot be solved.
    pub fn single(
        truth: &Demonstration,
        problem: &Problem,
        hands: Hands,
        ignored: &[JointId],
        predict: &PredictSettings,
        settings: &LearnSettings,
    ) -> Result<Self, LearnError> {
        let pair = problem.pair().clone();
        let candidates = candidates(&pair);
        let (named, settings) = ((candidates.as_slice(), hands), settings.with_own_phases());
        let lesson = Lesson::new(truth, problem, named, ignored, predict, &settings)?;
        Self::new(pair, hands, vec![lesson], Vec::new())
    }

    /// References made elsewhere, over all edges that join the pair.
    ///
    /// # Errors
    /// [`LearnError::NoLessons`] if there are none to learn from.
    pub fn new(
        pair: Arc<Pair>,
        hands: Hands,
        lessons: Vec<Lesson>,
        held_out: Vec<Lesson>,
    ) -> Result<Self, LearnError> {
        if lessons.is_empty() {
            return Err(LearnError::NoLessons);
        }
        let candidates = candidates(&pair);
        Ok(Self { pair, hands, candidates, lessons, held_out })
    }

    /// Both people's skeletons.
    pub fn pair(&self) -> &Arc<Pair> {
        &self.pair
    }

    /// The edges that may be learned, in order.
    pub fn candidates(&self) -> &[Edge] {
        &self.candidates
    }

    /// The references to learn from.
    pub fn lessons(&self) -> &[Lesson] {
        &self.lessons
    }

    /// The references held out.
    pub fn held_out(&self) -> &[Lesson] {
        &self.held_out
    }

    /// One thread's room for solving all lessons.
    pub fn room(&self) -> Room {
        self.lessons.iter().map(Lesson::room).collect()
    }

    /// Gives every candidate its factors in all lessons: `candidates × phases`.
    ///
    /// # Errors
    /// [`LearnError::Mesh`] if one is not finite or negative.
    pub fn set_factors(&mut self, factors: &[f64], phases: usize) -> Result<(), LearnError> {
        let all = self.lessons.par_iter_mut().chain(&mut self.held_out);
        all.map(|lesson| lesson.set_factors(factors, phases)).collect()
    }

    /// The mean of the kernel's weight `[-]` over all references' frames, of each candidate.
    pub(super) fn mean_kernels(&self) -> Vec<f64> {
        let mean = |candidate: usize| {
            let weights = || self.lessons.iter().flat_map(|lesson| lesson.kernel(candidate));
            weights().sum::<f64>() / weights().count() as f64
        };
        (0..self.candidates.len()).map(mean).collect()
    }

    /// Gives every candidate what learning found elsewhere: 0 where it found no edge.
    ///
    /// # Errors
    /// [`LearnError::Mesh`] if a weight comes out too large for a number.
    /// # Panics
    /// If the edges are named for other hands than the candidates.
    pub fn set_edges(&mut self, edges: &LearnedEdges) -> Result<(), LearnError> {
        assert_eq!(edges.hands(), self.hands, "edges and candidates named for the same hands");
        let phases = edges.phases();
        let mut factors = vec![0.0; self.candidates.len() * phases];
        for learned in edges.edges() {
            if let Ok(at) = self.candidates.binary_search(&learned.edge) {
                factors[at * phases..(at + 1) * phases].copy_from_slice(&learned.factors);
            }
        }
        self.set_factors(&factors, phases)
    }

    /// The mean distance `[m]` of the references to learn from.
    ///
    /// # Errors
    /// [`LearnError::Retarget`].
    pub fn distance(&self) -> Result<f64, LearnError> {
        Ok(mean_distance(&self.lessons)?.unwrap_or(0.0))
    }

    /// The mean distance `[m]` of the references held out; `None` where there are none.
    ///
    /// # Errors
    /// [`LearnError::Retarget`].
    pub fn held_out_distance(&self) -> Result<Option<f64>, LearnError> {
        mean_distance(&self.held_out)
    }

    /// The mean distance `[m]` with one candidate switched on or off.
    ///
    /// # Errors
    /// [`LearnError::Retarget`].
    pub fn distance_with(
        &self,
        candidate: usize,
        on: bool,
        room: &mut Room,
    ) -> Result<f64, LearnError> {
        let mut sum = 0.0;
        for (lesson, room) in self.lessons.iter().zip(room) {
            sum += lesson.distance_with(candidate, on, room)?;
        }
        Ok(sum / self.lessons.len() as f64)
    }

    /// Candidates with any factor above 0 as edges.
    ///
    /// # Errors
    /// [`LearnError::Edges`] if factors are not finite or negative.
    pub fn learned(&self, factors: &[f64], phases: usize) -> Result<LearnedEdges, LearnError> {
        let edges = self.candidates.iter().zip(factors.chunks_exact(phases));
        let edges = edges.filter(|(_, factors)| factors.iter().any(|factor| *factor != 0.0));
        let edges =
            edges.map(|(edge, factors)| LearnedEdge { edge: *edge, factors: factors.to_vec() });
        Ok(LearnedEdges::new(&self.pair, self.hands, phases, edges.collect())?)
    }
}

/// All edges between two people, in order.
fn candidates(pair: &Pair) -> Vec<Edge> {
    let first = pair.vertices(Role::First);
    let edges = first.flat_map(|a| pair.vertices(Role::Second).map(move |b| Edge::new(a, b)));
    edges.collect()
}

fn mean_distance(lessons: &[Lesson]) -> Result<Option<f64>, LearnError> {
    let distances: Vec<f64> = lessons
        .par_iter()
        .map(|lesson| lesson.distance(&mut lesson.room()))
        .collect::<Result<_, _>>()?;
    let mean = distances.iter().sum::<f64>() / distances.len() as f64;
    Ok((!distances.is_empty()).then_some(mean))
}

/// The hands that meet most often, the first of equals.
fn usual_hands(demonstrations: &[Arc<Demonstration>]) -> Option<Hands> {
    let count = |hands: Hands| demonstrations.iter().filter(|d| d.contact().hands == hands).count();
    Hands::all().reduce(|best, next| if count(next) > count(best) { next } else { best })
}

/// Where the partner's hand is at contact, from the robot's base, in the partner's heading frame
/// `[m]`.
fn contact_place(demonstration: &Demonstration) -> Vector {
    let contact = demonstration.contact();
    let partner = demonstration.partner();
    let hand = partner.skeleton().part(Part::Hand(contact.hands.partner));
    let hand = hand.unwrap_or_else(|| demonstration.partner_base());
    let base = demonstration.robot().position(contact.frame, demonstration.robot_base());
    demonstration
        .observation()
        .gap_in_heading(contact.frame, partner.position(contact.frame, hand) - base)
}

/// Demonstrations whose hands came about as near as people's do: at most twice as far apart as in
/// the middle one. A sensor that lost a hand shows two that never meet, and the farthest of all
/// would be just those.
fn met(demonstrations: &[Arc<Demonstration>]) -> Vec<usize> {
    let mut distances: Vec<f64> = demonstrations.iter().map(|d| d.contact().distance).collect();
    distances.sort_by(f64::total_cmp);
    let middle = distances.get((distances.len().max(1) - 1) / 2).copied().unwrap_or(0.0);
    let near = |at: &usize| demonstrations[*at].contact().distance <= 2.0 * middle;
    (0..demonstrations.len()).filter(near).collect()
}

/// Of the allowed demonstrations with the same hands (of all, where there are none) the one whose
/// contact is farthest from this one's.
fn farthest(
    demonstrations: &[Arc<Demonstration>],
    at: usize,
    allowed: impl Fn(usize) -> bool,
) -> Option<usize> {
    let here = contact_place(&demonstrations[at]);
    let score = |other: usize| {
        let same = demonstrations[other].contact().hands == demonstrations[at].contact().hands;
        (same, (contact_place(&demonstrations[other]) - here).norm())
    };
    let others = (0..demonstrations.len()).filter(|other| allowed(*other));
    others.reduce(|best, next| if score(next) > score(best) { next } else { best })
}

/// At most `count` of `usable`, spread over where hands meet.
fn spread(demonstrations: &[Arc<Demonstration>], usable: &[usize], count: usize) -> Vec<usize> {
    let mut open: Vec<(usize, Vector)> =
        usable.iter().map(|at| (*at, contact_place(&demonstrations[*at]))).collect();
    open.sort_by_key(|(at, _)| demonstrations[*at].recording().name());
    let middle = open.iter().map(|(_, place)| place).sum::<Vector>() / open.len().max(1) as f64;
    let mut chosen: Vec<(usize, Vector)> = Vec::new();
    while chosen.len() < count && !open.is_empty() {
        let apart = |place: &Vector| match chosen.as_slice() {
            [] => -(place - middle).norm(),
            chosen => {
                let apart = chosen.iter().map(|(_, other)| (place - other).norm());
                apart.fold(f64::INFINITY, f64::min)
            }
        };
        let scores: Vec<f64> = open.iter().map(|(_, place)| apart(place)).collect();
        // The first of equals.
        let best =
            (1..open.len()).fold(0, |best, at| if scores[at] > scores[best] { at } else { best });
        chosen.push(open.remove(best));
    }
    chosen.into_iter().map(|(at, _)| at).collect()
}
