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

use super::Structure;
use super::blender::Rotation;
use super::connections::Connections;
use super::gradients::Block;
use super::tangent::{
    Symmetric, exp_rotations, exp_symmetric, log_rotation, log_symmetric, nearest_branch, stretches,
};
use crate::geometry::Point;
use crate::rotations::{
    IDENTITIES, LANES, Lanes, Matrices, Quaternions, best_rotations, lane_of, matrix,
};

/// From how many beginnings a continuous logarithm is tried at most.
const BEGINNINGS: usize = 4;

/// Eight tetrahedra: the rotation's vector `[rad]`, then the stretch's `xx yy zz yz xz xy`.
pub(super) type Sums = [Lanes; 9];

/// A shape's tetrahedra, each as numbers that may be added.
///
/// - `shape`: `[m]`, ghosts among them; every tetrahedron positive.
///
/// The continuous logarithm goes breadth-first through what hangs together: each tetrahedron takes
/// the branch nearest to the mean of those before it at its corners, so that one that is turned oddly
/// leads nobody astray. It begins with the one that is turned least; as that may have come there by
/// a whole turn, it begins again where it went beyond half a turn, and of a few such beginnings the
/// one that turns all together least counts.
pub(super) fn logarithms(
    arch: Arch,
    structure: &Structure,
    connections: &Connections,
    blocks: &[Block],
    shape: &[Point],
    rotation: Rotation,
) -> Vec<Sums> {
    let mut sums: Vec<Sums> = vec![[[0.0; LANES]; 9]; blocks.len()];
    arch.dispatch(Logarithms { blocks, shape, rotation, sums: &mut sums });
    if rotation == Rotation::Continuous {
        let principal = sums
            .iter()
            .flat_map(|sums| (0..LANES).map(|lane| [sums[0][lane], sums[1][lane], sums[2][lane]]));
        let principal: Vec<[f64; 3]> = principal.take(structure.tetrahedra().len()).collect();
        for (at, vector) in continuous(structure, connections, &principal).into_iter().enumerate() {
            for axis in 0..3 {
                sums[at / LANES][axis][at % LANES] = vector[axis];
            }
        }
    }
    sums
}

/// The branches of rotations' vectors that are continuous over neighbours and turn least.
fn continuous(
    structure: &Structure,
    connections: &Connections,
    principal: &[[f64; 3]],
) -> Vec<[f64; 3]> {
    let square = |vector: &[f64; 3]| vector.iter().map(|along| along * along).sum::<f64>();
    let turning = |vectors: &[[f64; 3]]| {
        let mut sums = vec![0.0; connections.parts()];
        for (part, vector) in connections.part_of().iter().zip(vectors) {
            sums[*part as usize] += square(vector);
        }
        sums
    };
    let from_least = |rank: &dyn Fn(usize) -> f64| {
        go_on(structure, &connections.breadth_first(structure, rank), principal)
    };
    let mut best = from_least(&|at| square(&principal[at]));
    let mut least = turning(&best);
    for _ in 1..BEGINNINGS {
        let is_beyond = |at: usize| square(&best[at]) > square(&principal[at]) + 1e-6;
        if !(0..principal.len()).any(is_beyond) {
            break;
        }
        let rank = |at: usize| square(&principal[at]) + if is_beyond(at) { 0.0 } else { 1e3 };
        let other = from_least(&rank);
        let turns = turning(&other);
        if turns.iter().zip(&least).all(|(turns, least)| turns >= least) {
            break;
        }
        for (at, part) in connections.part_of().iter().enumerate() {
            if turns[*part as usize] < least[*part as usize] {
                best[at] = other[at];
            }
        }
        for (least, turns) in least.iter_mut().zip(turns) {
            *least = least.min(turns);
        }
    }
    best
}

/// Each vector's branch nearest to those before it.
fn go_on(structure: &Structure, order: &[u32], principal: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut vectors = principal.to_vec();
    // The sum of those before at each vertex, and how many they are.
    let mut before = vec![[0.0; 4]; structure.vertices()];
    for here in order {
        let corners = structure.tetrahedra()[*here as usize];
        let mut mean = [0.0; 4];
        for corner in corners {
            let sum = before[corner as usize];
            if sum[3] > 0.0 {
                for part in 0..4 {
                    mean[part] += sum[part] / sum[3];
                }
            }
        }
        let vector = &mut vectors[*here as usize];
        if mean[3] > 0.0 {
            *vector = nearest_branch(*vector, [0, 1, 2].map(|axis| mean[axis] / mean[3]));
        }
        for corner in corners {
            let sum = &mut before[corner as usize];
            for axis in 0..3 {
                sum[axis] += vector[axis];
            }
            sum[3] += 1.0;
        }
    }
    vectors
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
