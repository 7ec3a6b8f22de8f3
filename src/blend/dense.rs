//! Many shapes of a small structure, blended over and over.
//!
//! As [`super::Blender`] does with `E_T`, but what is between a shape and what pulls at it is one
//! small matrix, kept inverted; shapes are taken apart once, whenever they come; and what is found
//! is how far the vertices go from the weighted mean: `K u = Σ Wᵢ fᵢ (Cᵢ − Âᵢ(mean)) bₐ`.
//!
//! A tetrahedron that is inside out in a shape that counts has no `Cᵢ`, and `Âᵢ(mean)`, the weighted
//! mean of its maps, is what it takes: `fᵢ = 1 / (1 + Σ wₖ qₖᵢ)`, `q` 0 where the determinant is
//! 0.1 or more and rising without bound towards 0. So no vertex is left out, the matrix stays
//! the same whatever is inside out, nothing jumps when something turns inside out, and where
//! everything is the mean remains.

use nalgebra::DMatrix;
use pulp::{Arch, Simd, WithSimd};

use super::connections::Connections;
use super::gradients::{self, Block};
use super::logarithms::{
    Logarithms, Sums, add_weighted, logarithms, products, rotations_and_stretches,
};
use super::{BlendError, Rotation, Structure};
use crate::geometry::{Point, Vector, is_finite};
use crate::rotations::{LANES, Lanes, Matrices};

/// Below this determinant of its map a tetrahedron counts less and less `[-]`.
const FADE: f64 = 0.1;

/// The doubt about a tetrahedron that is inside out, `q`.
const MOST_DOUBT: f64 = 1e15;

/// A small structure at rest, ready for shapes; immutable.
#[derive(Debug, Clone)]
pub struct DenseBlender {
    vertices: usize,
    blocks: Vec<Block>,
    structure: Structure,
    connections: Connections,
    /// Which vertices move.
    unknowns: Vec<u32>,
    /// `K⁻¹`, symmetric: `unknowns × unknowns` `[m²]`.
    inverse: Vec<f64>,
    arch: Arch,
}

/// A shape taken apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Apart {
    /// Of each block.
    sums: Vec<Sums>,
    /// How near to inside out each is: `q` `[-]`, 0 to 1e15.
    doubts: Vec<Lanes>,
}

/// Room to blend.
#[derive(Debug, Clone)]
pub struct DenseWorkspace {
    pulls: Vec<Vector>,
    /// How far each unknown goes, by axis.
    moves: [Vec<f64>; 3],
}

impl DenseBlender {
    /// Makes a structure ready.
    ///
    /// - `rest`: `[m]`, one place a vertex; tetrahedra that are not positive in it are left out.
    /// - `pins`: vertices that stay where the mean has them; of what hangs together at least one.
    ///
    /// # Errors
    /// [`BlendError::Empty`] where no tetrahedron is positive, [`BlendError::Undetermined`] where
    /// tetrahedra hang together without a pin; [`BlendError::Shape`], [`BlendError::NotFinite`],
    /// [`BlendError::Pin`].
    pub fn new(structure: &Structure, rest: &[Point], pins: &[usize]) -> Result<Self, BlendError> {
        let vertices = structure.vertices();
        super::blender::check_shapes(&[rest], vertices)?;
        if let Some(vertex) = pins.iter().copied().find(|pin| *pin >= vertices) {
            return Err(BlendError::Pin { vertex, vertices });
        }
        let (structure, _) = structure.clone().positive(&[rest.to_vec()]);
        if structure.tetrahedra().is_empty() {
            return Err(BlendError::Empty);
        }
        let connections = Connections::new(&structure);
        let part_of = |vertex: usize| connections.part_of_vertex(vertex);
        let is_held = |part: usize| pins.iter().any(|pin| part_of(*pin) == Some(part));
        if !(0..connections.parts()).all(is_held) {
            return Err(BlendError::Undetermined);
        }
        let blocks = gradients::blocks(&structure, rest);
        let moves = |vertex: &usize| part_of(*vertex).is_some() && !pins.contains(vertex);
        let unknowns: Vec<u32> = (0..vertices).filter(moves).map(|vertex| vertex as u32).collect();
        let mut place = vec![None; vertices];
        unknowns.iter().enumerate().for_each(|(at, vertex)| place[*vertex as usize] = Some(at));
        let mut matrix = DMatrix::zeros(unknowns.len(), unknowns.len());
        for block in &blocks {
            for lane in 0..LANES {
                let gradients = block.gradients(lane);
                let places = block.corners.map(|corners| place[corners[lane] as usize]);
                for (one, row) in gradients.iter().zip(places) {
                    for (other, column) in gradients.iter().zip(places) {
                        if let (Some(row), Some(column)) = (row, column) {
                            matrix[(row, column)] += block.weights[lane] * one.dot(other);
                        }
                    }
                }
            }
        }
        let inverse = matrix.cholesky().ok_or(BlendError::Undetermined)?.inverse();
        let inverse: Vec<f64> = inverse.as_slice().to_vec();
        if inverse.iter().any(|entry: &f64| !entry.is_finite()) {
            return Err(BlendError::Undetermined);
        }
        Ok(Self { vertices, structure, connections, blocks, unknowns, inverse, arch: Arch::new() })
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// How many tetrahedra there are.
    pub fn tetrahedra(&self) -> usize {
        self.structure.tetrahedra().len()
    }

    /// Takes a shape apart.
    ///
    /// - `shape`: `[m]`, one place a vertex; one that is not finite is inside out everywhere.
    ///
    /// # Panics
    /// If there is not one place a vertex: the caller's bug.
    pub fn apart(&self, shape: &[Point]) -> Apart {
        assert_eq!(shape.len(), self.vertices, "one place a vertex");
        if !shape.iter().all(is_finite) {
            let blocks = self.blocks.len();
            return Apart {
                sums: vec![[[0.0; LANES]; 9]; blocks],
                doubts: vec![[MOST_DOUBT; LANES]; blocks],
            };
        }
        let mut doubts: Vec<Lanes> =
            self.blocks.iter().map(|block| doubts(&block.maps(shape))).collect();
        let Self { structure, connections, blocks, arch, .. } = self;
        let rotation = Rotation::Continuous;
        let Logarithms { mut sums, rests } =
            logarithms(*arch, structure, connections, blocks, shape, rotation);
        // What is turned so far that one vector does not tell it takes the mean as well.
        for (rests, doubts) in rests.iter().flatten().zip(&mut doubts) {
            for lane in (0..LANES).filter(|lane| (0..3).any(|axis| rests[axis][*lane] != 0.0)) {
                doubts[lane] = MOST_DOUBT;
            }
        }
        for (sums, doubts) in sums.iter_mut().zip(&doubts) {
            for lane in (0..LANES).filter(|lane| doubts[*lane] >= MOST_DOUBT) {
                // What is inside out has no logarithm.
                sums.iter_mut().for_each(|sum| sum[lane] = 0.0);
            }
        }
        Apart { sums, doubts }
    }

    /// Room for [`Self::blend`].
    pub fn workspace(&self) -> DenseWorkspace {
        let zeros = || vec![0.0; self.unknowns.len()];
        DenseWorkspace {
            pulls: vec![Vector::zeros(); self.vertices],
            moves: [zeros(), zeros(), zeros()],
        }
    }

    /// Brings the weighted mean of shapes to where their blend is; without allocation.
    ///
    /// - `shapes`: weights `[-]` and the shapes they are of, those that count.
    /// - `mean`: `[m]`, one place a vertex: their weighted mean, overwritten by the blend.
    ///
    /// # Panics
    /// If there is not one place a vertex: the caller's bug.
    pub fn blend<'a>(
        &self,
        shapes: impl Iterator<Item = (f64, &'a Apart)> + Clone,
        mean: &mut [Point],
        workspace: &mut DenseWorkspace,
    ) {
        assert_eq!(mean.len(), self.vertices, "one place a vertex");
        self.arch.dispatch(Blend { blender: self, shapes, mean, workspace });
    }
}

/// One blend.
struct Blend<'a, I> {
    blender: &'a DenseBlender,
    shapes: I,
    mean: &'a mut [Point],
    workspace: &'a mut DenseWorkspace,
}

impl<'b, I: Iterator<Item = (f64, &'b Apart)> + Clone> WithSimd for Blend<'_, I> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { blender, shapes, mean, workspace } = self;
        let DenseWorkspace { pulls, moves } = workspace;
        pulls.fill(Vector::zeros());
        for (at, block) in blender.blocks.iter().enumerate() {
            let (mut sums, mut doubt) = ([[0.0; LANES]; 9], [0.0; LANES]);
            for (weight, shape) in shapes.clone() {
                add_weighted(weight, &shape.sums[at], &mut sums);
                let doubts = &shape.doubts[at];
                for lane in 0..LANES {
                    doubt[lane] = weight.mul_add(doubts[lane], doubt[lane]);
                }
            }
            let (rotations, stretches) = rotations_and_stretches(&sums, Rotation::Continuous);
            let (mut asked, maps) = (products(&rotations, &stretches), block.maps(mean));
            for lane in 0..LANES {
                doubt[lane] = 1.0 / (1.0 + doubt[lane]);
            }
            for i in 0..3 {
                for j in 0..3 {
                    for lane in 0..LANES {
                        asked[i][j][lane] = doubt[lane] * (asked[i][j][lane] - maps[i][j][lane]);
                    }
                }
            }
            block.pull(&asked, pulls);
        }
        let count = blender.unknowns.len();
        for axis in 0..3 {
            let moves = &mut moves[axis][..count];
            moves.fill(0.0);
            for (vertex, row) in
                blender.unknowns.iter().zip(blender.inverse.chunks_exact(count.max(1)))
            {
                let pull = pulls[*vertex as usize][axis];
                for at in 0..count {
                    moves[at] = pull.mul_add(row[at], moves[at]);
                }
            }
        }
        for (at, vertex) in blender.unknowns.iter().enumerate() {
            mean[*vertex as usize] += Vector::new(moves[0][at], moves[1][at], moves[2][at]);
        }
    }
}

/// `q` of each map.
#[inline(always)]
fn doubts(maps: &Matrices) -> Lanes {
    let mut found = [0.0; LANES];
    for lane in 0..LANES {
        let m = |i: usize, j: usize| maps[i][j][lane];
        let minor = |a: usize, b: usize| m(1, a) * m(2, b) - m(1, b) * m(2, a);
        let determinant = m(0, 0) * minor(1, 2) - m(0, 1) * minor(0, 2) + m(0, 2) * minor(0, 1);
        let doubt = (FADE / determinant.max(f64::MIN_POSITIVE) - 1.0).max(0.0);
        found[lane] = if determinant > 0.0 { doubt.min(MOST_DOUBT) } else { MOST_DOUBT };
    }
    found
}
