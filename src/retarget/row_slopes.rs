//! How one row of the operator answers to the weights in it.
//!
//! A neighbour's weight stands in its own `w̄ᵢⱼ = wᵢⱼ / Σ w` and, through the sum, in all others of
//! the row: `∂(Σ w̄ f)/∂wᵢⱼ = (fⱼ − Σ w̄ f) / Σ w` for any `f` over the neighbours.

use nalgebra::Matrix3;

use super::implicit::{Similarity, SimilarityChange};
use super::solve::Retargeter;
use super::settings::Transform;
use crate::geometry::Vector;
use crate::mesh::InteractionMesh;

/// A vertex' row, with `x` on all vertices put through it.
pub(super) struct Row<'a> {
    vertex: usize,
    mesh: &'a InteractionMesh,
    /// `Σ w` `[-]`.
    total: f64,
    /// `Σ w̄ x` over the neighbours.
    mean: Vector,
    turning: Option<Turning>,
}

/// The `T` of the transform `implicit`.
struct Turning {
    similarity: Similarity,
    /// Of the neighbourhood, from the vertex.
    centroid: Vector,
    delta: Vector,
    /// `Σ w̄ q qᵀ` over the neighbours, without the centre.
    spread: Matrix3<f64>,
    /// `Σ w̄ q·x` and `Σ w̄ q × x` over the neighbours, without the centre.
    moments: (f64, Vector),
    /// The centre's share of those, whose weight is always 1.
    of_centre: (f64, Vector),
    /// `Σ w̄ x`, the centre included.
    sum: Vector,
}

impl Retargeter {
    /// Puts `x`, one per vertex, through a vertex' row.
    pub(super) fn row_of<'a>(
        &self,
        mesh: &'a InteractionMesh,
        vertex: usize,
        x: &[Vector],
    ) -> Row<'a> {
        let places = mesh.positions();
        let mut mean = Vector::zeros();
        mesh.for_each_neighbour(vertex, |neighbour, weight| mean += weight * x[neighbour]);
        let turning = (self.settings.transform == Transform::Implicit).then(|| {
            let mut sum = Vector::zeros();
            mesh.for_each_neighbour(vertex, |j, w| sum += w * (places[j] - places[vertex]));
            // The centre weighs 1, as all neighbours together.
            let centroid = sum / 2.0;
            let (mut along, mut around, mut spread) = (0.0, Vector::zeros(), Matrix3::zeros());
            let mut neighbourhood = vec![(-centroid, 1.0)];
            mesh.for_each_neighbour(vertex, |j, w| {
                let q = places[j] - places[vertex] - centroid;
                along += w * q.dot(&x[j]);
                around += w * q.cross(&x[j]);
                spread += w * q * q.transpose();
                neighbourhood.push((q, w));
            });
            Turning {
                similarity: Similarity::new(neighbourhood.into_iter(), -sum),
                centroid,
                delta: -sum,
                spread,
                moments: (along, around),
                of_centre: (-centroid.dot(&x[vertex]), -centroid.cross(&x[vertex])),
                sum: mean + x[vertex],
            }
        });
        Row { vertex, mesh, total: mesh.total_weight(vertex), mean, turning }
    }
}

impl Row<'_> {
    /// What the row makes of `x`.
    pub(super) fn value(&self, x: &[Vector]) -> Vector {
        let turned = self.turning.as_ref().map_or(Vector::zeros(), |turning| {
            let (along, around) = turning.all_moments();
            turning.similarity.apply(along, around)
        });
        x[self.vertex] - self.mean - turned
    }

    /// The derivative of [`Self::value`] by the weight of a neighbour.
    pub(super) fn slope(&self, neighbour: usize, x: &[Vector]) -> Vector {
        let plain = (x[neighbour] - self.mean) / self.total;
        let turned = self.turning.as_ref().map_or(Vector::zeros(), |turning| {
            let places = self.mesh.positions();
            let p = places[neighbour] - places[self.vertex];
            turning.slope(p, x[neighbour], self.total)
        });
        -plain - turned
    }
}

impl Turning {
    fn all_moments(&self) -> (f64, Vector) {
        (self.moments.0 + self.of_centre.0, self.moments.1 + self.of_centre.1)
    }

    /// `∂(T δ)/∂w` by the weight of a neighbour at `p` from the vertex, whose `x` this is.
    fn slope(&self, p: Vector, x: Vector, total: f64) -> Vector {
        let q = p - self.centroid;
        let change = SimilarityChange {
            centroid: (p - 2.0 * self.centroid) / (2.0 * total),
            delta: -(p - 2.0 * self.centroid) / total,
            spread: (q * q.transpose() - self.spread) / total,
        };
        let (along, around) = self.moments;
        let own = self
            .similarity
            .apply((q.dot(&x) - along) / total, (q.cross(&x) - around) / total);
        own + self.similarity.changed(&change, self.delta, self.all_moments(), self.sum)
    }
}
