//! How much each method's say counts: least squares on recordings that none of them learned from.
//!
//! Over horizon `h` the displacement is `Σₘ aₘₕ rₘ` for the root and `Σₘ bₘₕ (dₘ − rₘ)` for the
//! other joints relative to it, with `rₘ` the root's and `dₘ` a joint's displacement by method `m`
//! (stacked regression, Breiman 1996).

use nalgebra::{SMatrix, SVector};

/// How many methods are mixed.
pub(super) const EXPERTS: usize = 4;

/// Part of the mean curvature that keeps weights of methods that say the same from growing.
const RIDGE: f64 = 1e-3;

/// Weights per horizon: of the root's displacement, and of the others' relative to it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mixture(Vec<[[f64; EXPERTS]; 2]>);

/// Sums that weights are solved from, per horizon and part.
#[derive(Debug, Clone)]
pub(super) struct Sums(Vec<[(SMatrix<f64, EXPERTS, EXPERTS>, SVector<f64, EXPERTS>); 2]>);

impl Sums {
    pub(super) fn new(horizons: usize) -> Self {
        Self(vec![[(SMatrix::zeros(), SVector::zeros()); 2]; horizons])
    }

    /// Adds what the methods said of one moment over one horizon, and what came true.
    ///
    /// - `root`: its place among the joints.
    pub(super) fn add(
        &mut self,
        horizon: usize,
        root: usize,
        said: [&[f64]; EXPERTS],
        truth: &[f64],
    ) {
        for joint in 0..truth.len() / 3 {
            let part = usize::from(joint != root);
            let (curvature, slope) = &mut self.0[horizon][part];
            for axis in 0..3 {
                let of = |d: &[f64]| relative(d, joint, root, axis);
                let says = SVector::from(said.map(of));
                *curvature += says * says.transpose();
                *slope += says * of(truth);
            }
        }
    }

    /// The weights that would have been best; those of `otherwise` where nothing was added.
    pub(super) fn solve(&self, otherwise: [f64; EXPERTS]) -> Mixture {
        let weights = self.0.iter().map(|parts| {
            parts.each_ref().map(|(curvature, slope)| {
                let ridge = RIDGE * curvature.trace() / EXPERTS as f64;
                let regular = curvature + SMatrix::identity() * ridge;
                regular.cholesky().map_or(otherwise, |factor| factor.solve(slope).into())
            })
        });
        Mixture(weights.collect())
    }
}

impl Mixture {
    /// Mixes what the methods say over one horizon; overwritten.
    pub(super) fn mix(
        &self,
        horizon: usize,
        root: usize,
        said: [&[f64]; EXPERTS],
        displacement: &mut [f64],
    ) {
        let [of_root, of_others] = &self.0[horizon];
        let sum = |weights: &[f64; EXPERTS], joint: usize, axis: usize| -> f64 {
            let each = weights.iter().zip(said);
            each.map(|(weight, d)| weight * relative(d, joint, root, axis)).sum()
        };
        for axis in 0..3 {
            let root_moves = sum(of_root, root, axis);
            for joint in 0..displacement.len() / 3 {
                displacement[3 * joint + axis] = if joint == root {
                    root_moves
                } else {
                    root_moves + sum(of_others, joint, axis)
                };
            }
        }
    }
}

/// The root's displacement, or another joint's relative to it.
fn relative(displacement: &[f64], joint: usize, root: usize, axis: usize) -> f64 {
    let own = displacement[3 * joint + axis];
    if joint == root { own } else { own - displacement[3 * root + axis] }
}
