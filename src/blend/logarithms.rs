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

use super::blender::Rotation;
use super::gradients::Block;
use super::tangent::{
    Symmetric, exp_rotations, exp_symmetric, log_rotation, log_symmetric, nearest_branch, stretches,
};
use crate::geometry::Point;
use crate::rotations::{
    IDENTITIES, LANES, Lanes, Matrices, Quaternions, best_rotations, lane_of, matrix,
};

/// Eight tetrahedra: the rotation's vector `[rad]`, then the stretch's `xx yy zz yz xz xy`.
pub(super) type Sums = [Lanes; 9];

/// A shape's tetrahedra, each as numbers that may be added.
///
/// - `shape`: `[m]`, ghosts among them; every tetrahedron positive.
/// - `order`: each tetrahedron after a neighbour.
pub(super) fn logarithms(
    arch: Arch,
    blocks: &[Block],
    shape: &[Point],
    order: &[(u32, Option<u32>)],
    rotation: Rotation,
) -> Vec<Sums> {
    let mut sums: Vec<Sums> = vec![[[0.0; LANES]; 9]; blocks.len()];
    arch.dispatch(Logarithms { blocks, shape, rotation, sums: &mut sums });
    if rotation == Rotation::Continuous {
        for (here, neighbour) in order {
            let Some(neighbour) = neighbour else { continue };
            let vector = |at: u32| {
                let (block, lane) = (at as usize / LANES, at as usize % LANES);
                [0, 1, 2].map(|axis| sums[block][axis][lane])
            };
            let nearest = nearest_branch(vector(*here), vector(*neighbour));
            let (block, lane) = (*here as usize / LANES, *here as usize % LANES);
            for axis in 0..3 {
                sums[block][axis][lane] = nearest[axis];
            }
        }
    }
    sums
}

/// The logarithms of each for itself.
struct Logarithms<'a> {
    blocks: &'a [Block],
    shape: &'a [Point],
    rotation: Rotation,
    sums: &'a mut [Sums],
}

impl WithSimd for Logarithms<'_> {
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
            for part in 0..6 {
                sums[3 + part] = stretch[part];
            }
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
pub(super) fn add_weighted(weight: f64, more: &Sums, sums: &mut Sums) {
    for part in 0..9 {
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
