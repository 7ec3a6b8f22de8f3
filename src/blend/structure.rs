//! Tetrahedra over vertices.

use std::ops::Range;

use super::BlendError;
use crate::geometry::Point;

/// A tetrahedron whose volume is less than this share of its longest edge's cube is flat.
const FLAT: f64 = 1e-6;

/// Tetrahedra `(v₀, v₁, v₂, v₃)` over numbered vertices; they may overlap (Kaji 2015, Definition 1).
///
/// A tetrahedron is positive in a shape if `det(v₁ − v₀, v₂ − v₀, v₃ − v₀) > 0` there. Vertices in
/// none are allowed.
///
/// ```
/// use handover_mesh::blend::Structure;
/// let one = Structure::new(4, vec![[0, 1, 2, 3]])?;
/// assert_eq!(one.weights(), [1.0]);
/// # Ok::<(), handover_mesh::blend::BlendError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    vertices: usize,
    /// The last vertices, of which no tetrahedron has two.
    ghosts: usize,
    tetrahedra: Vec<[u32; 4]>,
    weights: Vec<f64>,
}

impl Structure {
    /// Tetrahedra of weight 1.
    ///
    /// # Errors
    /// [`BlendError::Corners`] names the first tetrahedron whose corners are no vertices, or are
    /// not distinct; [`BlendError::TooMany`].
    pub fn new(vertices: usize, tetrahedra: Vec<[u32; 4]>) -> Result<Self, BlendError> {
        if vertices >= u32::MAX as usize {
            return Err(BlendError::TooMany { vertices });
        }
        check_corners("tetrahedron", &tetrahedra, vertices)?;
        Ok(Self { vertices, ghosts: 0, weights: vec![1.0; tetrahedra.len()], tetrahedra })
    }

    /// The same with these as the last corners of tetrahedra over vertices alone.
    pub(super) fn with_ghosts(vertices: usize, ghosts: usize, tetrahedra: Vec<[u32; 4]>) -> Self {
        let weights = vec![1.0; tetrahedra.len()];
        Self { vertices: vertices + ghosts, ghosts, tetrahedra, weights }
    }

    /// How much each tetrahedron counts (Kaji 2015, Remark 2): `[-]`, finite, ≥ 0.
    ///
    /// # Errors
    /// [`BlendError::Weight`] names the first that is not, or where there is not one for each.
    pub fn weighted(self, weights: Vec<f64>) -> Result<Self, BlendError> {
        let usable = |weight: &f64| weight.is_finite() && *weight >= 0.0;
        let fault = weights.iter().position(|weight| !usable(weight));
        let missing = self.tetrahedra.len().min(weights.len());
        let fault = fault.or((weights.len() != self.tetrahedra.len()).then_some(missing));
        match fault {
            Some(tetrahedron) => Err(BlendError::Weight { tetrahedron }),
            None => Ok(Self { weights, ..self }),
        }
    }

    /// How many vertices there are, ghosts among them.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// The vertices that were added, the last ones: no tetrahedron has two.
    pub fn ghosts(&self) -> Range<usize> {
        self.vertices - self.ghosts..self.vertices
    }

    /// The corners of each tetrahedron.
    pub fn tetrahedra(&self) -> &[[u32; 4]] {
        &self.tetrahedra
    }

    /// How much each counts.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The tetrahedra that count and are positive in every shape, and how many that count are not.
    ///
    /// - `shapes`: one place a vertex, ghosts among them.
    pub(super) fn positive(self, shapes: &[Vec<Point>]) -> (Self, usize) {
        let (mut tetrahedra, mut weights, mut flipped) = (Vec::new(), Vec::new(), 0);
        for (corners, weight) in self.tetrahedra.into_iter().zip(self.weights) {
            if weight == 0.0 {
                continue;
            }
            let places = |shape: &'_ Vec<Point>| corners.map(|corner| shape[corner as usize]);
            if shapes.iter().all(|shape| is_positive(places(shape).each_ref())) {
                tetrahedra.push(corners);
                weights.push(weight);
            } else {
                flipped += 1;
            }
        }
        (Self { tetrahedra, weights, ..self }, flipped)
    }
}

/// Whether `det(v₁ − v₀, v₂ − v₀, v₃ − v₀) > 0`, and not for rounding alone.
pub(super) fn is_positive([a, b, c, d]: [&Point; 4]) -> bool {
    let (ab, ac, ad) = (b - a, c - a, d - a);
    let longest = ab.norm_squared().max(ac.norm_squared()).max(ad.norm_squared());
    let longest = longest.max((ab - ac).norm_squared()).max((ab - ad).norm_squared());
    let longest = longest.max((ac - ad).norm_squared());
    ab.cross(&ac).dot(&ad) > FLAT * longest * longest.sqrt()
}

/// Whether all corners are vertices, and distinct.
pub(super) fn check_corners<const N: usize>(
    what: &'static str,
    all: &[[u32; N]],
    vertices: usize,
) -> Result<(), BlendError> {
    let is_wrong = |corners: &[u32; N]| {
        let repeated = (1..N).any(|at| corners[..at].contains(&corners[at]));
        repeated || corners.iter().any(|corner| *corner as usize >= vertices)
    };
    match all.iter().position(is_wrong) {
        Some(at) => Err(BlendError::Corners { what, at, corners: all[at].to_vec(), vertices }),
        None => Ok(()),
    }
}

/// Which simplices are at each vertex: those at `v` are `at[starts[v]..starts[v + 1]]`, rising.
pub(super) fn incidence<const N: usize>(all: &[[u32; N]], vertices: usize) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; vertices + 1];
    for corner in all.iter().flatten() {
        starts[*corner as usize + 1] += 1;
    }
    for vertex in 0..vertices {
        starts[vertex + 1] += starts[vertex];
    }
    let mut next = starts.clone();
    let mut at = vec![0u32; N * all.len()];
    for (index, corners) in (0u32..).zip(all) {
        for corner in corners {
            let place = &mut next[*corner as usize];
            at[*place as usize] = index;
            *place += 1;
        }
    }
    (starts, at)
}
