//! Four dimensions. Exact signs: the same determinants in whole numbers.
//!
//! Doubles are dyadic, so six points times one power of two are integers, and differences and
//! determinants of those are exact: in 128 bits where the numbers are small, as on grids, and of
//! any size otherwise.

use super::cells::{Bounds, Plane};
use super::dimension::{Dimension, Lifted, lifted};
use super::triangulation::Triangulation;
use num_bigint::BigInt;
use std::array::from_fn;
use std::ops::{Add, Mul, Neg, Sub};

impl Dimension<4, 5> for Triangulation<4, 5> {
    const SOLID: f64 = 8192.0;
    const SPHERE: f64 = 131_072.0;

    #[cold]
    fn orientation(simplex: [&[f64; 4]; 5]) -> f64 {
        let mut size = [0.0; 4];
        let [q, r, s, t, u] = simplex.map(|p| lifted(p, simplex[0], &mut size));
        let value = <Self as Dimension<4, 5>>::determinant([&q, &r, &s, &t, &u]);
        if value.abs() > Bounds::new(size).solid {
            return value;
        }
        exact_orientation(simplex)
    }

    #[cold]
    fn in_sphere([a, b, c, d, e]: [&[f64; 4]; 5], p: &[f64; 4]) -> f64 {
        // Once more rounded, but about the first corner: sizes are the simplex' own there.
        let mut size = [0.0; 4];
        let [q, r, s, t, u, v] = [a, b, c, d, e, p].map(|p| lifted(p, a, &mut size));
        let value = Plane::through([&q, &r, &s, &t, &u]).value(&v);
        if value.abs() > Bounds::new(size).sphere {
            return value;
        }
        exact_in_sphere([a, b, c, d, e, p])
    }

    fn independent(corners: &[&[f64; 4]], p: &[f64; 4]) -> bool {
        let Some((first, others)) = corners.split_first() else { return true };
        let points: Vec<&[f64; 4]> =
            [*first, p].into_iter().chain(others.iter().copied()).collect();
        // The last one repeated, so that there are always five.
        let points: [&[f64; 4]; 5] = from_fn(|i| points[i.min(points.len() - 1)]);
        let [first, rows @ ..] = Dyadic::of(points).large();
        let rows = rows.map(|row| from_fn(|i| &row[i] - &first[i]));
        rank(rows) == corners.len()
    }

    #[inline(always)]
    fn determinant([q, a, b, c, d]: [&Lifted<5>; 5]) -> f64 {
        let minus = |p: &Lifted<5>| [p[0] - q[0], p[1] - q[1], p[2] - q[2], p[3] - q[3]];
        determinant(&minus(a), &minus(b), &minus(c), &minus(d))
    }

    #[inline(always)]
    fn normal([q, a, b, c, d]: [&Lifted<5>; 5]) -> Lifted<5> {
        let minus =
            |p: &Lifted<5>| [p[0] - q[0], p[1] - q[1], p[2] - q[2], p[3] - q[3], p[4] - q[4]];
        normal(&minus(a), &minus(b), &minus(c), &minus(d))
    }
}

/// Points as whole numbers times one power of two.
struct Dyadic<const K: usize> {
    /// Mantissa, and by how many bits it is to be shifted.
    parts: [[(i64, u32); 4]; K],
    /// All numbers are smaller than two to this power.
    bits: u32,
}

impl<const K: usize> Dyadic<K> {
    /// Of normal numbers and zeros.
    fn of(points: [&[f64; 4]; K]) -> Dyadic<K> {
        const STORED: u32 = f64::MANTISSA_DIGITS - 1;
        let split = |value: f64| {
            let bits = value.to_bits();
            let mantissa = (1 << STORED | bits & ((1 << STORED) - 1)) as i64;
            let zeros = mantissa.trailing_zeros();
            let exponent = (bits >> STORED) as u32 & 0x7ff;
            let signed = if value < 0.0 { -(mantissa >> zeros) } else { mantissa >> zeros };
            if value == 0.0 { None } else { Some((signed, exponent + zeros)) }
        };
        let parts = points.map(|p| p.map(split));
        let known = || parts.iter().flatten().flatten();
        let least = known().map(|part| part.1).min().unwrap_or(0);
        let length = |&(m, e): &(i64, u32)| m.unsigned_abs().ilog2() + 1 + e - least;
        let bits = known().map(length).max().unwrap_or(0);
        let shifted = |part: Option<(i64, u32)>| part.map_or((0, 0), |(m, e)| (m, e - least));
        Dyadic { parts: parts.map(|p| p.map(shifted)), bits }
    }

    fn small(&self) -> [[i128; 4]; K] {
        self.parts.map(|p| p.map(|(mantissa, shift)| i128::from(mantissa) << shift))
    }

    fn large(&self) -> [[BigInt; 4]; K] {
        self.parts.map(|p| p.map(|(mantissa, shift)| BigInt::from(mantissa) << shift))
    }
}

fn sign<T: Default + PartialOrd>(value: T) -> f64 {
    let zero = T::default();
    f64::from(i8::from(value > zero) - i8::from(value < zero))
}

fn exact_orientation(simplex: [&[f64; 4]; 5]) -> f64 {
    let dyadic = Dyadic::of(simplex);
    // 24 products of four differences, at most 2³⁰, stay below 2¹²⁵.
    if dyadic.bits <= 29 {
        sign(orientation(dyadic.small()))
    } else {
        sign(orientation(dyadic.large()))
    }
}

/// Of a simplex and a point.
pub(super) fn exact_in_sphere(points: [&[f64; 4]; 6]) -> f64 {
    let dyadic = Dyadic::of(points);
    // 480 products of six differences, at most 2¹⁹, stay below 2¹²³.
    if dyadic.bits <= 18 {
        sign(in_sphere(dyadic.small()))
    } else {
        sign(in_sphere(dyadic.large()))
    }
}

fn orientation<T>([q, rows @ ..]: [[T; 4]; 5]) -> T
where
    T: Add<Output = T> + Sub<Output = T>,
    for<'a> &'a T: Mul<Output = T> + Sub<Output = T>,
{
    let [a, b, c, d] = rows.map(|p| from_fn(|i| &p[i] - &q[i]));
    determinant(&a, &b, &c, &d)
}

/// With the first corner as the origin: there the hyperplane passes through zero.
fn in_sphere<T>([q, rows @ ..]: [[T; 4]; 6]) -> T
where
    T: Add<Output = T> + Sub<Output = T> + Neg<Output = T>,
    for<'a> &'a T: Mul<Output = T> + Sub<Output = T>,
{
    let dot = |a: &[T], b: &[T]| &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2] + &a[3] * &b[3];
    let [a, b, c, d, p] = rows.map(|p| {
        let [x, y, z, v] = from_fn(|i| &p[i] - &q[i]);
        let square = &x * &x + &y * &y + &z * &z + &v * &v;
        [x, y, z, v, square]
    });
    let normal = normal(&a, &b, &c, &d);
    dot(&normal, &p) + &normal[4] * &p[4]
}

/// A determinant by the minors of its first two rows and of its last two; `places` are those of
/// the columns' pairs in the order 01 02 03 12 13 23.
#[inline(always)]
fn laplace<T>(p: &[T], q: &[T], places: [usize; 6]) -> T
where
    T: Add<Output = T> + Sub<Output = T>,
    for<'a> &'a T: Mul<Output = T>,
{
    let [a, b, c, d, e, f] = places;
    &p[a] * &q[f] - &p[b] * &q[e] + &p[c] * &q[d] + &p[d] * &q[c] - &p[e] * &q[b] + &p[f] * &q[a]
}

/// `det(a, b, c, d)`.
#[inline(always)]
fn determinant<T>(a: &[T; 4], b: &[T; 4], c: &[T; 4], d: &[T; 4]) -> T
where
    T: Add<Output = T> + Sub<Output = T>,
    for<'a> &'a T: Mul<Output = T>,
{
    let minors = |a: &[T; 4], b: &[T; 4]| {
        let minor = |i: usize, j: usize| &a[i] * &b[j] - &a[j] * &b[i];
        [minor(0, 1), minor(0, 2), minor(0, 3), minor(1, 2), minor(1, 3), minor(2, 3)]
    };
    laplace(&minors(a, b), &minors(c, d), [0, 1, 2, 3, 4, 5])
}

/// `n` with `n·r = −det(a, b, c, d, r)`: up to signs the determinants without one column each.
#[inline(always)]
fn normal<T>(a: &[T; 5], b: &[T; 5], c: &[T; 5], d: &[T; 5]) -> [T; 5]
where
    T: Add<Output = T> + Sub<Output = T> + Neg<Output = T>,
    for<'a> &'a T: Mul<Output = T>,
{
    let minors = |a: &[T; 5], b: &[T; 5]| {
        let minor = |i: usize, j: usize| &a[i] * &b[j] - &a[j] * &b[i];
        [
            minor(0, 1),
            minor(0, 2),
            minor(0, 3),
            minor(0, 4),
            minor(1, 2),
            minor(1, 3),
            minor(1, 4),
            minor(2, 3),
            minor(2, 4),
            minor(3, 4),
        ]
    };
    let (p, q) = (minors(a, b), minors(c, d));
    [
        -laplace(&p, &q, [4, 5, 6, 7, 8, 9]),
        laplace(&p, &q, [1, 2, 3, 7, 8, 9]),
        -laplace(&p, &q, [0, 2, 3, 5, 6, 9]),
        laplace(&p, &q, [0, 1, 3, 4, 6, 8]),
        -laplace(&p, &q, [0, 1, 2, 4, 5, 7]),
    ]
}

/// How many of the rows are linearly independent.
fn rank<const K: usize>(mut rows: [[BigInt; 4]; K]) -> usize {
    let zero = BigInt::default();
    let mut rank = 0;
    for column in 0..4 {
        let Some(pivot) = (rank..K).find(|&row| rows[row][column] != zero) else { continue };
        rows.swap(rank, pivot);
        let (above, below) = rows.split_at_mut(rank + 1);
        let pivot = &above[rank];
        for row in below {
            let factor = row[column].clone();
            for i in column..4 {
                row[i] = &row[i] * &pivot[column] - &pivot[i] * &factor;
            }
        }
        rank += 1;
    }
    rank
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delaunay::{MAGNITUDES, power_of_two};
    use proptest::prelude::*;

    const CORNER: [[f64; 4]; 5] = [
        [0.0; 4],
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ];

    fn signs(points: &[[f64; 4]; 6]) -> [f64; 2] {
        let [simplex @ .., _] = points.each_ref();
        [exact_orientation(simplex), exact_in_sphere(points.each_ref())]
    }

    #[test]
    fn the_corner_of_the_axes_is_positive_and_holds_its_centre() {
        let [a, b, c, d, e] = CORNER;
        let sign = |size: f64| signs(&[a, b, c, d, e, [size; 4]]);
        assert_eq!(sign(0.5), [1.0, 1.0]);
        assert_eq!(sign(1.0_f64.next_down()), [1.0, 1.0]);
        assert_eq!(sign(1.0), [1.0, 0.0]);
        assert_eq!(sign(1.0_f64.next_up()), [1.0, -1.0]);
        assert_eq!(signs(&[b, a, c, d, e, [0.5; 4]]), [-1.0, -1.0]);
    }

    #[test]
    fn what_depends_on_fewer_is_found() {
        let independent = |points: &[[f64; 4]]| {
            let [corners @ .., p] = points else { unreachable!() };
            let corners: Vec<&[f64; 4]> = corners.iter().collect();
            <Triangulation<4, 5> as Dimension<4, 5>>::independent(&corners, p)
        };
        for count in 2..=5 {
            assert!(independent(&CORNER[..count]), "{count}");
            // The first is the origin, so the sum of the others lies in what they span.
            let mut dependent = CORNER;
            for axis in 0..4 {
                dependent[count - 1][axis] = CORNER[..count - 1].iter().map(|p| p[axis]).sum();
            }
            assert!(!independent(&dependent[..count]), "{count}");
            dependent[count - 1][3] = MAGNITUDES[0];
            assert!(independent(&dependent[..count]));
        }
    }

    proptest! {
        #[test]
        fn small_and_large_whole_numbers_agree(
            points in prop::array::uniform6(prop::array::uniform4(-(1_i32 << 18)..=1 << 18)),
            corner in any::<bool>(),
        ) {
            let mut points = points.map(|p| p.map(f64::from));
            if corner {
                // Often on the sphere.
                points = points.map(|p| p.map(|c| c.signum() * 2.0_f64.powi(18)));
            }
            let dyadic = Dyadic::of(points.each_ref());
            prop_assert_eq!(
                sign(in_sphere(dyadic.small())),
                sign(in_sphere(dyadic.large())),
            );
        }

        /// Signs must not change under powers of two; the points nearly share a sphere or a
        /// hyperplane and use all 53 bits.
        #[test]
        fn signs_are_exact_at_both_ends_of_the_range_in_four_dimensions(
            turns in prop::array::uniform6(prop::array::uniform3(0.0..6.3_f64)),
            shift in prop::array::uniform4(2.5..3.0_f64),
            flat in any::<bool>(),
            nudge in -2_i64..=2,
        ) {
            let mut points = turns.map(|[u, v, w]| {
                let w = if flat { 0.7 } else { w };
                let ring = w.cos();
                [
                    shift[0] + ring * u.cos() * v.cos(),
                    shift[1] + ring * u.sin() * v.cos(),
                    shift[2] + ring * v.sin(),
                    shift[3] + w.sin(),
                ]
            });
            points[4][0] = f64::from_bits((points[4][0].to_bits() as i64 + nudge) as u64);
            for exponent in [-160, 158] {
                let scaled = points.map(|p| p.map(|c| c * power_of_two(exponent)));
                prop_assert_eq!(signs(&points), signs(&scaled));
                let [simplex @ .., p] = scaled.each_ref();
                type Four = Triangulation<4, 5>;
                let rounded = [
                    <Four as Dimension<4, 5>>::orientation(simplex),
                    <Four as Dimension<4, 5>>::in_sphere(simplex, p),
                ];
                prop_assert_eq!(signs(&scaled), rounded.map(sign));
            }
        }
    }
}
