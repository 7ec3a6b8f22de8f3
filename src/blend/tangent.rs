//! Rotations and stretches ⇄ their logarithms, eight at a time.
//!
//! A map with a positive determinant is `A = R S`, `R` a rotation and `S` symmetric and positive
//! definite (polar decomposition). `log R` is a vector along the axis, as long as the angle;
//! `log S` is symmetric.
//!
//! Written for one and compiled for a register full, as [`crate::rotations`] is: lanes take no
//! branches. The decomposition of `S` is Jacobi's (Golub & Van Loan 2013, 8.5), accurate to rounding
//! however near its eigenvalues are to each other.

use crate::rotations::{LANES, Lanes, Matrices, Quaternions, lane_of};

/// Symmetric matrices: `xx yy zz yz xz xy`.
pub(super) type Symmetric = [Lanes; 6];

/// Sweeps of the decomposition at most: from the third on it converges quadratically.
const SWEEPS: usize = 6;

/// What is left beside the diagonal, squared, as a share of the diagonal's squares: rounding.
const SETTLED: f64 = 1e-32;

/// Terms of the exponential's series: the next is below rounding for matrices of norm ½.
const TERMS: usize = 14;

/// Terms of the sine and the cosine of angles below one half.
const HALF_TERMS: usize = 7;

/// `Rᵀ A`, made symmetric: the stretch of `A = R S`.
#[inline(always)]
pub(super) fn stretches(maps: &Matrices, rotations: &Matrices) -> Symmetric {
    let mut found = [[0.0; LANES]; 6];
    for (part, (i, j)) in ENTRIES.into_iter().enumerate() {
        for lane in 0..LANES {
            let mut sum = 0.0;
            for k in 0..3 {
                sum += rotations[k][i][lane] * maps[k][j][lane];
                sum += rotations[k][j][lane] * maps[k][i][lane];
            }
            found[part][lane] = 0.5 * sum;
        }
    }
    found
}

/// `log S` of positive definite `S`; where one is none, of the nearest with eigenvalues ≥ 1e-300.
#[inline(always)]
pub(super) fn log_symmetric(stretches: &Symmetric) -> Symmetric {
    let mut diagonal = [stretches[0], stretches[1], stretches[2]];
    let mut off = [stretches[3], stretches[4], stretches[5]];
    // Columns are eigenvectors in the end.
    let mut basis = [[[0.0; LANES]; 3]; 3];
    for axis in 0..3 {
        basis[axis][axis] = [1.0; LANES];
    }
    for _ in 0..SWEEPS {
        let mut is_left = 0.0;
        for lane in 0..LANES {
            let square = |of: &[Lanes; 3]| {
                of[0][lane] * of[0][lane] + of[1][lane] * of[1][lane] + of[2][lane] * of[2][lane]
            };
            let left = square(&off) > SETTLED * square(&diagonal);
            is_left += f64::from(u8::from(left));
        }
        if is_left == 0.0 {
            break;
        }
        // `off[k]` is the entry of the two axes that are not `k`.
        for k in 0..3 {
            let (p, q) = ((k + 1) % 3, (k + 2) % 3);
            for lane in 0..LANES {
                let apq = off[k][lane];
                let d = diagonal[q][lane] - diagonal[p][lane];
                // tan of the angle: the smaller root, written so that 0/0 is 0.
                let root = (d * d + 4.0 * apq * apq).sqrt();
                let t = 2.0 * apq * d.signum() / (d.abs() + root + f64::MIN_POSITIVE);
                let c = 1.0 / (1.0 + t * t).sqrt();
                let s = t * c;
                diagonal[p][lane] -= t * apq;
                diagonal[q][lane] += t * apq;
                off[k][lane] = 0.0;
                // The third axis' entries with p and q: `off[q]` joins k and p, `off[p]` k and q.
                let (kp, kq) = (off[q][lane], off[p][lane]);
                off[q][lane] = c * kp - s * kq;
                off[p][lane] = s * kp + c * kq;
                for row in 0..3 {
                    let (x, y) = (basis[row][p][lane], basis[row][q][lane]);
                    basis[row][p][lane] = c * x - s * y;
                    basis[row][q][lane] = s * x + c * y;
                }
            }
        }
    }
    for axis in 0..3 {
        for lane in 0..LANES {
            diagonal[axis][lane] = diagonal[axis][lane].max(1e-300).ln();
        }
    }
    let mut found = [[0.0; LANES]; 6];
    for (part, (i, j)) in ENTRIES.into_iter().enumerate() {
        for lane in 0..LANES {
            for k in 0..3 {
                found[part][lane] += basis[i][k][lane] * diagonal[k][lane] * basis[j][k][lane];
            }
        }
    }
    found
}

/// Where the numbers of a [`Symmetric`] stand in its matrix.
const ENTRIES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];

/// `exp X` of symmetric `X`.
///
/// `exp X = e^t exp(X − t I)`, `t = tr X / 3`. Of a matrix `Y` without trace every power is
/// `a I + b Y + c Y²`, for `Y³ = ½ tr(Y²) Y + det(Y) I` (Cayley & Hamilton): the series of
/// `exp(Y / 2ˢ)` and its `s` squarings are sums of three numbers.
#[inline(always)]
pub(super) fn exp_symmetric(x: &Symmetric) -> Symmetric {
    let mut y = *x;
    let (mut trace, mut p, mut q) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    let mut most = 0.0f64;
    for lane in 0..LANES {
        let t = (x[0][lane] + x[1][lane] + x[2][lane]) / 3.0;
        let (a, b, c) = (x[0][lane] - t, x[1][lane] - t, x[2][lane] - t);
        let (d, e, f) = (x[3][lane], x[4][lane], x[5][lane]);
        (y[0][lane], y[1][lane], y[2][lane]) = (a, b, c);
        trace[lane] = t;
        p[lane] = 0.5 * (a * a + b * b + c * c) + d * d + e * e + f * f;
        q[lane] = a * (b * c - d * d) - f * (f * c - d * e) + e * (f * d - b * e);
    }
    for lane in 0..LANES {
        most = most.max(p[lane]).max(0.5 * trace[lane] * trace[lane]);
    }
    // ‖Y‖ ≤ √(2p), brought below one half, and so is t.
    let mut halvings = 0;
    while most > 0.125 && halvings < 64 {
        most *= 0.25;
        halvings += 1;
    }
    let share = 0.5f64.powi(halvings);
    for lane in 0..LANES {
        p[lane] *= share * share;
        q[lane] *= share * share * share;
        trace[lane] *= share;
    }
    let (mut a, mut b, mut c) = ([1.0; LANES], [0.0; LANES], [0.0; LANES]);
    let mut scale = [1.0; LANES];
    // Horner: 1 + Y (1 + Y/2 (1 + Y/3 (…))).
    for term in (1..=TERMS).rev() {
        let inverse = 1.0 / term as f64;
        for lane in 0..LANES {
            let (a0, b0, c0) = (a[lane] * inverse, b[lane] * inverse, c[lane] * inverse);
            a[lane] = c0.mul_add(q[lane], 1.0);
            b[lane] = c0.mul_add(p[lane], a0);
            c[lane] = b0;
            scale[lane] = (scale[lane] * inverse).mul_add(trace[lane], 1.0);
        }
    }
    for _ in 0..halvings {
        for lane in 0..LANES {
            // (a + bY + cY²)², with Y³ = pY + q and Y⁴ = pY² + qY.
            let (a0, b0, c0, p, q) = (a[lane], b[lane], c[lane], p[lane], q[lane]);
            let (third, fourth) = (2.0 * b0 * c0, c0 * c0);
            a[lane] = a0 * a0 + third * q;
            b[lane] = 2.0 * a0 * b0 + third * p + fourth * q;
            c[lane] = 2.0 * a0 * c0 + b0 * b0 + fourth * p;
            scale[lane] *= scale[lane];
        }
    }
    let mut found = [[0.0; LANES]; 6];
    for lane in 0..LANES {
        let (xx, yy, zz) = (y[0][lane] * share, y[1][lane] * share, y[2][lane] * share);
        let (yz, xz, xy) = (y[3][lane] * share, y[4][lane] * share, y[5][lane] * share);
        let squares = [
            xx * xx + xy * xy + xz * xz,
            xy * xy + yy * yy + yz * yz,
            xz * xz + yz * yz + zz * zz,
            xy * xz + yy * yz + yz * zz,
            xx * xz + xy * yz + xz * zz,
            xx * xy + xy * yy + xz * yz,
        ];
        let firsts = [xx, yy, zz, yz, xz, xy];
        for part in 0..6 {
            let unit = if part < 3 { a[lane] } else { 0.0 };
            let value = unit + b[lane] * firsts[part] + c[lane] * squares[part];
            found[part][lane] = scale[lane] * value;
        }
    }
    found
}

/// The rotation by a vector: `[rad]`, along its axis.
#[inline(always)]
pub(super) fn exp_rotations(vectors: &[Lanes; 3]) -> Quaternions {
    let (mut square, mut most) = ([0.0; LANES], 0.0f64);
    for lane in 0..LANES {
        let [x, y, z] = [vectors[0][lane], vectors[1][lane], vectors[2][lane]];
        square[lane] = 0.25 * (x * x + y * y + z * z);
    }
    for lane in 0..LANES {
        most = most.max(square[lane]);
    }
    // Half the angle, brought below one half; each squaring doubles it again.
    let mut halvings = 0;
    while most > 0.25 && halvings < 64 {
        most *= 0.25;
        halvings += 1;
    }
    let share = 0.5f64.powi(halvings);
    // cos √h and sin √h / √h.
    let (mut cosine, mut sine) = ([1.0; LANES], [1.0; LANES]);
    for term in (1..=HALF_TERMS).rev() {
        let n = 2.0 * term as f64;
        let [of_cosine, of_sine] = [-1.0 / (n * (n - 1.0)), -1.0 / (n * (n + 1.0))];
        for lane in 0..LANES {
            let h = square[lane] * share * share;
            cosine[lane] = (cosine[lane] * of_cosine).mul_add(h, 1.0);
            sine[lane] = (sine[lane] * of_sine).mul_add(h, 1.0);
        }
    }
    let mut found = [cosine, [0.0; LANES], [0.0; LANES], [0.0; LANES]];
    for axis in 0..3 {
        for lane in 0..LANES {
            found[axis + 1][lane] = 0.5 * share * sine[lane] * vectors[axis][lane];
        }
    }
    for _ in 0..halvings {
        for lane in 0..LANES {
            let (w, x, y, z) = (found[0][lane], found[1][lane], found[2][lane], found[3][lane]);
            let twice = 2.0 * w;
            found[0][lane] = w * w - (x * x + y * y + z * z);
            found[1][lane] = twice * x;
            found[2][lane] = twice * y;
            found[3][lane] = twice * z;
        }
    }
    for lane in 0..LANES {
        let (w, x, y, z) = (found[0][lane], found[1][lane], found[2][lane], found[3][lane]);
        let length = 1.0 / (w * w + x * x + y * y + z * z).sqrt();
        for part in 0..4 {
            found[part][lane] *= length;
        }
    }
    found
}

/// The vector of a rotation, of length ≤ π `[rad]`.
pub(super) fn log_rotation(rotations: &Quaternions, lane: usize) -> [f64; 3] {
    let [w, x, y, z] = lane_of(rotations, lane);
    let sine = (x * x + y * y + z * z).sqrt();
    // A quaternion and its opposite are one rotation.
    let angle = 2.0 * sine.atan2(w.abs());
    let share = if sine > 1e-150 { angle / sine } else { 2.0 };
    [x, y, z].map(|along| share.copysign(w) * along)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use nalgebra::{Matrix3, Rotation3, SymmetricEigen};
    use proptest::prelude::*;

    fn symmetric(entries: [f64; 6]) -> Symmetric {
        entries.map(|entry| [entry; LANES])
    }

    fn matrix(symmetric: &Symmetric) -> Matrix3<f64> {
        let at = |part: usize| symmetric[part][LANES - 1];
        Matrix3::new(at(0), at(5), at(4), at(5), at(1), at(3), at(4), at(3), at(2))
    }

    fn by_eigenvalues(of: &Matrix3<f64>, function: fn(f64) -> f64) -> Matrix3<f64> {
        let eigen = SymmetricEigen::new(*of);
        let values = Matrix3::from_diagonal(&eigen.eigenvalues.map(function));
        eigen.eigenvectors * values * eigen.eigenvectors.transpose()
    }

    proptest! {
        #[test]
        fn the_exponential_is_that_of_the_eigenvalues(
            entries in prop::array::uniform6(-3.0f64..3.0), scale in 0.0f64..2.0,
        ) {
            let x = symmetric(entries.map(|entry| entry * scale));
            let expected = by_eigenvalues(&matrix(&x), f64::exp);
            let found = matrix(&exp_symmetric(&x));
            prop_assert!((found - expected).amax() <= 1e-12 * expected.amax());
        }

        #[test]
        fn the_logarithm_undoes_the_exponential(
            entries in prop::array::uniform6(-1.0f64..1.0), scale in 0.0f64..3.0,
        ) {
            let x = symmetric(entries.map(|entry| entry * scale));
            let found = log_symmetric(&exp_symmetric(&x));
            // What is small beside the greatest is known to its rounding only.
            let spread = (2.0 * matrix(&x).norm()).exp();
            prop_assert!((matrix(&found) - matrix(&x)).amax() <= 1e-14 * spread + 1e-13);
        }

        #[test]
        fn near_eigenvalues_are_no_trouble(
            entries in prop::array::uniform6(-1.0f64..1.0), exponent in -16.0f64..0.0,
        ) {
            let scale = 10f64.powf(exponent);
            let x = symmetric(entries.map(|entry| entry * scale));
            let found = log_symmetric(&exp_symmetric(&x));
            prop_assert!((matrix(&found) - matrix(&x)).amax() <= 3e-15);
        }

        #[test]
        fn vectors_of_rotations_go_there_and_back(vector in prop::array::uniform3(-1.8f64..1.8)) {
            let quaternions = exp_rotations(&vector.map(|along| [along; LANES]));
            let turned = crate::rotations::matrix(lane_of(&quaternions, 0));
            let expected = Rotation3::new(Vector::from(vector));
            for i in 0..3 {
                for j in 0..3 {
                    prop_assert!((turned[i][j] - expected[(i, j)]).abs() < 1e-14);
                }
            }
            let back = log_rotation(&quaternions, 3);
            for k in 0..3 {
                prop_assert!((back[k] - vector[k]).abs() < 1e-13);
            }
        }
    }
}
