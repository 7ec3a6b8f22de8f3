//! Triangles, their edges and fans.

use super::BlendError;
use crate::geometry::{Point, Vector};

/// Triangles over numbered vertices, each going around its normal counter-clockwise.
///
/// ```
/// use handover_mesh::blend::Triangles;
/// assert!(Triangles::new(3, vec![[0, 1, 2]]).is_ok());
/// assert!(Triangles::new(3, vec![[0, 1, 3]]).is_err());
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Triangles {
    vertices: usize,
    corners: Vec<[u32; 3]>,
}

/// A triangle's way along one of its edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    /// The edge's vertices, the lower one first.
    pub(super) edge: [u32; 2],
    /// Whether it goes from the lower one to the higher.
    pub(super) rises: bool,
    /// The triangle.
    pub(super) triangle: u32,
}

impl Triangles {
    /// The only way in.
    ///
    /// # Errors
    /// [`BlendError::Corners`] names the first triangle whose corners are no vertices, or are not
    /// distinct; [`BlendError::TooMany`].
    pub fn new(vertices: usize, corners: Vec<[u32; 3]>) -> Result<Self, BlendError> {
        // A ghost for every edge, three a triangle at most.
        if vertices + 3 * corners.len() >= u32::MAX as usize {
            return Err(BlendError::TooMany { vertices });
        }
        super::structure::check_corners("triangle", &corners, vertices)?;
        Ok(Self { vertices, corners })
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// The corners of each.
    pub fn as_slice(&self) -> &[[u32; 3]] {
        &self.corners
    }

    /// Each triangle's `(v₂ − v₁) × (v₃ − v₁)`: its direction (none without area) and length, twice
    /// the area.
    pub(super) fn normals(&self, shape: &[Point]) -> Vec<(Vector, f64)> {
        let mut normals = Vec::with_capacity(self.corners.len());
        for [a, b, c] in &self.corners {
            let a = &shape[*a as usize];
            let normal = (shape[*b as usize] - a).cross(&(shape[*c as usize] - a));
            let length = normal.norm();
            let unit = if length > 0.0 { normal / length } else { Vector::zeros() };
            normals.push((unit, length));
        }
        normals
    }

    /// The triangles at each vertex: those of vertex `v` are `fans[starts[v]..starts[v + 1]]`.
    pub(super) fn fans(&self) -> (Vec<u32>, Vec<u32>) {
        super::structure::incidence(&self.corners, self.vertices)
    }

    /// All sides, those of one edge together.
    pub(super) fn sides(&self) -> Vec<Side> {
        let sides = (0u32..).zip(&self.corners).flat_map(|(triangle, corners)| {
            [0, 1, 2].map(|side| {
                let [from, to] = [corners[side], corners[(side + 1) % 3]];
                Side { edge: [from.min(to), from.max(to)], rises: from < to, triangle }
            })
        });
        let mut sides: Vec<Side> = sides.collect();
        sides.sort_unstable();
        sides
    }
}
