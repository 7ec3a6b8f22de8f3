//! Many best rotations at once, from earlier ones: of the neighbourhoods that `local_global` turns,
//! of the tetrahedra that are blended.
//!
//! `R = argmax tr(Rᵀ C)`. With `R` the turn of a unit quaternion `q` this is `argmax qᵀ K q`, `K`
//! a symmetric 4×4 matrix linear in `C` (Davenport 1968; Horn 1987), so `q` is the eigenvector of
//! its largest eigenvalue. Found by Rayleigh quotient iteration, whose error is cubed by every
//! step (Parlett 1980, 4.7).
//!
//! Written for one rotation and compiled for a register full: lanes never look at each other. As
//! quaternions they stay rotations to rounding, however often they are turned.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

use crate::geometry::closest_rotation;

/// Rotations found together: two registers of four, so that one's divisions overlap the other's
/// sums.
pub(crate) const LANES: usize = 8;

/// One number of each rotation.
pub(crate) type Lanes = [f64; LANES];

/// `w x y z` of unit quaternions.
pub(crate) type Quaternions = [Lanes; 4];

/// Matrices, row by row.
pub(crate) type Matrices = [[Lanes; 3]; 3];

/// No turn at all.
pub(crate) const IDENTITIES: Quaternions = [[1.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]];

/// Steps before the singular value decomposition decides.
const STEPS: usize = 6;

/// A step of less than this (the tangent of half its angle) is the last: its cube is below rounding.
const SETTLED: f64 = 1e-5;

/// The rotations closest to `covariances`, found from those in `rotations`; allocates nothing.
///
/// Where the iteration does not settle on the largest eigenvalue, the decomposition decides.
#[inline(always)]
pub(crate) fn best_rotations(covariances: &Matrices, rotations: &mut Quaternions) {
    let mut settled = [0.0; LANES];
    for _ in 0..STEPS {
        for lane in 0..LANES {
            let covariance = lane_of_matrices(covariances, lane);
            let (next, is_settled) = step(&covariance, lane_of(rotations, lane));
            for part in 0..4 {
                rotations[part][lane] = next[part];
            }
            settled[lane] = is_settled;
        }
        if settled == [1.0; LANES] {
            return;
        }
    }
    for lane in (0..LANES).filter(|lane| settled[*lane] != 1.0) {
        let covariance = lane_of_matrices(covariances, lane);
        let found = decomposed(&covariance);
        for part in 0..4 {
            rotations[part][lane] = found[part];
        }
    }
}

/// The rotation closest to one covariance, by singular value decomposition.
#[cold]
#[inline(never)]
fn decomposed(covariance: &[[f64; 3]; 3]) -> [f64; 4] {
    let rotation = closest_rotation(&Matrix3::from_fn(|i, j| covariance[i][j]));
    let rotation = Rotation3::from_matrix_unchecked(rotation);
    let rotation = UnitQuaternion::from_rotation_matrix(&rotation);
    [rotation.w, rotation.i, rotation.j, rotation.k]
}

/// One step of Rayleigh quotient iteration, and 1 if it was the last, otherwise 0.
///
/// Seen from `q`, with `M = Rᵀ C`, the quotient is `tr M`, its gradient the axial vector `z` of
/// `M − Mᵀ`, and `G = 2 tr M I − M − Mᵀ` how far `K` stays below it in the other three directions:
/// the step is `q (1, G⁻¹ z)`. (It is also Newton's on the rotation group by the Cayley map.)
/// Where `G` is positive definite only one eigenvalue is above the quotient, by interlacing; so a
/// short step from there ends at the maximum.
#[inline(always)]
fn step(covariance: &[[f64; 3]; 3], q: [f64; 4]) -> ([f64; 4], f64) {
    let r = matrix(q);
    let m = |i: usize, j: usize| {
        let (r, c) = (&r, covariance);
        r[2][i].mul_add(c[2][j], r[1][i].mul_add(c[1][j], r[0][i] * c[0][j]))
    };
    let [m11, m12, m13] = [m(0, 0), m(0, 1), m(0, 2)];
    let [m21, m22, m23] = [m(1, 0), m(1, 1), m(1, 2)];
    let [m31, m32, m33] = [m(2, 0), m(2, 1), m(2, 2)];
    let [z1, z2, z3] = [m32 - m23, m13 - m31, m21 - m12];
    let [g11, g22, g33] = [2.0 * (m22 + m33), 2.0 * (m11 + m33), 2.0 * (m11 + m22)];
    let [g12, g13, g23] = [-(m12 + m21), -(m13 + m31), -(m23 + m32)];
    // The adjugate, so that one normalisation is the only division.
    let a11 = g22.mul_add(g33, -(g23 * g23));
    let a12 = g13.mul_add(g23, -(g12 * g33));
    let a13 = g12.mul_add(g23, -(g13 * g22));
    let a22 = g11.mul_add(g33, -(g13 * g13));
    let a23 = g12.mul_add(g13, -(g11 * g23));
    let a33 = g11.mul_add(g22, -(g12 * g12));
    let s = g11.mul_add(a11, g12.mul_add(a12, g13 * a13));
    let x = a11.mul_add(z1, a12.mul_add(z2, a13 * z3));
    let y = a12.mul_add(z1, a22.mul_add(z2, a23 * z3));
    let z = a13.mul_add(z1, a23.mul_add(z2, a33 * z3));
    let turn = x.mul_add(x, y.mul_add(y, z * z));
    // Leading minors; written as numbers, and with `&`, so that lanes take no branches.
    let definite = (g11 > 0.0) & (a33 > 0.0) & (s > 0.0);
    let is_settled = definite & (turn <= SETTLED * SETTLED * s * s);
    // The product q (s, x, y, z), brought back to unit length.
    let [a, b, c, d] = q;
    let next = [
        a.mul_add(s, -b.mul_add(x, c.mul_add(y, d * z))),
        a.mul_add(x, b.mul_add(s, c.mul_add(z, -(d * y)))),
        a.mul_add(y, c.mul_add(s, d.mul_add(x, -(b * z)))),
        a.mul_add(z, d.mul_add(s, b.mul_add(y, -(c * x)))),
    ];
    let squared = s.mul_add(s, turn);
    let scale = 1.0 / squared.sqrt();
    (next.map(|part| part * scale), f64::from(u8::from(is_settled)))
}

/// The rotation matrix of a unit quaternion.
#[inline(always)]
pub(crate) fn matrix([w, x, y, z]: [f64; 4]) -> [[f64; 3]; 3] {
    let [x2, y2, z2] = [x + x, y + y, z + z];
    let [wx, wy, wz] = [w * x2, w * y2, w * z2];
    let [xx, xy, xz] = [x * x2, x * y2, x * z2];
    let [yy, yz, zz] = [y * y2, y * z2, z * z2];
    [
        [1.0 - (yy + zz), xy - wz, xz + wy],
        [xy + wz, 1.0 - (xx + zz), yz - wx],
        [xz - wy, yz + wx, 1.0 - (xx + yy)],
    ]
}

/// One rotation's quaternion.
#[inline(always)]
pub(crate) fn lane_of(quaternions: &Quaternions, lane: usize) -> [f64; 4] {
    [quaternions[0][lane], quaternions[1][lane], quaternions[2][lane], quaternions[3][lane]]
}

#[inline(always)]
fn lane_of_matrices(matrices: &Matrices, lane: usize) -> [[f64; 3]; 3] {
    let row = |i: usize| [matrices[i][0][lane], matrices[i][1][lane], matrices[i][2][lane]];
    [row(0), row(1), row(2)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use proptest::prelude::*;

    /// One rotation, in every lane.
    fn best_rotation(covariance: &Matrix3<f64>, before: &Matrix3<f64>) -> Matrix3<f64> {
        let before = UnitQuaternion::from_matrix(before);
        let mut rotations = [before.w, before.i, before.j, before.k].map(|part| [part; LANES]);
        let covariances: Matrices =
            [0, 1, 2].map(|i| [0, 1, 2].map(|j| [covariance[(i, j)]; LANES]));
        best_rotations(&covariances, &mut rotations);
        let found = matrix(lane_of(&rotations, LANES - 1));
        Matrix3::from_fn(|i, j| found[i][j])
    }

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
