//! Tetrahedra with their neighbours and the float filter of the sphere test.
//!
//! With each point lifted to `p̂ = (x, y, z, ‖p‖²)`, `p` is inside the sphere of `abcd` exactly if
//! `p̂` is below the hyperplane through `â b̂ ĉ d̂`. The hyperplane is computed once per tetrahedron;
//! a test is then five products. The vertex at infinity is the direction `(0, 0, 0, 1)`: with it
//! the hyperplane is vertical and the test asks for the side of the hull's face.

/// A point about the middle of the points' box, and its squared distance from there.
pub(super) type Lifted = [f64; 4];

/// A tetrahedron, finite or with one vertex at infinity.
///
/// Positively oriented; with infinity replaced by any point strictly beyond the hull's face, too.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) vertices: [u32; 4],
    /// Across the facet opposite each vertex: `4 · cell + facet as that cell numbers it`.
    pub(super) neighbours: [u32; 4],
    /// `[nx, ny, nz, nw, n₀]`: `n·p̂ + n₀ > 0` where `p` is in conflict, up to rounding.
    pub(super) plane: [f64; 5],
    /// `2 · round + 1` where found in conflict in that round, `2 · round` where found not to be.
    pub(super) mark: u32,
}

/// In place of vertices: the cell is free.
pub(super) const FREE: [u32; 4] = [u32::MAX; 4];

/// The vertices other than the i-th, so ordered that `i` and they are an even permutation.
pub(super) const FACET: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// The facet opposite each vertex, positively oriented with that vertex before it.
#[inline(always)]
pub(super) fn facets([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 4] {
    [[b, c, d], [a, d, c], [a, b, d], [a, c, b]]
}

/// Bounds on rounding errors, from the sizes `X Y Z` of the centred coordinates and
/// `W = X² + Y² + Z²`; beyond them a sign needs no exact arithmetic.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bounds {
    /// Of `n·p̂ + n₀`.
    pub(super) sphere: f64,
    /// Of `det(a − p, b − p, c − p)`.
    pub(super) solid: f64,
    /// `W`, the length given to the direction of infinity.
    pub(super) height: f64,
}

impl Bounds {
    /// The bounds for coordinates of at most these sizes.
    ///
    /// With `u = 2⁻⁵³`: a difference of centred coordinates is off by at most `2u` of its bound
    /// `2X`, one of squared distances by `11u` of `W`. A component of `n` is a sum of six products
    /// of three, at most `24 YZW` (or `48 XYZ`), off by at most `(2 + 2 + 11 + 5)u` of it. `n·p̂`
    /// and `n₀` together sum terms of at most `240 XYZW`, with 5 roundings of `p̂` and 6 of products
    /// and sums on top: `240 · 31u < 2¹³u`. In the same way `48 · 11u < 2¹⁰u` for the determinant.
    pub(super) fn new([x, y, z]: [f64; 3]) -> Bounds {
        const U: f64 = f64::EPSILON / 2.0;
        let height = x * x + y * y + z * z;
        let (solid, sphere) = (x * y * z, x * y * z * height);
        // NOTE: where the bound itself would lose digits below the normal numbers, all is exact.
        let or_never = |bound: f64, size: f64| if size > 1e-280 { bound } else { f64::INFINITY };
        Bounds {
            sphere: or_never(8192.0 * U * sphere, sphere),
            solid: or_never(1024.0 * U * solid, solid),
            height,
        }
    }
}

/// The hyperplane through the lifted `q`, `a`, `b`, `c` of a positively oriented tetrahedron.
///
/// `n·r = −det(â − q̂, b̂ − q̂, ĉ − q̂, r)`, expanded by the minors of its first two rows.
#[inline(always)]
pub(super) fn plane(q: &Lifted, a: &Lifted, b: &Lifted, c: &Lifted) -> [f64; 5] {
    let minus = |p: &Lifted| [p[0] - q[0], p[1] - q[1], p[2] - q[2], p[3] - q[3]];
    let (a, b, c) = (minus(a), minus(b), minus(c));
    let minor = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
    let (xy, xz, xw) = (minor(0, 1), minor(0, 2), minor(0, 3));
    let (yz, yw, zw) = (minor(1, 2), minor(1, 3), minor(2, 3));
    let nx = c[1] * zw - c[2] * yw + c[3] * yz;
    let ny = c[2] * xw - c[0] * zw - c[3] * xz;
    let nz = c[0] * yw - c[1] * xw + c[3] * xy;
    let nw = c[1] * xz - c[0] * yz - c[2] * xy;
    [nx, ny, nz, nw, -(nx * q[0] + ny * q[1] + nz * q[2] + nw * q[3])]
}

/// The direction of infinity as a point above `q`, so that [`plane`] needs no special case.
#[inline(always)]
pub(super) fn above(q: &Lifted, bounds: &Bounds) -> Lifted {
    [q[0], q[1], q[2], q[3] + bounds.height]
}
