//! What the steps bring down: the energy, and the bones' misses.

use nalgebra::Matrix3;

use super::settings::{Constraint, Transform};
use super::solve::{Retargeter, Workspace};
use crate::geometry::{Point, Vector, closest_rotation};
use crate::mesh::InteractionMesh;

impl Retargeter {
    /// The farthest an open bone is from its length `[m]`.
    pub(super) fn bone_error(&self, lengths: &[f64], positions: &[Point]) -> f64 {
        let bones = self.pattern.bones.iter().map(|[parent, child, bone]| {
            let along = positions[*child as usize] - positions[*parent as usize];
            (along.norm() - lengths[*bone as usize]).abs()
        });
        bones.fold(0.0, f64::max)
    }

    /// The energy `[m²]` of `positions` with true bones: what the steps bring down.
    ///
    /// Takes the coefficients and, for `local_global`, the rotations of the last
    /// [`Self::assemble`] and [`Self::solve`] in `workspace`; neighbourhoods without an unknown,
    /// which a solve never turns, count at their best rotation. Soft constraints and open bones
    /// count, bones between fixed joints do not.
    ///
    /// # Panics
    /// If shapes do not fit: the caller's bug.
    pub fn energy(
        &self,
        mesh: &InteractionMesh,
        targets: &[Point],
        lengths: &[f64],
        workspace: &Workspace,
        positions: &[Point],
    ) -> f64 {
        // Rows that hold no unknown stay out of the system, but they count.
        let (mut coefficients, mut blocks) =
            (workspace.coefficients.clone(), workspace.blocks.clone());
        let vertices = 0..self.pattern.constraints.len();
        for vertex in vertices.clone().filter(|vertex| !self.pattern.is_open(*vertex)) {
            self.fill_row(mesh, vertex, &mut coefficients, &mut blocks);
        }
        let mut laplacian = 0.0;
        for vertex in vertices {
            let row = self.pattern.row(vertex);
            laplacian += match self.settings.transform {
                Transform::None => {
                    let apply = |v: &[Point]| -> Vector {
                        self.pattern.row(vertex).map(|(e, c)| coefficients[e] * v[c].coords).sum()
                    };
                    (apply(positions) - apply(mesh.positions())).norm_squared()
                }
                Transform::Implicit => {
                    let off: Vector = row.map(|(e, c)| blocks[e] * positions[c].coords).sum();
                    off.norm_squared()
                }
                Transform::LocalGlobal => {
                    let edges = || {
                        self.pattern.row(vertex).filter(|(_, column)| *column != vertex).map(
                            |(entry, column)| {
                                let before =
                                    workspace.reference[vertex] - workspace.reference[column];
                                let now = positions[vertex] - positions[column];
                                (-coefficients[entry], before, now)
                            },
                        )
                    };
                    let best = || {
                        let terms = edges().map(|(weight, before, now)| {
                            let covariance: Matrix3<f64> = weight * now * before.transpose();
                            covariance
                        });
                        closest_rotation(&terms.sum())
                    };
                    let turned = workspace.neighbourhoods.rotation(vertex);
                    let rotation = turned.unwrap_or_else(best);
                    edges()
                        .map(|(weight, before, now)| {
                            weight * (now - rotation * before).norm_squared()
                        })
                        .sum()
                }
            };
        }
        let constraints = self.pattern.constraints.iter().zip(targets).zip(positions);
        let known: f64 = constraints
            .map(|((constraint, target), position)| match constraint {
                Constraint::Soft(weight) => weight * (position - target).norm_squared(),
                Constraint::Free | Constraint::Fixed => 0.0,
            })
            .sum();
        let bones: f64 = self
            .pattern
            .bones
            .iter()
            .map(|[parent, child, bone]| {
                let along = positions[*child as usize] - positions[*parent as usize];
                (along.norm() - lengths[*bone as usize]).powi(2)
            })
            .sum();
        self.settings.laplacian_weight * laplacian
            + self.settings.known_weight * known
            + self.settings.bone_weight * bones
    }
}
