//! The reference's tetrahedra, eight at a time: where vertices are → how each is mapped, and what
//! each map asks of its vertices.
//!
//! With `D = (v₁ − v₀, v₂ − v₀, v₃ − v₀)` of the reference and `D'` of another shape the linear part
//! of the map is `Â = D' D⁻¹` (Kaji 2015, eq. 2): linear in the shape, `Â = Σₐ v'ₐ bₐᵀ`, where `b₁`,
//! `b₂`, `b₃` are the rows of `D⁻¹` and `b₀ = −b₁ − b₂ − b₃`.

use nalgebra::Matrix3;

use super::Structure;
use crate::geometry::{Point, Vector};
use crate::rotations::{LANES, Lanes, Matrices};

/// Eight tetrahedra.
#[derive(Debug, Clone)]
pub(super) struct Block {
    /// The corners `v₀ … v₃`.
    pub(super) corners: [[u32; LANES]; 4],
    /// `b₁`, `b₂`, `b₃` `[1/m]`.
    gradients: Matrices,
    /// `Wᵢ`; 0 of lanes to spare.
    pub(super) weights: Lanes,
}

/// All tetrahedra's blocks; the last is filled up with its last tetrahedron, of weight 0.
///
/// - `reference`: one place `[m]` a vertex; every tetrahedron has a volume in it.
pub(super) fn blocks(structure: &Structure, reference: &[Point]) -> Vec<Block> {
    let all = structure.tetrahedra();
    let count = all.len().div_ceil(LANES);
    let mut blocks = Vec::with_capacity(count);
    for first in (0..count).map(|block| block * LANES) {
        let mut block = Block {
            corners: [[0; LANES]; 4],
            gradients: [[[0.0; LANES]; 3]; 3],
            weights: [0.0; LANES],
        };
        for lane in 0..LANES {
            let at = (first + lane).min(all.len() - 1);
            if first + lane == at {
                block.weights[lane] = structure.weights()[at];
            }
            let [a, b, c, d] = all[at].map(|corner| reference[corner as usize]);
            let sides = Matrix3::from_columns(&[b - a, c - a, d - a]);
            let inverse = sides.try_inverse().unwrap_or_else(Matrix3::zeros);
            for corner in 0..4 {
                block.corners[corner][lane] = all[at][corner];
            }
            for row in 0..3 {
                for axis in 0..3 {
                    block.gradients[row][axis][lane] = inverse[(row, axis)];
                }
            }
        }
        blocks.push(block);
    }
    blocks
}

impl Block {
    /// `b₀ … b₃` of one tetrahedron `[1/m]`.
    pub(super) fn gradients(&self, lane: usize) -> [Vector; 4] {
        let row = |row: usize| Vector::from([0, 1, 2].map(|axis| self.gradients[row][axis][lane]));
        let [b, c, d] = [row(0), row(1), row(2)];
        [-b - c - d, b, c, d]
    }

    /// `Â` of a shape.
    #[inline(always)]
    pub(super) fn maps(&self, shape: &[Point]) -> Matrices {
        // Loops all the way: of closures the compiler makes functions that know no vectors.
        let mut sides = [[[0.0; LANES]; 3]; 3];
        for lane in 0..LANES {
            let origin = &shape[self.corners[0][lane] as usize];
            for side in 0..3 {
                let to = &shape[self.corners[side + 1][lane] as usize];
                for axis in 0..3 {
                    sides[side][axis][lane] = to[axis] - origin[axis];
                }
            }
        }
        let mut maps = [[[0.0; LANES]; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                for lane in 0..LANES {
                    let (a, b, c) = (sides[0][i][lane], sides[1][i][lane], sides[2][i][lane]);
                    let [d, e, f] = &self.gradients;
                    let first = a.mul_add(d[j][lane], b * e[j][lane]);
                    maps[i][j][lane] = c.mul_add(f[j][lane], first);
                }
            }
        }
        maps
    }

    /// Adds `W C bₐ` to each corner: the right-hand side of the minimum of `Σ W‖Â − C‖²`.
    #[inline(always)]
    pub(super) fn pull(&self, maps: &Matrices, pulls: &mut [Vector]) {
        let mut pulled = [[[0.0; LANES]; 3]; 4];
        for corner in 0..3 {
            let gradient = &self.gradients[corner];
            for i in 0..3 {
                for lane in 0..LANES {
                    let (a, b, c) = (maps[i][0][lane], maps[i][1][lane], maps[i][2][lane]);
                    let first = a.mul_add(gradient[0][lane], b * gradient[1][lane]);
                    let pull = c.mul_add(gradient[2][lane], first) * self.weights[lane];
                    pulled[corner + 1][i][lane] = pull;
                    pulled[0][i][lane] -= pull;
                }
            }
        }
        for lane in 0..LANES {
            for corner in 0..4 {
                let pull = &mut pulls[self.corners[corner][lane] as usize];
                for axis in 0..3 {
                    pull[axis] += pulled[corner][axis][lane];
                }
            }
        }
    }
}

/// `Σ W‖A − B‖²` of one block.
#[inline(always)]
pub(super) fn squared_differences(a: &Matrices, b: &Matrices, weights: &Lanes) -> f64 {
    let mut sums = [0.0; LANES];
    for i in 0..3 {
        for j in 0..3 {
            for lane in 0..LANES {
                let difference = a[i][j][lane] - b[i][j][lane];
                sums[lane] += weights[lane] * difference * difference;
            }
        }
    }
    let mut sum = 0.0;
    for lane in 0..LANES {
        sum += sums[lane];
    }
    sum
}
