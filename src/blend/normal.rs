//! Where vertices go so that `Σ Wᵢ‖Âᵢ − Cᵢ‖²` is least: one sparse factor for x, y and z.
//!
//! `Âᵢ` is linear in the vertices, so the minimum solves `K v = Σ Wᵢ Cᵢ bₐ`, `K = Σ Wᵢ bₐ·b_b` over
//! the corners. No two ghosts have a tetrahedron in common, so eliminating them is a division each:
//! what is factored (by `faer`, approximate minimum degree, supernodal where that is quicker) holds
//! the given vertices alone. A ghost above many triangles would join all their corners with each
//! other and stays.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, Mat, Par, Side};

use super::connections::Connections;
use super::gradients::Block;
use super::{BlendError, Structure};
use crate::geometry::{Point, Vector};
use crate::rotations::LANES;

/// Ghosts joined with more vertices than this are not eliminated beforehand.
const MOST_JOINED: usize = 32;

/// A factor of more numbers than this (2 GiB) is not made: those of surfaces have some hundred a
/// vertex.
const MOST_VALUES: usize = 1 << 28;

/// What a vertex is to the system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// In no tetrahedron.
    Absent,
    /// Given.
    Known,
    /// A row of the factor.
    Unknown(u32),
    /// A ghost that follows from the rest.
    Eliminated,
}

/// An eliminated ghost.
#[derive(Debug)]
struct GhostRow {
    ghost: u32,
    /// `1 / K_gg` `[m²]`.
    inverse: f64,
    /// Where its entries end; they begin where the last one's do.
    end: u32,
}

/// The factored system; immutable.
#[derive(Debug)]
pub(super) struct Normal {
    places: Vec<Place>,
    ghosts: Vec<GhostRow>,
    /// `(vertex, K_gv / K_gg)` of the eliminated ghosts.
    shares: Vec<(u32, f64)>,
    /// `(unknown, known vertex, entry)`.
    couplings: Vec<(u32, u32, f64)>,
    symbolic: SymbolicCholesky<u32>,
    values: Vec<f64>,
    unknowns: usize,
}

/// Room to solve.
pub(super) struct Room {
    right: Mat<f64>,
    stack: MemBuffer,
}

impl std::fmt::Debug for Room {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Room").field("rows", &self.right.nrows()).finish_non_exhaustive()
    }
}

impl Normal {
    /// Assembles and factors.
    ///
    /// - `is_known`: which vertices are given; of each part that hangs together at least one.
    ///
    /// # Errors
    /// [`BlendError::Undetermined`], [`BlendError::Entangled`].
    pub(super) fn new(
        structure: &Structure,
        connections: &Connections,
        blocks: &[Block],
        is_known: &[bool],
    ) -> Result<Self, BlendError> {
        let gradients =
            blocks.iter().flat_map(|block| (0..LANES).map(|lane| block.gradients(lane)));
        let gradients: Vec<[Vector; 4]> = gradients.take(structure.tetrahedra().len()).collect();
        let add_all = |vertex: usize, row: &mut Row| {
            for tetrahedron in connections.at(vertex) {
                let tetrahedron = *tetrahedron as usize;
                let corners = &structure.tetrahedra()[tetrahedron];
                let gradients = &gradients[tetrahedron];
                let own = corners.iter().position(|corner| *corner as usize == vertex);
                let own = gradients[own.unwrap_or(0)] * structure.weights()[tetrahedron];
                for (corner, gradient) in corners.iter().zip(gradients) {
                    row.add(*corner, own.dot(gradient));
                }
            }
        };
        // One row of the matrix at a time, spread out over all vertices.
        let mut row = Row::new(structure.vertices());
        let mut places: Vec<Place> = Vec::with_capacity(structure.vertices());
        let (mut unknowns, mut ghosts, mut shares) = (0, Vec::new(), Vec::new());
        for vertex in 0..structure.vertices() {
            let count = connections.at(vertex).len();
            let is_ghost = structure.ghosts().contains(&vertex);
            places.push(if count == 0 {
                Place::Absent
            } else if is_known[vertex] {
                Place::Known
            } else if is_ghost && 2 + count <= MOST_JOINED {
                add_all(vertex, &mut row);
                let scale = 1.0 / row.entries[vertex];
                row.drain(|other, entry| {
                    if other as usize != vertex {
                        shares.push((other, entry * scale));
                    }
                });
                let end = shares.len() as u32;
                ghosts.push(GhostRow { ghost: vertex as u32, inverse: scale, end });
                Place::Eliminated
            } else {
                unknowns += 1;
                Place::Unknown(unknowns - 1)
            });
        }
        let mut vertices = vec![0u32; unknowns as usize];
        for (vertex, place) in (0u32..).zip(&places) {
            if let Place::Unknown(unknown) = place {
                vertices[*unknown as usize] = vertex;
            }
        }
        let eliminated = Eliminated::new(&ghosts, &shares, structure.vertices());
        let (mut starts, mut rows, mut entries) = (vec![0u32], Vec::new(), Vec::new());
        let mut couplings = Vec::new();
        for (unknown, vertex) in (0u32..).zip(&vertices) {
            add_all(*vertex as usize, &mut row);
            for (ghost, share) in eliminated.at(*vertex) {
                let GhostRow { inverse, .. } = &ghosts[ghost];
                for (other, other_share) in eliminated.row(ghost) {
                    row.add(*other, -share * other_share / inverse);
                }
            }
            row.drain(|other, entry| match places[other as usize] {
                Place::Unknown(at) if at >= unknown => {
                    rows.push(at);
                    entries.push(entry);
                }
                Place::Known => couplings.push((unknown, other, entry)),
                _ => {}
            });
            starts.push(rows.len() as u32);
        }
        let unknowns = unknowns as usize;
        let pattern = SymbolicSparseColMat::new_checked(unknowns, unknowns, starts, None, rows);
        let symbolic = factorize_symbolic_cholesky(
            pattern.as_ref(),
            Side::Lower,
            SymmetricOrdering::Amd,
            CholeskySymbolicParams::default(),
        );
        let symbolic = symbolic.map_err(|_| BlendError::Undetermined)?;
        if symbolic.len_val() > MOST_VALUES {
            return Err(BlendError::Entangled { values: symbolic.len_val() });
        }
        let mut values = vec![0.0; symbolic.len_val()];
        let scratch = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let matrix = SparseColMatRef::new(pattern.as_ref(), &entries);
        let factored = symbolic.factorize_numeric_llt(
            &mut values,
            matrix,
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Default::default(),
        );
        if factored.is_err() || values.iter().any(|value| !value.is_finite()) {
            return Err(BlendError::Undetermined);
        }
        Ok(Self { places, ghosts, shares, couplings, symbolic, values, unknowns })
    }

    /// Room for [`Self::solve`].
    pub(super) fn room(&self) -> Room {
        let stack = MemBuffer::new(self.symbolic.solve_in_place_scratch::<f64>(3, Par::Seq));
        Room { right: Mat::zeros(self.unknowns, 3), stack }
    }

    /// The vertices that come nearest to what pulls at them; without allocation.
    ///
    /// - `pulls`: `Σ W C bₐ` `[1/m]` at each vertex; used up.
    /// - `shape`: `[m]`, one place a vertex: the known ones given, those in no tetrahedron left as
    ///   they are, the rest overwritten.
    pub(super) fn solve(&self, pulls: &mut [Vector], shape: &mut [Point], room: &mut Room) {
        let mut begin = 0;
        for row in &self.ghosts {
            let pull = pulls[row.ghost as usize];
            for (vertex, share) in &self.shares[begin..row.end as usize] {
                pulls[*vertex as usize] -= *share * pull;
            }
            begin = row.end as usize;
        }
        for (place, pull) in self.places.iter().zip(&*pulls) {
            if let Place::Unknown(unknown) = place {
                for axis in 0..3 {
                    room.right[(*unknown as usize, axis)] = pull[axis];
                }
            }
        }
        for (unknown, vertex, entry) in &self.couplings {
            for axis in 0..3 {
                room.right[(*unknown as usize, axis)] -= entry * shape[*vertex as usize][axis];
            }
        }
        let factor = LltRef::new(&self.symbolic, &self.values);
        factor.solve_in_place_with_conj(
            Conj::No,
            room.right.as_mut(),
            Par::Seq,
            MemStack::new(&mut room.stack),
        );
        for (place, here) in self.places.iter().zip(&mut *shape) {
            if let Place::Unknown(unknown) = place {
                *here = Point::from([0, 1, 2].map(|axis| room.right[(*unknown as usize, axis)]));
            }
        }
        let mut begin = 0;
        for row in &self.ghosts {
            let mut place = pulls[row.ghost as usize] * row.inverse;
            for (vertex, share) in &self.shares[begin..row.end as usize] {
                place -= *share * shape[*vertex as usize].coords;
            }
            shape[row.ghost as usize] = Point::from(place);
            begin = row.end as usize;
        }
    }
}

/// The eliminated ghosts' entries by vertex.
struct Eliminated<'a> {
    shares: &'a [(u32, f64)],
    begins: Vec<u32>,
    starts: Vec<u32>,
    /// `(ghost's row, share)`, vertex by vertex.
    at: Vec<(u32, f64)>,
}

impl<'a> Eliminated<'a> {
    fn new(ghosts: &[GhostRow], shares: &'a [(u32, f64)], vertices: usize) -> Self {
        let begins: Vec<u32> = std::iter::once(0).chain(ghosts.iter().map(|row| row.end)).collect();
        let mut starts = vec![0u32; vertices + 1];
        shares.iter().for_each(|(vertex, _)| starts[*vertex as usize + 1] += 1);
        for vertex in 0..vertices {
            starts[vertex + 1] += starts[vertex];
        }
        let mut next = starts.clone();
        let mut at = vec![(0, 0.0); shares.len()];
        for row in 0..ghosts.len() {
            for (vertex, share) in &shares[begins[row] as usize..begins[row + 1] as usize] {
                let place = &mut next[*vertex as usize];
                at[*place as usize] = (row as u32, *share);
                *place += 1;
            }
        }
        Self { shares, begins, starts, at }
    }

    fn at(&self, vertex: u32) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range =
            self.starts[vertex as usize] as usize..self.starts[vertex as usize + 1] as usize;
        self.at[range].iter().map(|(row, share)| (*row as usize, *share))
    }

    fn row(&self, ghost: usize) -> &'a [(u32, f64)] {
        &self.shares[self.begins[ghost] as usize..self.begins[ghost + 1] as usize]
    }
}

/// A row that is mostly zeros.
struct Row {
    entries: Vec<f64>,
    is_touched: Vec<bool>,
    touched: Vec<u32>,
}

impl Row {
    fn new(vertices: usize) -> Self {
        let (entries, is_touched) = (vec![0.0; vertices], vec![false; vertices]);
        Self { entries, is_touched, touched: Vec::new() }
    }

    fn add(&mut self, vertex: u32, entry: f64) {
        if !std::mem::replace(&mut self.is_touched[vertex as usize], true) {
            self.touched.push(vertex);
        }
        self.entries[vertex as usize] += entry;
    }

    /// All entries, rising by vertex; the row is then empty.
    fn drain(&mut self, mut visit: impl FnMut(u32, f64)) {
        self.touched.sort_unstable();
        for vertex in self.touched.drain(..) {
            self.is_touched[vertex as usize] = false;
            visit(vertex, std::mem::take(&mut self.entries[vertex as usize]));
        }
    }
}
