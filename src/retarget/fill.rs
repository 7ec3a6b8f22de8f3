//! A mesh's numbers in the rows of the operator `L − T`.

use nalgebra::Matrix3;

use super::implicit::Similarity;
use super::settings::Transform;
use super::solve::Retargeter;
use crate::geometry::Vector;
use crate::mesh::InteractionMesh;

impl Retargeter {
    /// The numbers of one vertex' row, of both kinds where the transform needs both.
    pub(super) fn fill_row(
        &self,
        mesh: &InteractionMesh,
        vertex: usize,
        coefficients: &mut [f64],
        blocks: &mut [Matrix3<f64>],
    ) {
        self.fill_coefficients(mesh, vertex, coefficients);
        if self.settings.transform == Transform::Implicit {
            self.fill_blocks(mesh, vertex, coefficients, blocks);
        }
    }

    /// `1` for the vertex itself, `−w̄` for its neighbours.
    fn fill_coefficients(&self, mesh: &InteractionMesh, vertex: usize, coefficients: &mut [f64]) {
        let mut row = self.pattern.row(vertex);
        mesh.for_each_neighbour(vertex, |neighbour, weight| {
            for (entry, column) in row.by_ref() {
                if column == neighbour {
                    coefficients[entry] = -weight;
                    break;
                }
                coefficients[entry] = 1.0;
            }
        });
        for (entry, _) in row {
            coefficients[entry] = 1.0;
        }
    }

    /// `I − T` for the vertex itself, `−w̄ I − T` for its neighbours.
    fn fill_blocks(
        &self,
        mesh: &InteractionMesh,
        vertex: usize,
        coefficients: &[f64],
        blocks: &mut [Matrix3<f64>],
    ) {
        let positions = mesh.positions();
        let row = || {
            self.pattern.row(vertex).map(|(entry, column)| {
                // |1| for the centre, |−w̄| for the rest: the rows' squared weights.
                (entry, positions[column] - positions[vertex], coefficients[entry].abs())
            })
        };
        let (sum, weights) = row()
            .fold((Vector::zeros(), 0.0), |(sum, weights), (_, p, w)| (sum + w * p, weights + w));
        let centroid = sum / weights;
        // Σ w̄ is 1 over the neighbours, so δ is minus the weighted sum from the centre.
        let similarity = Similarity::new(row().map(|(_, p, w)| (p - centroid, w)), -sum);
        for (entry, p, weight) in row() {
            blocks[entry] =
                Matrix3::identity() * coefficients[entry] - similarity.block(p - centroid, weight);
        }
    }
}
