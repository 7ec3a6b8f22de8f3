//! All weights at once down the gradient: the spectral projected gradient method.
//!
//! Minimises `mean d + sparsity · d₀ · Σ x` (`d₀` the distance without edges) over `x ≥ 0`, where `x` is an edge's factor times the mean of
//! its kernel: about its weight, so that near and far edges answer alike (Birgin, Martínez & Raydan 2000,
//! SPG2: steps of Barzilai and Borwein's length, projected, with a line search that looks back at
//! the last ten values). Then edges with small `x` are dropped and the rest fitted without
//! the cost, so that what the cost took from them comes back. `d` is that of converged solves.

use rayon::prelude::*;

use super::{LearnError, LearnSettings, Lessons};

/// How many earlier values a line search looks back at.
const MEMORY: usize = 10;

/// What a step must gain of what the slope promises (Armijo).
const SUFFICIENT: f64 = 1e-4;

/// Halvings of a step at most.
const HALVINGS: usize = 30;

/// Bounds of a step's length.
const LENGTHS: [f64; 2] = [1e-10, 1e10];

/// A descent stands still when its last this many steps together gain less than the tolerance.
const PATIENCE: usize = 5;

/// Where a descent is: all that its next step depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct DescentState {
    /// Whether small weights have been dropped and the rest is being fitted.
    pub refit: bool,
    /// Mean weights `[-]` that are not 0: `(place in candidates × phases, weight)`, rising.
    pub weights: Vec<(usize, f64)>,
    /// The next step's length.
    pub length: f64,
    /// The last values of the objective `[m]`, the newest at the end.
    pub recent: Vec<f64>,
    /// Steps taken since the start, or since small weights were dropped.
    pub taken: usize,
    /// How many sets of weights the search has measured in all.
    pub evaluations: usize,
}

/// The search of `gradient`.
#[derive(Debug, Clone)]
pub(super) struct Descent {
    /// `x`: `candidates × phases`.
    weights: Vec<f64>,
    /// Of each candidate: the factor that makes its mean weight 1.
    scales: Vec<f64>,
    phases: usize,
    /// What a mean weight of 1 costs `[m]`.
    cost: f64,
    refit: bool,
    length: Option<f64>,
    recent: Vec<f64>,
    taken: usize,
    /// Value and slope at `weights`, once they have been asked for.
    at: Option<(f64, Vec<f64>)>,
}

impl Descent {
    /// No edges.
    ///
    /// # Errors
    /// [`LearnError::Retarget`].
    pub(super) fn start(
        lessons: &mut Lessons,
        settings: &LearnSettings,
    ) -> Result<Self, LearnError> {
        let phases = settings.phases;
        lessons.set_factors(&vec![0.0; lessons.candidates().len() * phases], phases)?;
        Ok(Self {
            weights: vec![0.0; lessons.candidates().len() * phases],
            scales: lessons.mean_kernels().into_iter().map(scale).collect(),
            phases,
            cost: settings.sparsity * lessons.distance()?,
            refit: false,
            length: None,
            recent: Vec::new(),
            taken: 0,
            at: None,
        })
    }

    /// What the kernel's weights are multiplied by: `candidates × phases`.
    pub(super) fn factors(&self) -> Vec<f64> {
        factors(&self.weights, &self.scales, self.phases)
    }

    pub(super) fn state(&self, evaluations: usize) -> DescentState {
        let weights = self.weights.iter().copied().enumerate().filter(|(_, weight)| *weight != 0.0);
        DescentState {
            refit: self.refit,
            weights: weights.collect(),
            length: self.length.unwrap_or(1.0),
            recent: self.recent.clone(),
            taken: self.taken,
            evaluations,
        }
    }

    /// Stands where an earlier descent stood; `None` if it cannot have stood there.
    pub(super) fn resume(&mut self, state: &DescentState) -> Option<()> {
        let mut weights = vec![0.0; self.weights.len()];
        for (at, weight) in &state.weights {
            *weights.get_mut(*at)? = Some(*weight).filter(|w| w.is_finite() && *w >= 0.0)?;
        }
        let usable = state.length.is_finite() && state.length > 0.0;
        let recent = (1..=MEMORY).contains(&state.recent.len());
        if !usable || !recent {
            return None;
        }
        *self = Self {
            weights,
            scales: std::mem::take(&mut self.scales),
            phases: self.phases,
            cost: self.cost,
            refit: state.refit,
            length: Some(state.length),
            recent: state.recent.clone(),
            taken: state.taken,
            at: None,
        };
        Some(())
    }

    /// One step down; how many sets of weights were measured, and whether there was a step to take.
    pub(super) fn step(
        &mut self,
        lessons: &mut Lessons,
        settings: &LearnSettings,
        measured: &(impl Fn() + Sync),
    ) -> Result<(usize, bool), LearnError> {
        let mut evaluations = 0;
        loop {
            let at_end = self.taken >= settings.steps || self.stands_still(settings.tolerance);
            if !at_end && self.descend(lessons, measured, &mut evaluations)? {
                self.taken += 1;
                return Ok((evaluations, true));
            }
            if self.refit {
                return Ok((evaluations, false));
            }
            self.drop_small(settings.threshold);
        }
    }

    /// Whether a step was found that gains enough.
    fn descend(
        &mut self,
        lessons: &mut Lessons,
        measured: &(impl Fn() + Sync),
        evaluations: &mut usize,
    ) -> Result<bool, LearnError> {
        let cost = if self.refit { 0.0 } else { self.cost };
        // A search that was broken off has counted where it stands already.
        let resumed = !self.recent.is_empty();
        let (scales, phases) = (&self.scales, self.phases);
        let mut objective = |weights: &[f64], counts: bool| {
            *evaluations += usize::from(counts);
            objective(lessons, weights, (scales, phases), cost, measured)
        };
        let (value, slope) = match self.at.take() {
            Some(at) => at,
            None => objective(&self.weights, !resumed)?,
        };
        if self.recent.is_empty() {
            self.recent.push(value);
        }
        let project = |length: f64| -> Vec<f64> {
            let moves = self.weights.iter().zip(&slope);
            // What was dropped stays dropped.
            let open = |weight: f64| !self.refit || weight > 0.0;
            moves.map(|(f, s)| if open(*f) { (f - length * s).max(0.0) - f } else { 0.0 }).collect()
        };
        let largest = project(1.0).iter().fold(0.0f64, |most, step| most.max(step.abs()));
        if largest == 0.0 {
            return Ok(false);
        }
        let length = self.length.unwrap_or(1.0 / largest).clamp(LENGTHS[0], LENGTHS[1]);
        let direction = project(length);
        let promised: f64 = direction.iter().zip(&slope).map(|(d, s)| d * s).sum();
        let bound = self.recent.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            let next = self.weights.iter().zip(&direction);
            let next: Vec<f64> = next.map(|(f, d)| (f + share * d).max(0.0)).collect();
            let (new_value, new_slope) = objective(&next, true)?;
            if new_value <= bound + SUFFICIENT * share * promised {
                self.length = Some(spectral_length(&next, &self.weights, &new_slope, &slope));
                self.weights = next;
                self.recent.push(new_value);
                if self.recent.len() > MEMORY {
                    self.recent.remove(0);
                }
                self.at = Some((new_value, new_slope));
                return Ok(true);
            }
            share *= 0.5;
        }
        // Rounding is all that is left to gain.
        Ok(false)
    }

    fn stands_still(&self, tolerance: f64) -> bool {
        let Some(before) = self.recent.len().checked_sub(PATIENCE + 1) else { return false };
        let now = self.recent.iter().copied().fold(f64::INFINITY, f64::min);
        self.recent[before] - now <= tolerance * now
    }

    /// Drops edges whose greatest weight is below a share of all, and starts to fit the rest.
    fn drop_small(&mut self, threshold: f64) {
        let largest = self.weights.iter().copied().fold(0.0, f64::max);
        for edge in self.weights.chunks_exact_mut(self.phases) {
            if edge.iter().copied().fold(0.0, f64::max) < threshold * largest {
                edge.fill(0.0);
            }
        }
        self.refit = true;
        self.length = None;
        self.recent.clear();
        self.taken = 0;
        self.at = None;
    }
}

/// Barzilai and Borwein's step length: how far the weights moved against how much the slope bent.
fn spectral_length(next: &[f64], last: &[f64], next_slope: &[f64], last_slope: &[f64]) -> f64 {
    let moved: Vec<f64> = next.iter().zip(last).map(|(next, last)| next - last).collect();
    let bent = next_slope.iter().zip(last_slope).zip(&moved);
    let bent: f64 = bent.map(|((next, last), moved)| moved * (next - last)).sum();
    let far: f64 = moved.iter().map(|moved| moved * moved).sum();
    if bent > 0.0 { (far / bent).clamp(LENGTHS[0], LENGTHS[1]) } else { LENGTHS[1] }
}

/// What makes an edge's mean weight 1; an edge that never weighs anything stays so.
fn scale(mean: f64) -> f64 {
    if mean > 0.0 && (1.0 / mean).is_finite() { 1.0 / mean } else { 0.0 }
}

/// `x` of each candidate and phase → what its kernel's weights are multiplied by.
fn factors(weights: &[f64], scales: &[f64], phases: usize) -> Vec<f64> {
    let of_candidates = weights.chunks_exact(phases).zip(scales);
    of_candidates.flat_map(|(weights, scale)| weights.iter().map(move |w| w * scale)).collect()
}

/// The mean distance of converged solves with the weights' cost `[m]`, and its slope by each.
fn objective(
    lessons: &mut Lessons,
    weights: &[f64],
    (scales, phases): (&[f64], usize),
    cost: f64,
    measured: &(impl Fn() + Sync),
) -> Result<(f64, Vec<f64>), LearnError> {
    lessons.set_factors(&factors(weights, scales, phases), phases)?;
    let count = lessons.lessons().len() as f64;
    let of_lessons: Vec<(f64, Vec<f64>)> = lessons
        .lessons()
        .par_iter()
        .map(|lesson| lesson.slopes(phases))
        .collect::<Result<_, _>>()?;
    measured();
    let mut value = cost * weights.iter().sum::<f64>();
    let mut slope = vec![cost; weights.len()];
    for (distance, by_factor) in of_lessons {
        value += distance / count;
        // By the chain rule: a factor is its weight times the scale.
        let by_weight = factors(&by_factor, scales, phases);
        slope.iter_mut().zip(by_weight).for_each(|(sum, slope)| *sum += slope / count);
    }
    Ok((value, slope))
}
