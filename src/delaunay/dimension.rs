//! What depends on the number of axes: determinants, rounded and exact, and what rounding costs.

/// A point about the middle of the points' box, and its squared distance from there.
pub(super) type Lifted<const N: usize> = [f64; N];

/// `p` about `middle` with the square of its distance from there; the largest coordinates so far
/// are kept in `size`.
#[inline(always)]
pub(super) fn lifted<const D: usize, const N: usize>(
    p: &[f64; D],
    middle: &[f64; D],
    size: &mut [f64; D],
) -> Lifted<N> {
    let mut lifted = [0.0; N];
    for axis in 0..D {
        let centred = p[axis] - middle[axis];
        size[axis] = size[axis].max(centred.abs());
        lifted[axis] = centred;
        lifted[D] += centred * centred;
    }
    lifted
}

/// Simplices of `N = D + 1` corners in `D` dimensions.
///
/// A simplex is positively oriented if the determinant of its corners less its first one, in their
/// order, is positive.
pub(super) trait Dimension<const D: usize, const N: usize> {
    /// The rounding error of [`Self::determinant`] is at most this many `u = 2⁻⁵³` times the
    /// product of the axes' sizes.
    const SOLID: f64;
    /// That of a test by [`Self::normal`], times the product of the axes' sizes and the height;
    /// see [`super::cells::Bounds`].
    const SPHERE: f64;

    /// The exact sign of a simplex' orientation.
    fn orientation(simplex: [&[f64; D]; N]) -> f64;

    /// Positive if `p` is strictly inside the circumsphere of the positively oriented `simplex`,
    /// negative if strictly outside, zero on it. Exact.
    fn in_sphere(simplex: [&[f64; D]; N], p: &[f64; D]) -> f64;

    /// Whether `p` is outside the point, line, plane … that `corners` span; they are as few as
    /// span it. Exact.
    fn independent(corners: &[&[f64; D]], p: &[f64; D]) -> bool;

    /// The rounded determinant of a simplex' orientation.
    fn determinant(simplex: [&Lifted<N>; N]) -> f64;

    /// A normal of the hyperplane through the lifted corners of a positively oriented simplex,
    /// pointing to smaller squared distances: `n·r = −det(b̂ − â, ĉ − â, …, r)`.
    fn normal(simplex: [&Lifted<N>; N]) -> Lifted<N>;
}
