//! Each neighbourhood's linearised similarity as a part of the linear system (Sorkine et al. 2004).
//!
//! `Tᵢ δᵢ = s δᵢ + h × δᵢ`, where `(s, h, t)` fits the neighbourhood's new places best:
//! `argmin Σⱼ w̄ⱼ ‖s qⱼ + h × qⱼ + t − v'ⱼ‖²`, the centre with weight 1 (Thai 2014, eq. 2.27 with
//! two rows of its A corrected). With `q` measured from the weighted centroid the seven normal
//! equations fall apart: `s = Σ w̄ q·v' / Σ w̄ q·q` and `h = J⁻¹ Σ w̄ q × v'`, where
//! `J = Σ w̄ (|q|² I − q qᵀ)` is the inertia tensor.

use nalgebra::Matrix3;

use crate::geometry::Vector;

/// An inertia tensor is singular where its determinant is below this share of its trace's cube:
/// the neighbourhood is straight and its roll about itself unknown.
const STRAIGHT: f64 = 1e-10;

/// The linear map from a neighbourhood's new places to its `Tᵢ δᵢ`.
pub(super) struct Similarity {
    /// `Σ w̄ q·q`.
    size: f64,
    /// `J⁻¹`.
    inverse: Matrix3<f64>,
    /// `δ / Σ w̄ q·q`.
    stretch: Vector,
    /// `[δ]ₓ J⁻¹`.
    turn: Matrix3<f64>,
}

/// What changes with a neighbour's weight: `∂/∂w` of centroid, `δ` and `Σ w̄ q qᵀ`.
pub(super) struct SimilarityChange {
    pub(super) centroid: Vector,
    pub(super) delta: Vector,
    pub(super) spread: Matrix3<f64>,
}

impl Similarity {
    /// - `neighbourhood`: `(q, w̄)`, places `[m]` from the weighted centroid, the centre included.
    /// - `delta`: the Laplacian coordinate `[m]`.
    pub(super) fn new(neighbourhood: impl Iterator<Item = (Vector, f64)>, delta: Vector) -> Self {
        let mut spread = Matrix3::zeros();
        for (q, weight) in neighbourhood {
            spread += weight * q * q.transpose();
        }
        let size = spread.trace();
        let stretch = if size > 0.0 { delta / size } else { Vector::zeros() };
        let inverse = pseudo_inverse(&(Matrix3::identity() * size - spread));
        Self { size, inverse, stretch, turn: delta.cross_matrix() * inverse }
    }

    /// `T δ` of places whose moments are known: `Σ w̄ q·v'` and `Σ w̄ q × v'`.
    pub(super) fn apply(&self, along: f64, around: Vector) -> Vector {
        self.stretch * along - self.turn * around
    }

    /// `∂(T δ)/∂w` of the similarity itself and its arms `q`, the moments' own weights staying.
    ///
    /// - `along`, `around`: as [`Self::apply`] takes them.
    /// - `sum`: `Σ w̄ v'`.
    ///
    /// Where the neighbourhood is straight its roll, which is unknown, is taken to stay so.
    pub(super) fn changed(
        &self,
        change: &SimilarityChange,
        delta: Vector,
        (along, around): (f64, Vector),
        sum: Vector,
    ) -> Vector {
        if self.size <= 0.0 {
            return Vector::zeros();
        }
        let size = change.spread.trace();
        let inertia = Matrix3::identity() * size - change.spread;
        let stretch = change.delta / self.size - delta * (size / (self.size * self.size));
        let turn = change.delta.cross_matrix() * self.inverse
            - delta.cross_matrix() * self.inverse * inertia * self.inverse;
        stretch * along - turn * around
            - self.apply(change.centroid.dot(&sum), change.centroid.cross(&sum))
    }

    /// The 3×3 block by which a neighbour at `q` `[m]` with weight `w̄` moves `Tᵢ δᵢ`.
    pub(super) fn block(&self, q: Vector, weight: f64) -> Matrix3<f64> {
        weight * (self.stretch * q.transpose() - self.turn * q.cross_matrix())
    }
}

/// The inverse on the directions the neighbourhood spans; no turn about any other.
fn pseudo_inverse(inertia: &Matrix3<f64>) -> Matrix3<f64> {
    let trace = inertia.trace();
    if inertia.determinant() > STRAIGHT * trace.powi(3)
        && let Some(inverse) = inertia.try_inverse()
    {
        return inverse;
    }
    let eigen = inertia.symmetric_eigen();
    let mut inverse = Matrix3::zeros();
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value > STRAIGHT * trace {
            inverse += vector * vector.transpose() / *value;
        }
    }
    inverse
}
