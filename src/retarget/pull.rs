//! The right-hand side: what targets, known joints and rotations pull the unknowns towards.

use super::settings::Constraint;
use super::solve::{Retargeter, Workspace};
use crate::geometry::{Point, Vector};
use crate::mesh::InteractionMesh;

impl Retargeter {
    pub(super) fn pull_of_targets(&self, targets: &[Point], pull: &mut [Vector]) {
        for (vertex, constraint) in self.pattern.constraints.iter().enumerate() {
            if let (Constraint::Soft(weight), Some(at)) = (constraint, self.pattern.unknown(vertex))
            {
                pull[at] += self.settings.known_weight * weight * targets[vertex].coords;
            }
        }
    }

    /// Adds a row's `w_l Lᵢᵀ (δᵢ − Lᵢ_K v_K)` to the right-hand side.
    pub(super) fn pull_of_scalar_row(
        &self,
        mesh: &InteractionMesh,
        targets: &[Point],
        vertex: usize,
        w_l: f64,
        workspace: &mut Workspace,
    ) {
        let Workspace { coefficients, constant, .. } = workspace;
        let mut open = Vector::zeros();
        for (entry, column) in self.pattern.row(vertex) {
            let place = match self.pattern.unknown(column) {
                Some(_) => mesh.positions()[column].coords,
                None => mesh.positions()[column] - targets[column],
            };
            open += coefficients[entry] * place;
        }
        for (entry, column) in self.pattern.row(vertex) {
            if let Some(at) = self.pattern.unknown(column) {
                constant[at] += w_l * coefficients[entry] * open;
            }
        }
    }

    /// Adds a row's `w_l Lᵢᵀ (0 − Lᵢ_K v_K)` with the blocks of `L − T`.
    pub(super) fn pull_of_block_row(
        &self,
        targets: &[Point],
        vertex: usize,
        w_l: f64,
        workspace: &mut Workspace,
    ) {
        let Workspace { blocks, constant, .. } = workspace;
        let mut open = Vector::zeros();
        for (entry, column) in self.pattern.row(vertex) {
            if self.pattern.unknown(column).is_none() {
                open -= blocks[entry] * targets[column].coords;
            }
        }
        for (entry, column) in self.pattern.row(vertex) {
            if let Some(at) = self.pattern.unknown(column) {
                constant[at] += w_l * blocks[entry].tr_mul(&open);
            }
        }
    }

    /// Adds what known ends of a row's edges hold the unknown ones to, in the edge form.
    pub(super) fn pull_of_edge_row(
        &self,
        targets: &[Point],
        vertex: usize,
        w_l: f64,
        workspace: &mut Workspace,
    ) {
        let Workspace { coefficients, constant, .. } = workspace;
        let own = self.pattern.unknown(vertex);
        for (entry, column) in self.pattern.row(vertex).filter(|(_, c)| *c != vertex) {
            let weight = -w_l * coefficients[entry];
            match (own, self.pattern.unknown(column)) {
                (Some(at), None) => constant[at] += weight * targets[column].coords,
                (None, Some(at)) => constant[at] += weight * targets[vertex].coords,
                _ => {}
            }
        }
    }
}
