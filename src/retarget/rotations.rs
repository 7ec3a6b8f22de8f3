//! The local step of `local_global`: each neighbourhood's best rotation, from the last one.
//!
//! `R = argmax tr(Rᵀ C)`, `C = Σⱼ w̄ⱼ e'ⱼ eⱼᵀ + ε Σⱼ w̄ⱼ‖eⱼ‖² R_before` (Sorkine & Alexa 2007, eq. 5,
//! with the memory of DESIGN 4.2, which keeps flat neighbourhoods' rotations unique and the energy
//! falling).

use nalgebra::{Matrix3, Rotation3};

use crate::geometry::{Vector, closest_rotation};

/// Newton steps before the singular value decomposition decides.
const NEWTON_STEPS: usize = 6;

/// A turn smaller than this `[rad]` ends the iteration: its square is below rounding.
const SETTLED: f64 = 1e-9;

/// The rotation closest to `covariance`, found from `before`.
///
/// Newton on the rotation group: with `M = Rᵀ C`, the gradient of `tr(Rᵀ C)` along a turn `ω` is
/// the axial vector of `M − Mᵀ` and the negative Hessian `tr(S) I − S`, `S` the symmetric part.
/// Where that is positive definite at rest the maximum is the only one; in any other case the
/// decomposition decides. Some ten times faster than decomposing always.
pub(super) fn best_rotation(covariance: &Matrix3<f64>, before: &Matrix3<f64>) -> Matrix3<f64> {
    let mut rotation = *before;
    for _ in 0..NEWTON_STEPS {
        let m = rotation.transpose() * covariance;
        let axial = Vector::new(m.m32 - m.m23, m.m13 - m.m31, m.m21 - m.m12);
        let hessian = Matrix3::identity() * m.trace() - 0.5 * (m + m.transpose());
        let Some(cholesky) = hessian.cholesky() else {
            return closest_rotation(covariance);
        };
        let turn = cholesky.solve(&axial);
        rotation *= Rotation3::new(turn).matrix();
        if turn.norm() < SETTLED {
            return rotation;
        }
    }
    closest_rotation(covariance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_the_decomposition(
            entries in prop::array::uniform9(-1.0f64..1.0),
            start in prop::array::uniform3(-3.0f64..3.0),
        ) {
            let before = *Rotation3::new(Vector::from(start)).matrix();
            let covariance = Matrix3::from_row_slice(&entries) + 0.1 * before;
            let singular = covariance.svd(false, false).singular_values;
            // Near a tie of the two smallest with a mirror in it the maximiser is not unique.
            prop_assume!(singular[1] + covariance.determinant().signum() * singular[2] > 1e-3);
            let expected = closest_rotation(&covariance);
            let found = best_rotation(&covariance, &before);
            prop_assert!((found - expected).amax() < 1e-9, "{found} {expected}");
            prop_assert!((found.transpose() * found - Matrix3::identity()).amax() < 1e-12);
        }
    }
}
