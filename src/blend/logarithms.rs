//! Maps of tetrahedra → numbers that may be added, and back.
//!
//! With `Âₖ = Rₖ Sₖ` (polar decomposition) and weights `wₖ`
//!
//! `Blend_P = exp(Σ wₖ log Rₖ) (I + Σ wₖ (Sₖ − I))`, the logarithm of angles up to π (Sumner et al.
//! 2005), and
//!
//! `Blend_C = exp(Σ wₖ logᶜ Rₖ) exp(Σ wₖ log Sₖ)`, its angles continuous from each tetrahedron to its
//! neighbours (Kaji 2015, section 5; there `Σ exp` is printed, with which no weights at all would
//! not give the reference). The determinant of Blend_C is positive whatever the weights, that of
//! Blend_P need not be.

use pulp::{Arch, Simd, WithSimd};

use super::branches::{self, Turn};
use super::connections::Connections;
use super::gradients::Block;
use super::tangent::{
    Symmetric, exp_rotations, exp_symmetric, log_rotation, log_symmetric, stretches,
};
use super::{Rotation, Structure};
use crate::geometry::{Point, Vector};
use crate::rotations::{
    IDENTITIES, LANES, Lanes, Matrices, Quaternions, best_rotations, lane_of, matrix,
};

/// Eight tetrahedra: the rotation's vector `[rad]`, then the stretch's `xx yy zz yz xz xy`.
pub(super) type Sums = [Lanes; 9];

/// A shape's tetrahedra, each as numbers that may be added.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Logarithms {
    pub(super) sums: Vec<Sums>,
    /// Rotations' vectors that come on top, see [`super::branches`]; none where all are 0.
    pub(super) rests: Option<Vec<[Lanes; 3]>>,
}

/// Takes a shape's tetrahedra as numbers that may be added.
///
/// - `shape`: `[m]`, ghosts among them; every tetrahedron positive.
pub(super) fn logarithms(
    arch: Arch,
    structure: &Structure,
    connections: &Connections,
    blocks: &[Block],
    shape: &[Point],
    rotation: Rotation,
) -> Logarithms {
    let mut sums: Vec<Sums> = vec![[[0.0; LANES]; 9]; blocks.len()];
    arch.dispatch(TakeLogarithms { blocks, shape, rotation, sums: &mut sums });
    let mut rests = None;
    if rotation == Rotation::Continuous {
        let principal = sums.iter().flat_map(|sums| {
            (0..LANES).map(|lane| Vector::new(sums[0][lane], sums[1][lane], sums[2][lane]))
        });
        let principal: Vec<Vector> = principal.take(structure.tetrahedra().len()).collect();
        let turns = branches::continuous(structure, connections, &principal);
        for (at, Turn { vector, rest }) in turns.into_iter().enumerate() {
            let (block, lane) = (at / LANES, at % LANES);
            for axis in 0..3 {
                sums[block][axis][lane] = vector[axis];
            }
            if rest != Vector::zeros() {
                let rests = rests.get_or_insert_with(|| vec![[[0.0; LANES]; 3]; blocks.len()]);
                for axis in 0..3 {
                    rests[block][axis][lane] = rest[axis];
                }
            }
        }
    }
    Logarithms { sums, rests }
}

/// The logarithms of each for itself.
struct TakeLogarithms<'a> {
    blocks: &'a [Block],
    shape: &'a [Point],
    rotation: Rotation,
    sums: &'a mut [Sums],
}

impl WithSimd for TakeLogarithms<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { blocks, shape, rotation, sums } = self;
        // Tetrahedra side by side are turned alike: each block begins where the last one ended.
        let mut quaternions = IDENTITIES;
        for (sums, block) in sums.iter_mut().zip(blocks) {
            let maps = block.maps(shape);
            best_rotations(&maps, &mut quaternions);
            let mut stretch = stretches(&maps, &matrices(&quaternions));
            match rotation {
                Rotation::Continuous => stretch = log_symmetric(&stretch),
                Rotation::Principal => add_to_diagonal(&mut stretch, -1.0),
            }
            sums[3..].copy_from_slice(&stretch);
            for lane in 0..LANES {
                let vector = log_rotation(&quaternions, lane);
                for axis in 0..3 {
                    sums[axis][lane] = vector[axis];
                }
            }
        }
    }
}

/// `sums + weight · more`.
#[inline(always)]
pub(super) fn add_weighted<const N: usize>(weight: f64, more: &[Lanes; N], sums: &mut [Lanes; N]) {
    for part in 0..N {
        for lane in 0..LANES {
            sums[part][lane] = weight.mul_add(more[part][lane], sums[part][lane]);
        }
    }
}

/// The rotations and the stretches that sums stand for.
#[inline(always)]
pub(super) fn rotations_and_stretches(sums: &Sums, rotation: Rotation) -> (Quaternions, Symmetric) {
    let [x, y, z, xx, yy, zz, yz, xz, xy] = *sums;
    let rotations = exp_rotations(&[x, y, z]);
    let mut stretch = [xx, yy, zz, yz, xz, xy];
    match rotation {
        Rotation::Continuous => stretch = exp_symmetric(&stretch),
        Rotation::Principal => add_to_diagonal(&mut stretch, 1.0),
    }
    (rotations, stretch)
}

#[inline(always)]
fn add_to_diagonal(stretches: &mut Symmetric, value: f64) {
    for axis in 0..3 {
        for lane in 0..LANES {
            stretches[axis][lane] += value;
        }
    }
}

/// The rotation by a vector after another.
#[inline(always)]
pub(super) fn turned_further(rotations: &Quaternions, rests: &[Lanes; 3]) -> Quaternions {
    let (one, other) = (rotations, exp_rotations(rests));
    let mut found = IDENTITIES;
    for lane in 0..LANES {
        let (a, b, c, d) = (one[0][lane], one[1][lane], one[2][lane], one[3][lane]);
        let (w, x, y, z) = (other[0][lane], other[1][lane], other[2][lane], other[3][lane]);
        found[0][lane] = a * w - (b * x + c * y + d * z);
        found[1][lane] = a * x + b * w + c * z - d * y;
        found[2][lane] = a * y + c * w + d * x - b * z;
        found[3][lane] = a * z + d * w + b * y - c * x;
    }
    found
}

/// `R S`.
#[inline(always)]
pub(super) fn products(rotations: &Quaternions, stretch: &Symmetric) -> Matrices {
    times(&matrices(rotations), stretch)
}

/// `A S`.
#[inline(always)]
pub(super) fn times(maps: &Matrices, [xx, yy, zz, yz, xz, xy]: &Symmetric) -> Matrices {
    let columns = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let mut found = [[[0.0; LANES]; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            for lane in 0..LANES {
                let (a, b, c) = (maps[i][0][lane], maps[i][1][lane], maps[i][2][lane]);
                let first = a.mul_add(columns[j][0][lane], b * columns[j][1][lane]);
                found[i][j][lane] = c.mul_add(columns[j][2][lane], first);
            }
        }
    }
    found
}

/// The matrices of rotations.
#[inline(always)]
pub(super) fn matrices(rotations: &Quaternions) -> Matrices {
    let mut found = [[[0.0; LANES]; 3]; 3];
    for lane in 0..LANES {
        let one = matrix(lane_of(rotations, lane));
        for i in 0..3 {
            for j in 0..3 {
                found[i][j][lane] = one[i][j];
            }
        }
    }
    found
}
