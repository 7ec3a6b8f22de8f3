//! A system assembled once and solved for many weights of single edges: what learning tries.
//!
//! An edge's weight stands in the rows of its two ends, in every frame. Changing it takes those
//! rows out of the assembled normal equations and puts the new ones in; pattern, all other rows,
//! constraints and bones stay. The factorisation is made anew: the change has a rank of a few
//! times the number of frames, far more than updating a banded factor pays for (`benches/learn.rs`
//! has both).

use super::solve::{Residual, Retargeter, Workspace};
use super::{RetargetError, SettingsError};
use crate::geometry::Point;
use crate::mesh::{InteractionMesh, MeshError};

/// A mesh with its targets, assembled; shared between threads.
#[derive(Debug, Clone)]
pub struct Prepared {
    pub(super) retargeter: Retargeter,
    pub(super) mesh: InteractionMesh,
    pub(super) targets: Vec<Point>,
    pub(super) lengths: Vec<f64>,
    /// Assembled and loaded, never factored.
    pub(super) workspace: Workspace,
}

/// One thread's room for solving variations of a [`Prepared`] system.
#[derive(Debug, Clone)]
pub struct Variation {
    mesh: InteractionMesh,
    pub(super) workspace: Workspace,
    pub(super) solved: Vec<Point>,
}

impl Variation {
    /// The last solution: `[m]`, `frames × vertices`.
    pub fn solved(&self) -> &[Point] {
        &self.solved
    }
}

/// Why weights could not be changed and solved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum VariationError {
    /// The new weights are none.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The system has no solution.
    #[error(transparent)]
    Retarget(#[from] RetargetError),
}

impl From<SettingsError> for VariationError {
    fn from(error: SettingsError) -> Self {
        Self::Retarget(error.into())
    }
}

impl Prepared {
    /// Assembles a mesh for its targets.
    ///
    /// - `targets`, `lengths`: as [`Retargeter::solve`] takes them.
    ///
    /// # Errors
    /// [`RetargetError`] as [`Retargeter::assemble`] and [`Retargeter::solve`].
    /// # Panics
    /// If the mesh has another topology than the retargeter: the caller's bug.
    pub fn new(
        retargeter: Retargeter,
        mesh: InteractionMesh,
        targets: Vec<Point>,
        lengths: Vec<f64>,
    ) -> Result<Self, RetargetError> {
        let mut workspace = retargeter.workspace();
        retargeter.assemble(&mesh, &mut workspace)?;
        retargeter.check_inputs(&targets, &lengths, targets.len())?;
        retargeter.load(&mesh, &targets, &mut workspace);
        Ok(Self { retargeter, mesh, targets, lengths, workspace })
    }

    /// The mesh as it stands.
    pub fn mesh(&self) -> &InteractionMesh {
        &self.mesh
    }

    /// Room for [`Self::solve`] and [`Self::solve_with`], which then allocate nothing.
    pub fn variation(&self) -> Variation {
        Variation {
            mesh: self.mesh.clone(),
            workspace: self.workspace.clone(),
            solved: self.targets.clone(),
        }
    }

    /// Solves the mesh as it stands.
    ///
    /// # Errors
    /// [`RetargetError::Unanchored`].
    pub fn solve(&self, room: &mut Variation) -> Result<Residual, RetargetError> {
        room.workspace.copy_system(&self.workspace);
        self.finish(room)
    }

    /// Solves the mesh with other weights of one edge.
    ///
    /// - `edge`: its place in the topology's edges.
    /// - `weights`: `[-]`, one per frame, finite, ≥ 0; without any the edge weighs nothing.
    /// - `room`: made by [`Self::variation`] of this very system.
    ///
    /// # Errors
    /// [`VariationError`].
    pub fn solve_with(
        &self,
        edge: usize,
        weights: Option<&[f64]>,
        room: &mut Variation,
    ) -> Result<Residual, VariationError> {
        room.workspace.copy_system(&self.workspace);
        self.exchange(edge, weights, &mut room.mesh, &mut room.workspace)?;
        let solved = self.finish(room);
        // The room is as it was for the next edge.
        room.mesh.copy_weights(&self.mesh, edge);
        self.fill_ends(edge, &room.mesh, &mut room.workspace);
        Ok(solved?)
    }

    /// Changes the weights of some edges for good; room made before is of no use any more.
    ///
    /// - `edges`: their places in the topology's edges.
    /// - `fill`: writes the weights `[-]`, one per frame, of the edge at a place of `edges`.
    ///
    /// # Errors
    /// [`MeshError::Weight`] at the first weight that is none; edges before it have changed.
    pub fn reweigh(
        &mut self,
        edges: &[usize],
        mut fill: impl FnMut(usize, &mut [f64]),
    ) -> Result<(), MeshError> {
        let Self { retargeter, mesh, targets, workspace, .. } = self;
        let mut weights = vec![0.0; mesh.frames()];
        for (at, edge) in edges.iter().enumerate() {
            fill(at, &mut weights);
            mesh.reweigh(*edge, &weights)?;
        }
        // All rows anew: rounding must not add up over the steps of a long search.
        retargeter.assemble_rows(mesh, workspace);
        retargeter.load(mesh, targets, workspace);
        Ok(())
    }

    fn finish(&self, room: &mut Variation) -> Result<Residual, RetargetError> {
        let Variation { workspace, solved, .. } = room;
        self.retargeter.factor(workspace)?;
        solved.copy_from_slice(&workspace.reference);
        Ok(self.retargeter.iterate(&self.targets, &self.lengths, workspace, solved))
    }

    /// Takes the rows of an edge's ends out, changes its weights, and puts the new rows in.
    fn exchange(
        &self,
        edge: usize,
        weights: Option<&[f64]>,
        mesh: &mut InteractionMesh,
        workspace: &mut Workspace,
    ) -> Result<(), MeshError> {
        let w_l = self.retargeter.settings().laplacian_weight;
        self.for_each_row(edge, |vertex| self.add(mesh, vertex, -w_l, workspace));
        match weights {
            Some(weights) => mesh.reweigh(edge, weights)?,
            None => mesh.switch_off(edge)?,
        }
        self.fill_ends(edge, mesh, workspace);
        self.for_each_row(edge, |vertex| self.add(mesh, vertex, w_l, workspace));
        Ok(())
    }

    fn add(&self, mesh: &InteractionMesh, vertex: usize, w_l: f64, workspace: &mut Workspace) {
        let Workspace { coefficients, blocks, matrix, .. } = &mut *workspace;
        self.retargeter.add_row(vertex, w_l, coefficients, blocks, matrix);
        self.retargeter.pull_of_row(mesh, &self.targets, vertex, w_l, workspace);
    }

    fn fill_ends(&self, edge: usize, mesh: &InteractionMesh, workspace: &mut Workspace) {
        let Workspace { coefficients, blocks, .. } = workspace;
        self.for_each_row(edge, |vertex| {
            self.retargeter.fill_row(mesh, vertex, coefficients, blocks);
        });
    }

    /// Both ends of an edge in every frame.
    fn for_each_row(&self, edge: usize, mut visit: impl FnMut(usize)) {
        let topology = self.mesh.topology();
        let ends = topology.edges()[edge].ends();
        for frame in 0..self.mesh.frames() {
            for end in ends {
                visit(frame * topology.pair().len() + end.index());
            }
        }
    }
}
