//! How a converged solution answers to the weights of its edges.
//!
//! At the solution the energy's gradient vanishes: `g(v') = A v' − c − w_b Σ± l u(v') = 0`. So
//! `∂d/∂w = −λ·∂g/∂w` with `(A − w_b J) λ = ∂d/∂v'`, where `A` is the matrix of the steps and
//! `J = Σ (l/‖e‖)(I − u uᵀ)` what turning bones give way (DESIGN 4.4; leaving `J` out is wrong by
//! 11-91 %). One `λ` serves all edges. Both that system and Newton's, which has the same matrix,
//! are solved by conjugate gradients with the factor of `A` for preconditioner: its eigenvalues
//! then lie below 1.

use super::prepared::{Prepared, Variation};
use super::settings::{Constraint, Transform};
use super::RetargetError;
use crate::geometry::{Point, Vector};

/// Newton steps at most; a handful is usual.
const NEWTON_STEPS: usize = 60;

/// A Newton step that moves no coordinate farther `[m]` is taken unasked.
const SMALL_STEP: f64 = 1e-6;

/// Conjugate-gradient steps at most.
const CONJUGATE_STEPS: usize = 2000;

/// To which share `[-]` the residual falls, in the norm of `A⁻¹`, in the system of a Newton step:
/// the next step makes good what is left.
const NEWTON_TOLERANCE: f64 = 1e-4;

/// As [`NEWTON_TOLERANCE`], in the adjoint system, whose solution is final.
const ADJOINT_TOLERANCE: f64 = 1e-12;

/// The rotations of `local_global` follow the solution in a way of which no derivative is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("retarget.transform is local_global: derivatives by edge weights need none or implicit")]
pub struct NoDerivative;

impl Prepared {
    /// Solves until no coordinate is farther than about `tolerance` `[m]` from the solution,
    /// whatever steps and tolerance the settings allow.
    ///
    /// Returns how far the last step went `[m]`.
    ///
    /// # Errors
    /// [`RetargetError::Unanchored`].
    /// # Panics
    /// If the transform is `local_global`: its steps have another matrix.
    pub fn converge(&self, tolerance: f64, room: &mut Variation) -> Result<f64, RetargetError> {
        assert!(self.transform() != Transform::LocalGlobal, "no Newton step for local_global");
        self.solve(room)?;
        let mut last = f64::INFINITY;
        for _ in 0..NEWTON_STEPS {
            let residual = self.residual(room.solved());
            let mut step = self.conjugate_gradients(&residual, NEWTON_TOLERANCE, room);
            let size = |step: &[Vector]| step.iter().map(Vector::amax).fold(0.0, f64::max);
            let (start, before) = (room.solved.clone(), self.energy(room.solved()));
            self.advance(&step, &mut room.solved);
            // A step this small is of the last few, where rounding hides how the energy falls.
            while size(&step) > SMALL_STEP && self.energy(room.solved()) > before {
                step.iter_mut().for_each(|s| *s *= 0.5);
                room.solved.copy_from_slice(&start);
                self.advance(&step, &mut room.solved);
            }
            let previous = std::mem::replace(&mut last, size(&step));
            // Newton's steps shrink fast until rounding is all that is left of them.
            if last <= tolerance || (last <= SMALL_STEP && last > 0.5 * previous) {
                break;
            }
        }
        Ok(last)
    }

    fn energy(&self, positions: &[Point]) -> f64 {
        let Self { retargeter, mesh, targets, lengths, workspace } = self;
        retargeter.energy(mesh, targets, lengths, workspace, positions)
    }

    /// `∂d/∂w` of some edges in every frame, at the converged solution in `room`.
    ///
    /// - `slope`: `∂d/∂v'` `[-]`, `frames × vertices`; read where a joint is unknown.
    /// - `edges`: their places in the topology's edges.
    ///
    /// Returns `edges × frames` `[m]`.
    ///
    /// # Errors
    /// [`NoDerivative`] if the transform is `local_global`.
    pub fn slopes(
        &self,
        slope: &[Vector],
        edges: &[usize],
        room: &mut Variation,
    ) -> Result<Vec<f64>, NoDerivative> {
        if self.transform() == Transform::LocalGlobal {
            return Err(NoDerivative);
        }
        let unknown = self.unknowns(|vertex| slope[vertex]);
        let adjoint = self.conjugate_gradients(&unknown, ADJOINT_TOLERANCE, room);
        let vertices = self.targets.len();
        let pattern = &self.retargeter.pattern;
        let on_all = |x: &dyn Fn(usize) -> Vector| (0..vertices).map(x).collect::<Vec<Vector>>();
        let adjoint = on_all(&|vertex| {
            pattern.unknown(vertex).map_or(Vector::zeros(), |at| adjoint[at])
        });
        // What the rows make small: `implicit` has δ in its rows, `none` takes it from the reference.
        let kept = match self.transform() {
            Transform::Implicit => on_all(&|vertex| room.solved[vertex].coords),
            _ => on_all(&|vertex| room.solved[vertex] - self.workspace.reference[vertex]),
        };
        let topology = self.mesh.topology();
        let per_frame = topology.pair().len();
        let w_l = self.retargeter.settings.laplacian_weight;
        let mut ends: Vec<[usize; 2]> = Vec::with_capacity(edges.len() * self.mesh.frames());
        for edge in edges {
            let joints = topology.edges()[*edge].ends().map(|end| end.index());
            ends.extend((0..self.mesh.frames()).map(|k| joints.map(|joint| k * per_frame + joint)));
        }
        let mut slopes = vec![0.0; ends.len()];
        // Row by row: many edges end at one vertex.
        let mut halves: Vec<(usize, usize, usize)> = ends
            .iter()
            .enumerate()
            .flat_map(|(at, [a, b])| [(*a, *b, at), (*b, *a, at)])
            .collect();
        halves.sort_unstable();
        for of_vertex in halves.chunk_by(|one, next| one.0 == next.0) {
            let vertex = of_vertex[0].0;
            let row = |x: &[Vector]| self.retargeter.row_of(&self.mesh, vertex, x);
            let (of_adjoint, of_kept) = (row(&adjoint), row(&kept));
            let (by_adjoint, by_kept) = (of_adjoint.value(&adjoint), of_kept.value(&kept));
            for (_, other, at) in of_vertex {
                slopes[*at] -= w_l
                    * (of_adjoint.slope(*other, &adjoint).dot(&by_kept)
                        + by_adjoint.dot(&of_kept.slope(*other, &kept)));
            }
        }
        Ok(slopes)
    }

    fn transform(&self) -> Transform {
        self.retargeter.settings.transform
    }

    /// A value for each unknown, by its vertex.
    fn unknowns(&self, value: impl Fn(usize) -> Vector) -> Vec<Vector> {
        let constraints = self.retargeter.pattern.constraints.iter().enumerate();
        let open = constraints.filter(|(_, constraint)| **constraint != Constraint::Fixed);
        open.map(|(vertex, _)| value(vertex)).collect()
    }

    /// Adds a step to the unknowns.
    fn advance(&self, step: &[Vector], positions: &mut [Point]) {
        for (vertex, position) in positions.iter_mut().enumerate() {
            if let Some(at) = self.retargeter.pattern.unknown(vertex) {
                *position += step[at];
            }
        }
    }

    /// `c + w_b Σ± l u(v') − A v'`: minus the energy's gradient, halved.
    fn residual(&self, positions: &[Point]) -> Vec<Vector> {
        let retargeter = &self.retargeter;
        let places = self.unknowns(|vertex| positions[vertex].coords);
        let product = self.multiply(&places);
        let constant = self.workspace.constant.iter().zip(product);
        let mut residual: Vec<Vector> = constant.map(|(c, product)| c - product).collect();
        let weight = retargeter.settings.bone_weight;
        retargeter
            .pattern
            .bone_pull(positions, &self.lengths, weight, |at, pull| residual[at] += pull);
        residual
    }

    /// `A x`.
    fn multiply(&self, x: &[Vector]) -> Vec<Vector> {
        let matrix = &self.workspace.matrix;
        if self.retargeter.axes() == 1 {
            let columns: Vec<[f64; 3]> = x.iter().map(|x| [x.x, x.y, x.z]).collect();
            matrix.multiply(&columns).into_iter().map(Vector::from).collect()
        } else {
            let stacked: Vec<[f64; 1]> =
                x.iter().flat_map(|x| [[x.x], [x.y], [x.z]]).collect();
            let product = matrix.multiply(&stacked);
            product.chunks_exact(3).map(|p| Vector::new(p[0][0], p[1][0], p[2][0])).collect()
        }
    }

    /// `A⁻¹ x` by the factor in `room`.
    fn precondition(&self, x: &[Vector], room: &Variation) -> Vec<Vector> {
        let factor = &room.workspace.matrix;
        if self.retargeter.axes() == 1 {
            let mut columns: Vec<[f64; 4]> = x.iter().map(|x| [x.x, x.y, x.z, 0.0]).collect();
            factor.solve(&mut columns);
            columns.into_iter().map(|c| Vector::new(c[0], c[1], c[2])).collect()
        } else {
            let mut stacked: Vec<[f64; 1]> =
                x.iter().flat_map(|x| [[x.x], [x.y], [x.z]]).collect();
            factor.solve(&mut stacked);
            stacked.chunks_exact(3).map(|p| Vector::new(p[0][0], p[1][0], p[2][0])).collect()
        }
    }

    /// `(A − w_b J) x` at `positions`.
    fn curvature(&self, x: &[Vector], positions: &[Point]) -> Vec<Vector> {
        let mut product = self.multiply(x);
        let pattern = &self.retargeter.pattern;
        for [parent, child, bone] in &pattern.bones {
            let (parent, child) = (*parent as usize, *child as usize);
            let along = positions[child] - positions[parent];
            let length = along.norm();
            if length == 0.0 {
                continue;
            }
            let ends = [parent, child].map(|vertex| pattern.unknown(vertex));
            let at = |end: Option<usize>| end.map_or(Vector::zeros(), |at| x[at]);
            let apart = at(ends[1]) - at(ends[0]);
            let direction = along / length;
            let turned = apart - direction * direction.dot(&apart);
            let weight = self.retargeter.settings.bone_weight * self.lengths[*bone as usize];
            let pull = turned * (weight / length);
            if let Some(at) = ends[1] {
                product[at] -= pull;
            }
            if let Some(at) = ends[0] {
                product[at] += pull;
            }
        }
        product
    }

    /// `(A − w_b J)⁻¹ b` at the solution in `room`; where the curvature is negative (bones pressed
    /// together, far from a solution) the best direction found before.
    fn conjugate_gradients(
        &self,
        b: &[Vector],
        tolerance: f64,
        room: &Variation,
    ) -> Vec<Vector> {
        let mut x = vec![Vector::zeros(); b.len()];
        let mut residual = b.to_vec();
        let mut preconditioned = self.precondition(&residual, room);
        let mut direction = preconditioned.clone();
        let mut size = dot(&residual, &preconditioned);
        let goal = size * tolerance * tolerance;
        for step in 0..CONJUGATE_STEPS {
            if size <= goal {
                break;
            }
            let product = self.curvature(&direction, room.solved());
            let curvature = dot(&direction, &product);
            if curvature <= 0.0 {
                return if step == 0 { direction } else { x };
            }
            let length = size / curvature;
            add_scaled(&mut x, length, &direction);
            add_scaled(&mut residual, -length, &product);
            preconditioned = self.precondition(&residual, room);
            let next = dot(&residual, &preconditioned);
            let keep = next / size;
            size = next;
            for (direction, new) in direction.iter_mut().zip(&preconditioned) {
                *direction = new + *direction * keep;
            }
        }
        x
    }
}

fn dot(a: &[Vector], b: &[Vector]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

fn add_scaled(sum: &mut [Vector], scale: f64, step: &[Vector]) {
    sum.iter_mut().zip(step).for_each(|(sum, step)| *sum += *step * scale);
}
