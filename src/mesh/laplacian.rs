//! Laplacian coordinates: how each joint sits among its neighbours.

use std::sync::Arc;

use super::{EdgeWeights, MeshError, Topology, Vertex};
use crate::geometry::{Point, Vector, is_finite};

/// One interaction over a topology: positions and weights, checked to fit and to be finite.
///
/// A vertex of the space-time mesh is `frame · vertices + vertex`.
#[derive(Debug, Clone, PartialEq)]
pub struct InteractionMesh {
    topology: Arc<Topology>,
    positions: Vec<Point>,
    weights: EdgeWeights,
}

impl InteractionMesh {
    /// The only way in.
    ///
    /// - `positions`: `[m]`, `frames × vertices`, at least one frame.
    ///
    /// # Errors
    /// [`MeshError`] where shapes differ, a position is not finite or a weight is not usable.
    pub fn new(
        topology: Arc<Topology>,
        positions: Vec<Point>,
        weights: EdgeWeights,
    ) -> Result<Self, MeshError> {
        let vertices = topology.pair().len();
        let frames = positions.len() / vertices;
        if frames == 0 || frames * vertices != positions.len() {
            return Err(MeshError::Shape { got: positions.len(), frames: frames.max(1), vertices });
        }
        if let Some(at) = positions.iter().position(|p| !is_finite(p)) {
            return Err(MeshError::NotFinite { frame: at / vertices, joint: at % vertices });
        }
        weights.check(&topology, frames)?;
        Ok(Self { topology, positions, weights })
    }

    /// Who neighbours whom.
    pub fn topology(&self) -> &Arc<Topology> {
        &self.topology
    }

    /// How strongly.
    pub fn weights(&self) -> &EdgeWeights {
        &self.weights
    }

    /// Changes one edge's weights.
    ///
    /// - `edge`: its place in the topology's edges.
    /// - `weights`: `[-]`, one per frame, finite, ≥ 0.
    ///
    /// # Errors
    /// [`MeshError::Weight`] if one is not usable, or a vertex were left without any: the mesh is
    /// then as it was. [`MeshError::Shape`] if there is not one per frame.
    pub fn reweigh(&mut self, edge: usize, weights: &[f64]) -> Result<(), MeshError> {
        let frames = self.frames();
        if weights.len() != frames {
            return Err(MeshError::Shape { got: weights.len(), frames, vertices: 1 });
        }
        self.set(edge, |frame| weights[frame])
    }

    /// Takes an edge's weight away in all frames.
    ///
    /// # Errors
    /// [`MeshError::Weight`] if a vertex were left without any; the mesh is then as it was.
    pub fn switch_off(&mut self, edge: usize) -> Result<(), MeshError> {
        self.set(edge, |_| 0.0)
    }

    fn set(&mut self, edge: usize, weight: impl Fn(usize) -> f64) -> Result<(), MeshError> {
        let ends = self.topology.edges()[edge].ends();
        for frame in 0..self.frames() {
            let now = self.weights.frame(frame);
            let others = |vertex: usize| -> f64 {
                let others = self.topology.neighbours(vertex).filter(|(_, other)| *other != edge);
                self.weights.time() + others.map(|(_, other)| now[other]).sum::<f64>()
            };
            let new = weight(frame);
            let usable = new.is_finite() && new >= 0.0;
            let lonely = |end: &Vertex| new == 0.0 && others(end.index()) <= 0.0;
            if let Some(end) = ends.iter().find(|end| !usable || lonely(end)) {
                return Err(MeshError::Weight { frame, joint: end.index() });
            }
        }
        for frame in 0..self.frames() {
            self.weights.set(frame, edge, weight(frame));
        }
        Ok(())
    }

    /// Takes on other positions, the weights as they are; without allocation.
    ///
    /// - `positions`: `[m]`, `frames × vertices`, as many as there are.
    ///
    /// # Errors
    /// [`MeshError::NotFinite`], [`MeshError::Shape`]: the mesh is then as it was.
    pub fn set_positions(&mut self, positions: &[Point]) -> Result<(), MeshError> {
        let (vertices, frames) = (self.topology.pair().len(), self.frames());
        if positions.len() != self.positions.len() {
            return Err(MeshError::Shape { got: positions.len(), frames, vertices });
        }
        if let Some(at) = positions.iter().position(|p| !is_finite(p)) {
            return Err(MeshError::NotFinite { frame: at / vertices, joint: at % vertices });
        }
        self.positions.copy_from_slice(positions);
        Ok(())
    }

    /// Takes over one edge's weights from a mesh of the same topology and length.
    pub(crate) fn copy_weights(&mut self, other: &Self, edge: usize) {
        for frame in 0..self.frames() {
            self.weights.set(frame, edge, other.weights.get(frame, edge));
        }
    }

    /// `[m]`, `frames × vertices`.
    pub fn positions(&self) -> &[Point] {
        &self.positions
    }

    /// The number of frames, at least 1.
    pub fn frames(&self) -> usize {
        self.positions.len() / self.topology.pair().len()
    }

    /// `Σⱼ wᵢⱼ` `[-]` of a space-time vertex.
    pub fn total_weight(&self, vertex: usize) -> f64 {
        let vertices = self.topology.pair().len();
        let (frame, joint) = (vertex / vertices, vertex % vertices);
        let spatial = self.weights.frame(frame);
        let in_time = u8::from(frame > 0) + u8::from(frame + 1 < self.frames());
        self.topology.neighbours(joint).map(|(_, edge)| spatial[edge]).sum::<f64>()
            + self.weights.time() * f64::from(in_time)
    }

    /// Calls `visit(neighbour, w̄)` for the neighbours of a space-time vertex, rising: the frame
    /// before, the frame's own, the frame after. The `w̄` sum to 1.
    pub fn for_each_neighbour(&self, vertex: usize, mut visit: impl FnMut(usize, f64)) {
        let vertices = self.topology.pair().len();
        let (frame, joint) = (vertex / vertices, vertex % vertices);
        let spatial = self.weights.frame(frame);
        let (past, future) = (frame > 0, frame + 1 < self.frames());
        let time = self.weights.time();
        let total = self.total_weight(vertex);
        // A lone frame of a vertex without weight of its own has no neighbours at all.
        let scale = if total > 0.0 { 1.0 / total } else { 0.0 };
        if past {
            visit(vertex - vertices, time * scale);
        }
        for (neighbour, edge) in self.topology.neighbours(joint) {
            visit(frame * vertices + neighbour, spatial[edge] * scale);
        }
        if future {
            visit(vertex + vertices, time * scale);
        }
    }

    /// `δᵢ = vᵢ − Σⱼ w̄ᵢⱼ vⱼ` `[m]` of a space-time vertex (Thai 2014, 3.1).
    pub fn laplacian(&self, vertex: usize) -> Vector {
        let mut delta = Vector::zeros();
        let here = self.positions[vertex];
        self.for_each_neighbour(vertex, |j, weight| delta += weight * (here - self.positions[j]));
        delta
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Edge, Kernel, Pair};
    use super::*;
    use crate::skeleton::{Role, Skeleton};

    fn mesh(shift: Vector) -> InteractionMesh {
        let skeleton = Skeleton::nite();
        let pair = Arc::new(Pair::new([skeleton.clone(), skeleton]));
        let hands = Edge::new(
            pair.vertices(Role::First).nth(8).unwrap(),
            pair.vertices(Role::Second).nth(8).unwrap(),
        );
        let topology = Arc::new(Topology::new(pair, [hands]).unwrap());
        let positions: Vec<Point> = (0..90)
            .map(f64::from)
            .map(|i| Point::new(i.sin(), (1.7 * i).cos(), (0.3 * i).sin()) + shift)
            .collect();
        let kernel =
            Kernel::InverseDistance { scale: 3.0, power: 2.0, reference: 0.1, minimum: 0.05 };
        let weights = EdgeWeights::by_kernel(&topology, &positions, kernel, 0.5);
        InteractionMesh::new(topology, positions, weights).unwrap()
    }

    #[test]
    fn the_laplacian_ignores_translation_and_weights_sum_to_one() {
        let (here, there) = (mesh(Vector::zeros()), mesh(Vector::new(3.0, -2.0, 1.0)));
        for vertex in 0..90 {
            assert!((here.laplacian(vertex) - there.laplacian(vertex)).norm() < 1e-12);
            let mut sum = 0.0;
            let mut last = None;
            here.for_each_neighbour(vertex, |j, weight| {
                sum += weight;
                assert!(last < Some(j), "neighbours rise");
                last = Some(j);
            });
            assert!((sum - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_no_mesh_is_refused() {
        let good = mesh(Vector::zeros());
        let new = |p: Vec<Point>, w: EdgeWeights| InteractionMesh::new(good.topology.clone(), p, w);
        let mut positions = good.positions.clone();
        positions[31].y = f64::NAN;
        let error = new(positions, good.weights.clone()).unwrap_err();
        assert_eq!(error, MeshError::NotFinite { frame: 1, joint: 1 });
        assert!(new(good.positions[..89].to_vec(), good.weights.clone()).is_err());
        assert!(new(good.positions[..60].to_vec(), good.weights.clone()).is_err());
        for time in [f64::NAN, -1.0] {
            let weights =
                EdgeWeights::by_kernel(&good.topology, &good.positions, Kernel::Uniform, time);
            let error = new(good.positions.clone(), weights).unwrap_err();
            assert_eq!(error, MeshError::Weight { frame: 0, joint: 0 });
        }
    }
}
