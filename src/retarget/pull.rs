//! The right-hand side: what targets, known joints and rotations pull the unknowns towards.

use nalgebra::Matrix3;

use super::rotations::best_rotation;
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

    pub(super) fn reset_rotations(&self, workspace: &mut Workspace) {
        let Workspace { coefficients, rotations, sizes, reference, .. } = workspace;
        rotations.fill(Matrix3::identity());
        for (vertex, size) in sizes.iter_mut().enumerate() {
            let edges = self.pattern.row(vertex).filter(|(_, column)| *column != vertex);
            *size = edges
                .map(|(entry, column)| {
                    -coefficients[entry] * (reference[vertex] - reference[column]).norm_squared()
                })
                .sum();
        }
    }

    /// The local step: every neighbourhood's rotation, and its pull on the next solve.
    pub(super) fn turn(&self, workspace: &mut Workspace, positions: &[Point]) {
        let Workspace { coefficients, rotations, sizes, reference, rhs, .. } = workspace;
        let memory = self.settings.rotation_memory;
        for (vertex, rotation) in rotations.iter_mut().enumerate() {
            let edges = || {
                self.pattern.row(vertex).filter(|(_, column)| *column != vertex).map(
                    |(entry, column)| {
                        (column, -coefficients[entry], reference[vertex] - reference[column])
                    },
                )
            };
            let mut covariance = *rotation * (memory * sizes[vertex]);
            for (column, weight, edge) in edges() {
                let turned = positions[vertex] - positions[column];
                covariance += turned * (weight * edge).transpose();
            }
            *rotation = best_rotation(&covariance, rotation);
            let own = self.pattern.unknown(vertex);
            for (column, weight, edge) in edges() {
                let (turned, other) = (*rotation * edge, self.pattern.unknown(column));
                let weight = self.settings.laplacian_weight * weight;
                if let Some(at) = own {
                    let known = other.map_or(positions[column].coords, |_| Vector::zeros());
                    rhs[at] += weight * (turned + known);
                }
                if let Some(at) = other {
                    let known = own.map_or(positions[vertex].coords, |_| Vector::zeros());
                    rhs[at] += weight * (known - turned);
                }
            }
        }
    }
}
