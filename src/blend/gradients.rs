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
        let mut sides = [[[0.0; LANES]; 3]; 3];
        for lane in 0..LANES {
            let [a, b, c, d] =
                [0, 1, 2, 3].map(|corner| shape[self.corners[corner][lane] as usize]);
            for (side, to) in [b, c, d].into_iter().enumerate() {
                let side = &mut sides[side];
                (side[0][lane], side[1][lane], side[2][lane]) =
                    (to.x - a.x, to.y - a.y, to.z - a.z);
            }
        }
        let mut maps = [[[0.0; LANES]; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                for lane in 0..LANES {
                    let term = |side: usize| sides[side][i][lane] * self.gradients[side][j][lane];
                    maps[i][j][lane] = term(0) + term(1) + term(2);
                }
            }
        }
        maps
    }

    /// Adds `W C bₐ` to each corner: the right-hand side of the minimum of `Σ W‖Â − C‖²`.
    #[inline(always)]
    pub(super) fn pull(&self, maps: &Matrices, pulls: &mut [Vector]) {
        let mut pulled = [[[0.0; LANES]; 3]; 3];
        for corner in 0..3 {
            for i in 0..3 {
                for lane in 0..LANES {
                    let term = |j: usize| maps[i][j][lane] * self.gradients[corner][j][lane];
                    pulled[corner][i][lane] = (term(0) + term(1) + term(2)) * self.weights[lane];
                }
            }
        }
        for lane in 0..LANES {
            let [b, c, d] =
                pulled.map(|pull| Vector::new(pull[0][lane], pull[1][lane], pull[2][lane]));
            for (corner, pull) in [-b - c - d, b, c, d].into_iter().enumerate() {
                pulls[self.corners[corner][lane] as usize] += pull;
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
    sums.iter().sum()
}
