//! How much each method's say counts: least squares on recordings that none of them learned from.
//!
//! Over horizon `h` the displacement is `Σₘ aₘₕ rₘ` for the root and `Σₘ bₘₕ (dₘ − rₘ)` for the
//! other joints relative to it, with `rₘ` the root's and `dₘ` a joint's displacement by method `m`
//! (stacked regression, Breiman 1996).

use nalgebra::{SMatrix, SVector};

/// How many methods are mixed.
pub(super) const EXPERTS: usize = 4;

/// Part of what came true, squared and summed, that draws each weight towards [`EQUAL`], and so
/// keeps those of methods that say the same from growing. A method that is far off is not drawn back
/// by it, as its own errors are larger.
const RIDGE: f64 = 1e-3;

/// The same per group that was heard, in addition: what two recordings say of a method may be chance.
const DOUBT: f64 = 0.3;

/// Constant velocity says nothing, the three that learn as much as each other.
const EQUAL: [f64; EXPERTS] = [0.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0];

/// Weights per horizon: of the root's displacement, and of the others' relative to it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mixture(Vec<[[f64; EXPERTS]; 2]>);

/// Sums that weights are solved from, per horizon and part.
#[derive(Debug, Clone)]
pub(super) struct Sums(Vec<[Sum; 2]>);

/// Over all joints and axes: what was said, what was said beside what came true, and that alone.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    curvature: SMatrix<f64, EXPERTS, EXPERTS>,
    slope: SVector<f64, EXPERTS>,
    energy: f64,
}

impl Sums {
    pub(super) fn new(horizons: usize) -> Self {
        Self(vec![[Sum::default(); 2]; horizons])
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
            let sum = &mut self.0[horizon][part];
            for axis in 0..3 {
                let of = |d: &[f64]| relative(d, joint, root, axis);
                let says = SVector::from(said.map(of));
                sum.curvature += says * says.transpose();
                sum.slope += says * of(truth);
                sum.energy += of(truth) * of(truth);
            }
        }
    }

    /// Adds what was summed apart.
    pub(super) fn merge(&mut self, other: &Self) {
        for (own, other) in self.0.as_mut_slice().iter_mut().flatten().zip(other.0.iter().flatten())
        {
            own.curvature += other.curvature;
            own.slope += other.slope;
            own.energy += other.energy;
        }
    }

    /// The weights that would have been best, the fewer groups were heard the nearer to equal ones;
    /// those of `otherwise` where nothing was added.
    pub(super) fn solve(&self, groups: usize, otherwise: [f64; EXPERTS]) -> Mixture {
        let doubt = RIDGE + DOUBT / groups.max(1) as f64;
        let weights = self.0.iter().map(|parts| {
            parts.each_ref().map(|sum| {
                let Sum { mut curvature, mut slope, energy } = *sum;
                if curvature.trace() == 0.0 {
                    return otherwise;
                }
                for method in 0..EXPERTS {
                    let own = &mut curvature[(method, method)];
                    if *own > 0.0 {
                        *own += doubt * energy;
                        slope[method] += doubt * energy * EQUAL[method];
                    } else {
                        // Who says that nothing moves weighs nothing.
                        *own = 1.0;
                    }
                }
                curvature.cholesky().map_or(otherwise, |factor| factor.solve(&slope).into())
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

#[cfg(test)]
mod tests {
    use rand::{Rng as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    const OTHERWISE: [f64; EXPERTS] = [0.25; EXPERTS];
    const ROOT: usize = 1;

    /// What four methods say of three joints, each of its own size, and the truth: a sum of them
    /// by weights of the root and of the others.
    fn said(
        random: &mut ChaCha8Rng,
        sizes: [f64; EXPERTS],
        weights: [[f64; EXPERTS]; 2],
    ) -> ([Vec<f64>; EXPERTS], Vec<f64>) {
        let said = sizes.map(|size| {
            (0..9).map(|_| size * random.random_range(-1.0..1.0)).collect::<Vec<f64>>()
        });
        let mut truth = vec![0.0; 9];
        Mixture(vec![weights]).mix(0, ROOT, said.each_ref().map(Vec::as_slice), &mut truth);
        (said, truth)
    }

    /// The weights learned over the second of two horizons.
    fn learned(sizes: [f64; EXPERTS], weights: [[f64; EXPERTS]; 2]) -> [[f64; EXPERTS]; 2] {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut sums = Sums::new(2);
        for _ in 0..400 {
            let (said, truth) = said(&mut random, sizes, weights);
            sums.add(1, ROOT, said.each_ref().map(Vec::as_slice), &truth);
        }
        let Mixture(found) = sums.solve(1_000_000, OTHERWISE);
        assert_eq!(found[0], [OTHERWISE; 2], "nothing is known of the first");
        found[1]
    }

    #[track_caller]
    fn check_found(sizes: [f64; EXPERTS], weights: [[f64; EXPERTS]; 2]) {
        let found = learned(sizes, weights);
        let most: f64 =
            sizes.into_iter().zip(weights.concat().iter().cycle()).map(|(s, w)| s * w).sum();
        for (found, weights) in found.iter().zip(&weights) {
            for ((found, weight), size) in found.iter().zip(weights).zip(sizes) {
                assert!((found - weight).abs() * size < 0.01 * most, "{found} for {weight}");
            }
        }
    }

    #[test]
    fn the_weights_that_were_mixed_by_are_found() {
        check_found([1.0; 4], [[0.1, 0.2, 0.3, 0.4], [0.7, 0.0, -0.2, 0.5]]);
    }

    #[test]
    fn who_is_right_is_believed_whatever_the_others_sizes() {
        for right in 0..EXPERTS {
            let mut weights = [0.0; EXPERTS];
            weights[right] = 1.0;
            check_found([1.0; 4], [weights; 2]);
            let mut sizes = [1e3, 1e-3, 1e6, 0.0];
            sizes[right] = 1.0;
            let found = learned(sizes, [weights; 2]);
            for (method, weight) in found.as_flattened().iter().enumerate() {
                let (method, sure) = (method % EXPERTS, (weight - 1.0).abs() < 0.01);
                assert_eq!(sure, method == right, "{found:?}");
            }
        }
    }

    #[test]
    fn who_says_the_same_shares_and_who_says_nothing_weighs_nothing() {
        let mut sums = Sums::new(1);
        let (one, nothing) = ([1.0, 2.0, 3.0, -2.0, 0.5, 0.1, 3.0, 1.0, -1.0], [0.0; 9]);
        sums.add(0, ROOT, [&one, &nothing, &one, &nothing], &one);
        for [a, b, c, d] in sums.solve(1_000_000, OTHERWISE).0[0] {
            // Between them as much as is true; the one that learns is trusted by a third more.
            assert!((a + c - 1.0).abs() < 1e-3 && (c - a - EQUAL[2]).abs() < 1e-3, "{a}, {c}");
            assert_eq!([b, d], [0.0; 2]);
        }
        // Where nothing moves and all say so, nothing is known of any.
        let mut still = Sums::new(1);
        still.add(0, ROOT, [&nothing; EXPERTS], &nothing);
        assert_eq!(still.solve(1_000_000, OTHERWISE).0[0], [OTHERWISE; 2]);
    }

    #[test]
    fn few_groups_are_believed_less_and_a_method_far_off_never() {
        let mut sums = Sums::new(1);
        let truth = [1.0, 2.0, 3.0, -2.0, 0.5, 0.1, 3.0, 1.0, -1.0];
        // One is right; the others say something else, the last far too much of it.
        let other = [0.5, -1.0, 2.0, 0.1, 3.0, -1.0, 0.3, 0.2, 1.0];
        let wild = [3.0, 1.0, -2.0, 0.4, 1.0, 2.0, -0.7, 0.9, 0.6].map(|d: f64| 1e4 * d);
        sums.add(0, ROOT, [&other, &truth, &[0.0; 9], &wild], &truth);
        for part in 0..2 {
            let ridge = |groups| sums.solve(groups, OTHERWISE).0[0][part][1];
            assert!(ridge(1) < ridge(3) && ridge(3) < ridge(30) && ridge(30) < 1.0);
            assert!(sums.solve(1, OTHERWISE).0[0][part][3].abs() < 1e-4);
        }
    }

    #[test]
    fn numbers_too_large_to_be_squared_are_not_learned_from() {
        let mut sums = Sums::new(1);
        sums.add(0, ROOT, [&[1e300; 9]; EXPERTS], &[1e300; 9]);
        assert!(
            sums.solve(1_000_000, OTHERWISE).0[0]
                .as_flattened()
                .iter()
                .all(|weight| weight.is_finite())
        );
    }
}
