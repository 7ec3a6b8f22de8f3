//! The normal equations of the energy, kept in a band: pattern once, numbers per mesh.
//!
//! Unknowns are the joints that are not [`Constraint::Fixed`], frame by frame. A Laplacian row
//! joins a frame with its two neighbours in time, so `AᵀA` couples frames k, k±1 and, for the same
//! joint, k±2: with `u` unknown joints a frame the half-bandwidth is `2u` (DESIGN 4.2), times
//! three where x, y and z are coupled; in the edge form of `local_global` it is `u`.

use std::sync::Arc;

use nalgebra::Matrix3;

use super::band::BandMatrix;
use super::settings::{Constraint, Transform};
use crate::geometry::{Point, Vector};
use crate::mesh::Topology;

/// Marks a vertex that is no unknown.
const KNOWN: u32 = u32::MAX;

/// Who is unknown, and where everything is stored: fixed while topology, frames and constraints
/// are.
#[derive(Debug, Clone)]
pub(super) struct Pattern {
    pub(super) topology: Arc<Topology>,
    pub(super) constraints: Box<[Constraint]>,
    /// The unknown a space-time vertex is, or [`KNOWN`].
    unknowns: Box<[u32]>,
    /// Rows of neighbours, the vertex itself among them, rising: `offsets[i]..offsets[i + 1]`.
    offsets: Box<[u32]>,
    columns: Box<[u32]>,
    /// Vertices whose row holds an unknown, rising: no other row can move the solution.
    pub(super) open_rows: Box<[u32]>,
    /// Space-time bones `[parent, child, bone]` with at least one unknown end.
    pub(super) bones: Box<[[u32; 3]]>,
    pub(super) unknown_count: usize,
    /// In vertices, not in coordinates.
    half_bandwidth: usize,
}

impl Pattern {
    pub(super) fn new(
        topology: Arc<Topology>,
        constraints: &[Constraint],
        transform: Transform,
    ) -> Self {
        let per_frame = topology.pair().len();
        let frames = constraints.len() / per_frame;
        let mut unknown_count = 0;
        let unknowns: Box<[u32]> = constraints
            .iter()
            .map(|constraint| match constraint {
                Constraint::Fixed => KNOWN,
                Constraint::Free | Constraint::Soft(_) => {
                    unknown_count += 1;
                    unknown_count as u32 - 1
                }
            })
            .collect();
        let mut offsets = vec![0u32];
        let mut columns: Vec<u32> = Vec::new();
        for vertex in 0..constraints.len() {
            let (frame, joint) = (vertex / per_frame, vertex % per_frame);
            let row = columns.len();
            if frame > 0 {
                columns.push((vertex - per_frame) as u32);
            }
            let neighbours = topology.neighbours(joint).map(|(j, _)| frame * per_frame + j);
            columns.extend(neighbours.map(|j| j as u32));
            if frame + 1 < frames {
                columns.push((vertex + per_frame) as u32);
            }
            columns.push(vertex as u32);
            columns[row..].sort_unstable();
            offsets.push(columns.len() as u32);
        }
        let bones = (0..frames).flat_map(|frame| {
            topology.pair().bones().enumerate().map(move |(bone, ends)| {
                let [parent, child] = ends.map(|v| (frame * per_frame + v.index()) as u32);
                [parent, child, bone as u32]
            })
        });
        let open = |v: u32| unknowns[v as usize] != KNOWN;
        let bones = bones.filter(|[parent, child, _]| open(*parent) || open(*child)).collect();
        let mut pattern = Self {
            topology,
            constraints: constraints.into(),
            unknowns,
            offsets: offsets.into(),
            columns: columns.into(),
            open_rows: Box::default(),
            bones,
            unknown_count,
            half_bandwidth: 0,
        };
        let is_open = |vertex: &u32| pattern.is_open(*vertex as usize);
        pattern.open_rows = (0..constraints.len() as u32).filter(is_open).collect();
        pattern.half_bandwidth = pattern.measure(transform);
        pattern
    }

    /// The farthest that two coupled unknowns stand apart.
    fn measure(&self, transform: Transform) -> usize {
        let mut widest = 0;
        for vertex in 0..self.constraints.len() {
            let coupled = self.row(vertex).filter_map(|(_, column)| self.unknown(column));
            if transform == Transform::LocalGlobal {
                let Some(own) = self.unknown(vertex) else { continue };
                widest = coupled.fold(widest, |widest, other| widest.max(own.abs_diff(other)));
            } else {
                // All of a row's vertices couple with each other; columns and so unknowns rise.
                let (mut first, mut last) = (None, None);
                for unknown in coupled {
                    first = first.or(Some(unknown));
                    last = Some(unknown);
                }
                widest = widest.max(first.zip(last).map_or(0, |(first, last)| last - first));
            }
        }
        widest
    }

    /// The unknown that a vertex is, if it is one.
    #[inline]
    pub(super) fn unknown(&self, vertex: usize) -> Option<usize> {
        let unknown = self.unknowns[vertex];
        (unknown != KNOWN).then_some(unknown as usize)
    }

    /// Whether a vertex' row holds an unknown.
    pub(super) fn is_open(&self, vertex: usize) -> bool {
        self.row(vertex).any(|(_, column)| self.unknown(column).is_some())
    }

    /// `(entry, column)` of a vertex' row: itself and its neighbours, rising.
    #[inline]
    pub(super) fn row(&self, vertex: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let row = self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize;
        row.clone().zip(&self.columns[row]).map(|(entry, column)| (entry, *column as usize))
    }

    /// How many entries all rows have.
    pub(super) fn entries(&self) -> usize {
        self.columns.len()
    }

    /// A matrix with room for this pattern, of `axes` coordinates a vertex.
    pub(super) fn matrix(&self, axes: usize) -> BandMatrix {
        let reach = axes * self.half_bandwidth + (axes - 1);
        BandMatrix::new(axes * self.unknown_count, reach)
    }

    /// The vertex of an unknown, for messages.
    pub(super) fn vertex_of(&self, unknown: usize) -> usize {
        self.unknowns.iter().position(|u| *u as usize == unknown).unwrap_or(0)
    }

    /// Adds soft constraints and bones, whose numbers depend on the weights alone.
    pub(super) fn add_constraints(
        &self,
        matrix: &mut BandMatrix,
        axes: usize,
        known_weight: f64,
        bone_weight: f64,
    ) {
        for (vertex, constraint) in self.constraints.iter().enumerate() {
            if let (Constraint::Soft(weight), Some(at)) = (constraint, self.unknown(vertex)) {
                add_scaled_identity(matrix, axes, at, at, known_weight * weight);
            }
        }
        for [parent, child, _] in &self.bones {
            let ends = [*parent, *child].map(|v| self.unknown(v as usize));
            for end in ends.into_iter().flatten() {
                add_scaled_identity(matrix, axes, end, end, bone_weight);
            }
            if let [Some(a), Some(b)] = ends {
                add_scaled_identity(matrix, axes, a.max(b), a.min(b), -bone_weight);
            }
        }
    }

    /// Adds `w_l LᵢᵀLᵢ` of one vertex' row of the scalar Laplacian with these coefficients;
    /// a negative `w_l` takes it away.
    pub(super) fn add_scalar_row(
        &self,
        matrix: &mut BandMatrix,
        coefficients: &[f64],
        vertex: usize,
        w_l: f64,
    ) {
        for (a, row) in self.row(vertex) {
            let Some(row) = self.unknown(row) else { continue };
            let scaled = w_l * coefficients[a];
            if scaled == 0.0 {
                continue;
            }
            // Rising columns: everything up to `a` is in the lower half.
            for (b, column) in self.row(vertex).take_while(|(b, _)| *b <= a) {
                if let Some(column) = self.unknown(column) {
                    matrix.add(row, column, scaled * coefficients[b]);
                }
            }
        }
    }

    /// As [`Self::add_scalar_row`], where each coefficient `cᵢⱼ` has grown to a 3×3 block, which
    /// is zero where the coefficient is.
    pub(super) fn add_block_row(
        &self,
        matrix: &mut BandMatrix,
        (coefficients, blocks): (&[f64], &[Matrix3<f64>]),
        vertex: usize,
        w_l: f64,
    ) {
        for (a, row) in self.row(vertex) {
            let Some(row) = self.unknown(row).filter(|_| coefficients[a] != 0.0) else { continue };
            let left = blocks[a].transpose() * w_l;
            for (b, column) in self.row(vertex).take_while(|(b, _)| *b <= a) {
                let column = self.unknown(column).filter(|_| coefficients[b] != 0.0);
                let Some(column) = column else { continue };
                let product = left * blocks[b];
                for i in 0..3 {
                    let last = if row == column { i + 1 } else { 3 };
                    for j in 0..last {
                        matrix.add(3 * row + i, 3 * column + j, product[(i, j)]);
                    }
                }
            }
        }
    }

    /// Adds one vertex' `w_l Σⱼ w̄ᵢⱼ (vᵢ − vⱼ)²`, the edge form; `coefficients` hold `−w̄ᵢⱼ`.
    pub(super) fn add_edge_row(
        &self,
        matrix: &mut BandMatrix,
        coefficients: &[f64],
        vertex: usize,
        w_l: f64,
    ) {
        let own = self.unknown(vertex);
        for (entry, column) in self.row(vertex).filter(|(_, column)| *column != vertex) {
            let weight = -w_l * coefficients[entry];
            if weight == 0.0 {
                continue;
            }
            let other = self.unknown(column);
            for end in [own, other].into_iter().flatten() {
                matrix.add(end, end, weight);
            }
            if let (Some(a), Some(b)) = (own, other) {
                matrix.add(a.max(b), a.min(b), -weight);
            }
        }
    }

    /// Calls `add(unknown, vector)` for the bones' share of the right-hand side at `positions`:
    /// `± w_b l u`, known ends moved to the right.
    pub(super) fn bone_pull(
        &self,
        positions: &[Point],
        lengths: &[f64],
        bone_weight: f64,
        mut add: impl FnMut(usize, Vector),
    ) {
        for [parent, child, bone] in &self.bones {
            let (parent, child) = (*parent as usize, *child as usize);
            let along = positions[child] - positions[parent];
            let length = along.norm();
            // A bone of no length has no direction to keep: it pulls nowhere for one step.
            let target = if length > 0.0 {
                along * (lengths[*bone as usize] / length)
            } else {
                Vector::zeros()
            };
            if let Some(at) = self.unknown(child) {
                let known =
                    self.unknown(parent).map_or(positions[parent].coords, |_| Vector::zeros());
                add(at, bone_weight * (target + known));
            }
            if let Some(at) = self.unknown(parent) {
                let known =
                    self.unknown(child).map_or(positions[child].coords, |_| Vector::zeros());
                add(at, bone_weight * (known - target));
            }
        }
    }
}

fn add_scaled_identity(
    matrix: &mut BandMatrix,
    axes: usize,
    row: usize,
    column: usize,
    value: f64,
) {
    for axis in 0..axes {
        matrix.add(axes * row + axis, axes * column + axis, value);
    }
}
