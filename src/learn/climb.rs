//! Steepest-ascent hill climbing over single edges (Thai 2014, Algorithm 1).

use rayon::prelude::*;

use super::{LearnError, LearnMethod, Lessons, Move};
use crate::mesh::Edge;

/// Which candidates are edges.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Climb {
    on: Vec<bool>,
}

impl Climb {
    /// `prune` starts from the edges of both people's Delaunay tetrahedra in any reference, all
    /// others from none.
    pub(super) fn start(method: LearnMethod, lessons: &Lessons) -> Self {
        let initial = |at: usize| lessons.lessons().iter().any(|lesson| lesson.is_initial(at));
        let on = (0..lessons.candidates().len())
            .map(|at| method == LearnMethod::Prune && initial(at))
            .collect();
        Self { on }
    }

    /// One factor per candidate.
    pub(super) fn factors(&self) -> Vec<f64> {
        self.on.iter().map(|on| f64::from(u8::from(*on))).collect()
    }

    /// `(candidate, on)`: every single change that the method may make.
    pub(super) fn moves(&self, method: LearnMethod) -> impl Iterator<Item = (usize, bool)> + '_ {
        let (adds, removes) = match method {
            LearnMethod::Grow => (true, false),
            LearnMethod::Prune => (false, true),
            LearnMethod::GrowPrune => (true, true),
            LearnMethod::None | LearnMethod::Gradient => (false, false),
        };
        let moves = self.on.iter().enumerate().map(|(candidate, on)| (candidate, !on));
        moves.filter(move |(_, on)| if *on { adds } else { removes })
    }

    /// Measures all single changes; the best one, the first of equals, and its distance `[m]`.
    pub(super) fn best(
        &self,
        method: LearnMethod,
        lessons: &Lessons,
        measured: impl Fn() + Sync,
    ) -> Result<Option<(usize, f64)>, LearnError> {
        let moves: Vec<(usize, bool)> = self.moves(method).collect();
        let distances: Vec<f64> = moves
            .par_iter()
            .with_min_len(8)
            .map_init(
                || lessons.room(),
                |room, (candidate, on)| {
                    let distance = lessons.distance_with(*candidate, *on, room);
                    measured();
                    distance
                },
            )
            .collect::<Result<_, _>>()?;
        let both =
            moves.iter().zip(distances).map(|((candidate, _), distance)| (*candidate, distance));
        Ok(both.reduce(|best, next| if next.1 < best.1 { next } else { best }))
    }

    /// Switches a candidate.
    pub(super) fn toggle(&mut self, candidate: usize, candidates: &[Edge]) -> Move {
        self.on[candidate] = !self.on[candidate];
        let edge = candidates[candidate];
        if self.on[candidate] { Move::Add(edge) } else { Move::Remove(edge) }
    }
}
