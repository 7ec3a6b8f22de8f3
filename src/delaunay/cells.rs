//! Simplices with their neighbours and the float filter of the sphere test.
//!
//! With each point lifted to `p̂ = (p, ‖p‖²)`, `p` is inside the sphere of `abc…` exactly if `p̂` is
//! below the hyperplane through `â b̂ ĉ …`. The hyperplane is computed once per simplex; a test is
//! then a product for each of its numbers. The vertex at infinity is the direction `(0, …, 0, 1)`:
//! with it the hyperplane is vertical and the test asks for the side of the hull's facet.

use super::dimension::{Dimension, Lifted};
use super::triangulation::Triangulation;

/// A simplex, finite or with one vertex at infinity.
///
/// Positively oriented; with infinity replaced by any point strictly beyond the hull's facet, too.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<const N: usize> {
    pub(super) vertices: [u32; N],
    /// What is across the facet opposite each vertex.
    pub(super) neighbours: [Side<N>; N],
    pub(super) plane: Plane<N>,
    /// `2 · round + 1` where found in conflict in that round, `2 · round` where found not to be.
    pub(super) mark: u32,
}

/// In place of a vertex: the cell is free.
pub(super) const FREE: u32 = u32::MAX;

/// A facet of a cell, as the cell on this side of it numbers it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Side<const N: usize>(u32);

impl<const N: usize> Side<N> {
    const BITS: u32 = (N - 1).ilog2() + 1;

    #[inline(always)]
    pub(super) fn new(cell: u32, facet: usize) -> Side<N> {
        Side((cell << Self::BITS) + facet as u32)
    }

    #[inline(always)]
    pub(super) fn cell(self) -> u32 {
        self.0 >> Self::BITS
    }

    #[inline(always)]
    pub(super) fn facet(self) -> usize {
        (self.0 & ((1 << Self::BITS) - 1)) as usize
    }
}

impl<const D: usize, const N: usize> Triangulation<D, N> {
    /// The vertices other than the i-th, so ordered that `i` and they are an even permutation.
    pub(super) const FACETS: [[usize; D]; N] = {
        let mut facets = [[0; D]; N];
        let mut i = 0;
        while i < N {
            let mut place = 0;
            while place < D {
                facets[i][place] = place + (place >= i) as usize;
                place += 1;
            }
            // To bring `i` to the front takes as many exchanges.
            if i % 2 == 1 {
                (facets[i][D - 2], facets[i][D - 1]) = (facets[i][D - 1], facets[i][D - 2]);
            }
            i += 1;
        }
        facets
    };

    /// The facet opposite each vertex, positively oriented with that vertex before it.
    #[inline(always)]
    pub(super) fn facets(vertices: [u32; N]) -> [[u32; D]; N] {
        let mut facets = [[0; D]; N];
        for i in 0..N {
            for place in 0..D {
                facets[i][place] = vertices[Self::FACETS[i][place]];
            }
        }
        facets
    }
}

/// `n·p̂ + n₀`, up to rounding positive where `p` is in conflict.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane<const N: usize> {
    normal: [f64; N],
    offset: f64,
}

impl<const N: usize> Plane<N> {
    /// The hyperplane through the lifted corners of a positively oriented simplex.
    #[inline(always)]
    pub(super) fn through<const D: usize>(simplex: [&Lifted<N>; N]) -> Plane<N>
    where
        Triangulation<D, N>: Dimension<D, N>,
    {
        let normal = Triangulation::<D, N>::normal(simplex);
        Plane { normal, offset: -dot(&normal, simplex[0]) }
    }

    #[inline(always)]
    pub(super) fn value(&self, p: &Lifted<N>) -> f64 {
        dot(&self.normal, p) + self.offset
    }
}

#[inline(always)]
fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    (1..N).fold(a[0] * b[0], |sum, i| sum + a[i] * b[i])
}

/// Bounds on rounding errors, beyond which a sign needs no exact arithmetic.
///
/// They follow from the sizes `X Y Z …` of the centred coordinates and `W = X² + Y² + Z² + …`.
/// With `u = 2⁻⁵³`, a difference of centred coordinates is off by at most `2u` of its bound `2X`,
/// one of squared distances by `11u` of `W` in three dimensions and by `13u` in four.
///
/// Three: a component of `n` is a sum of six products of three, at most `24 YZW` (or `48 XYZ`), off
/// by at most `(2 + 2 + 11 + 5)u` of it. `n·p̂` and `n₀` together sum terms of at most `240 XYZW`,
/// with 5 roundings of `p̂` and 6 of products and sums on top: `240 · 31u < 2¹³u`. In the same way
/// `48 · 11u < 2¹⁰u` for the determinant.
///
/// Four: a component of `n` is a sum of 24 products of four, at most `192 YZVW` (or `384 XYZV`), off
/// by at most `(2 + 2 + 2 + 13 + 10)u` of it: two roundings in each minor of two rows, one in their
/// product, five in the sum. `n·p̂` and `n₀` together sum terms of at most `2304 XYZVW`, with 6
/// roundings of `p̂` and 7 of products and sums on top: `2304 · 42u < 2¹⁷u`. In the same way
/// `384 · 18u < 2¹³u` for the determinant.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bounds {
    /// Of `n·p̂ + n₀`.
    pub(super) sphere: f64,
    /// Of the determinant that is a simplex' orientation.
    pub(super) solid: f64,
    /// `W`, the length given to the direction of infinity.
    pub(super) height: f64,
}

impl Bounds {
    /// The bounds for centred coordinates of at most these sizes.
    pub(super) fn new<const D: usize, const N: usize>(size: [f64; D]) -> Bounds
    where
        Triangulation<D, N>: Dimension<D, N>,
    {
        const U: f64 = f64::EPSILON / 2.0;
        let height = size.iter().map(|x| x * x).sum();
        let solid: f64 = size.iter().product();
        let sphere = solid * height;
        // NOTE: where the bound itself would lose digits below the normal numbers, all is exact.
        let or_never = |bound: f64, size: f64| if size > 1e-280 { bound } else { f64::INFINITY };
        Bounds {
            sphere: or_never(Triangulation::<D, N>::SPHERE * U * sphere, sphere),
            solid: or_never(Triangulation::<D, N>::SOLID * U * solid, solid),
            height,
        }
    }

    /// The direction of infinity as a point above `q`, so that [`Plane::through`] needs no special
    /// case.
    #[inline(always)]
    pub(super) fn above<const N: usize>(&self, q: &Lifted<N>) -> Lifted<N> {
        let mut point = *q;
        point[N - 1] += self.height;
        point
    }
}
