//! The solve itself: assemble, factor, iterate.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::band::BandMatrix;
use super::error::RetargetError;
use super::neighbourhoods::Neighbourhoods;
use super::settings::{Constraint, RetargetSettings, Start, Transform};
use super::system::Pattern;
use crate::geometry::{Point, Vector, is_finite, rigid_alignment};
use crate::mesh::{InteractionMesh, Topology};

/// What a solve left over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// Steps taken.
    pub steps: usize,
    /// The farthest any coordinate moved in the last step `[m]`.
    pub last_step: f64,
    /// The farthest any solved bone is from its length `[m]`.
    pub bones: f64,
}

/// Who is known, in which mesh, with which settings: immutable, shared between threads.
///
/// ```
/// use std::sync::Arc;
/// use handover_mesh::{mesh::*, retarget::*, Point, Role, Skeleton};
/// let skeleton = Skeleton::nite();
/// let pair = Arc::new(Pair::new([skeleton.clone(), skeleton.clone()]));
/// let pose: Vec<Point> =
///     (0..30).map(|i| f64::from(i)).map(|i| Point::new(i.sin(), (2.0 * i).cos(), 0.1 * i)).collect();
/// let topology = Arc::new(Topology::initial(pair.clone(), &pose, InitialEdges::BothPeople)?);
/// let weights = EdgeWeights::by_kernel(&topology, &pose, Kernel::Uniform, 1.0);
/// let mesh = InteractionMesh::new(topology.clone(), pose.clone(), weights)?;
///
/// // The first person is known, the second solved for.
/// let constraints: Vec<Constraint> =
///     (0..30).map(|i| if i < 15 { Constraint::Fixed } else { Constraint::Free }).collect();
/// let retargeter = Retargeter::new(topology, &constraints, RetargetSettings::default())?;
/// let mut workspace = retargeter.workspace();
/// retargeter.assemble(&mesh, &mut workspace)?;
/// retargeter.factor(&mut workspace)?;
/// let lengths: Vec<f64> =
///     pair.bones().map(|[a, b]| (pose[a.index()] - pose[b.index()]).norm()).collect();
/// let mut solved = pose.clone();
/// retargeter.solve(&mesh, &pose, &lengths, &mut workspace, &mut solved)?;
/// assert!(solved.iter().zip(&pose).all(|(a, b)| (a - b).norm() < 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Retargeter {
    pub(super) pattern: Pattern,
    pub(super) settings: RetargetSettings,
}

/// What changes with every solve; may be dropped at any time.
#[derive(Debug, Clone)]
pub struct Workspace {
    /// One number per entry of the open rows, `1` or `−w̄`; 0 of rows that hold no unknown.
    pub(super) coefficients: Vec<f64>,
    /// `implicit`: one block per entry of the open rows.
    pub(super) blocks: Vec<Matrix3<f64>>,
    pub(super) matrix: BandMatrix,
    /// The right-hand side's part that stays over the steps, per unknown.
    pub(super) constant: Vec<Vector>,
    pub(super) rhs: Vec<Vector>,
    /// `x y z 0` per unknown: four lanes fill a vector register.
    pub(super) columns: Vec<[f64; 4]>,
    /// `implicit`: the unknowns' coordinates one after another.
    pub(super) stacked: Vec<[f64; 1]>,
    /// The demonstration where the first iterate stands.
    pub(super) reference: Vec<Point>,
    /// `local_global`: what is turned in every step.
    pub(super) neighbourhoods: Neighbourhoods,
}

impl Workspace {
    /// The normal matrix of the last [`Retargeter::assemble`], or its factor.
    pub fn matrix(&self) -> &BandMatrix {
        &self.matrix
    }

    /// Takes over another workspace's normal equations, not yet factored.
    pub(super) fn copy_system(&mut self, other: &Self) {
        self.matrix.copy_from(&other.matrix);
        self.constant.copy_from_slice(&other.constant);
    }
}

impl Retargeter {
    /// Lays out the system.
    ///
    /// - `constraints`: one per space-time vertex, `frames × vertices`.
    ///
    /// # Errors
    /// [`RetargetError`] on settings out of bounds, constraints that are not whole frames, or a
    /// weight that is not positive.
    pub fn new(
        topology: Arc<Topology>,
        constraints: &[Constraint],
        settings: RetargetSettings,
    ) -> Result<Self, RetargetError> {
        settings.check()?;
        let vertices = topology.pair().len();
        if constraints.is_empty() || !constraints.len().is_multiple_of(vertices) {
            let expected = constraints.len().next_multiple_of(vertices).max(vertices);
            return Err(RetargetError::Shape {
                what: "constraints",
                expected,
                got: constraints.len(),
            });
        }
        for (vertex, constraint) in constraints.iter().enumerate() {
            if let Constraint::Soft(weight) = *constraint
                && !(weight.is_finite() && weight > 0.0)
            {
                let (frame, joint) = (vertex / vertices, vertex % vertices);
                return Err(RetargetError::Weight { frame, joint, weight });
            }
        }
        Ok(Self { pattern: Pattern::new(topology, constraints, settings.transform), settings })
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &RetargetSettings {
        &self.settings
    }

    /// Room for solves; everything later works inside it without allocating.
    pub fn workspace(&self) -> Workspace {
        let (entries, unknowns) = (self.pattern.entries(), self.pattern.unknown_count);
        let vertices = self.pattern.constraints.len();
        let (axes, blocks, turned) = match self.settings.transform {
            Transform::None => (1, 0, [0, 0]),
            Transform::Implicit => (3, entries, [0, 0]),
            Transform::LocalGlobal => (1, 0, [vertices, entries]),
        };
        Workspace {
            coefficients: vec![0.0; entries],
            blocks: vec![Matrix3::zeros(); blocks],
            matrix: self.pattern.matrix(axes),
            constant: vec![Vector::zeros(); unknowns],
            rhs: vec![Vector::zeros(); unknowns],
            columns: vec![[0.0; 4]; if axes == 1 { unknowns } else { 0 }],
            stacked: vec![[0.0; 1]; if axes == 3 { 3 * unknowns } else { 0 }],
            reference: vec![Point::origin(); vertices],
            neighbourhoods: Neighbourhoods::new(turned[0], turned[1]),
        }
    }

    /// Fills the normal equations for a mesh: `w_l LᵀL`, constraints and bones.
    ///
    /// # Errors
    /// [`RetargetError::Shape`] if the mesh has other frames.
    /// # Panics
    /// If the mesh has another topology: the caller's bug.
    pub fn assemble(
        &self,
        mesh: &InteractionMesh,
        workspace: &mut Workspace,
    ) -> Result<(), RetargetError> {
        self.check_mesh(mesh)?;
        self.assemble_rows(mesh, workspace);
        Ok(())
    }

    pub(super) fn assemble_rows(&self, mesh: &InteractionMesh, workspace: &mut Workspace) {
        let Workspace { coefficients, blocks, matrix, .. } = workspace;
        matrix.clear();
        for vertex in self.pattern.open_rows.iter().map(|vertex| *vertex as usize) {
            self.fill_row(mesh, vertex, coefficients, blocks);
            self.add_row(vertex, self.settings.laplacian_weight, coefficients, blocks, matrix);
        }
        let (known, bones) = (self.settings.known_weight, self.settings.bone_weight);
        self.pattern.add_constraints(matrix, self.axes(), known, bones);
    }

    /// One vertex' share of the normal matrix, `w_l` times.
    pub(super) fn add_row(
        &self,
        vertex: usize,
        w_l: f64,
        coefficients: &[f64],
        blocks: &[Matrix3<f64>],
        matrix: &mut BandMatrix,
    ) {
        let pattern = &self.pattern;
        match self.settings.transform {
            Transform::None => pattern.add_scalar_row(matrix, coefficients, vertex, w_l),
            Transform::Implicit => {
                pattern.add_block_row(matrix, (coefficients, blocks), vertex, w_l);
            }
            Transform::LocalGlobal => pattern.add_edge_row(matrix, coefficients, vertex, w_l),
        }
    }

    /// One vertex' share of the right-hand side that stays over the steps, `w_l` times.
    pub(super) fn pull_of_row(
        &self,
        mesh: &InteractionMesh,
        targets: &[Point],
        vertex: usize,
        w_l: f64,
        workspace: &mut Workspace,
    ) {
        match self.settings.transform {
            Transform::None => self.pull_of_scalar_row(mesh, targets, vertex, w_l, workspace),
            Transform::Implicit => self.pull_of_block_row(targets, vertex, w_l, workspace),
            Transform::LocalGlobal => self.pull_of_edge_row(targets, vertex, w_l, workspace),
        }
    }

    /// How many coordinates of a vertex the system couples.
    pub(super) fn axes(&self) -> usize {
        if self.settings.transform == Transform::Implicit { 3 } else { 1 }
    }

    /// Factors the assembled system; it serves any number of [`Self::solve`] calls.
    ///
    /// # Errors
    /// [`RetargetError::Unanchored`] names a joint that nothing known determines.
    pub fn factor(&self, workspace: &mut Workspace) -> Result<(), RetargetError> {
        workspace.matrix.factor().map_err(|undetermined| {
            let vertex = self.pattern.vertex_of(undetermined.row / self.axes());
            let (frame, joint) = self.place(vertex);
            RetargetError::Unanchored { frame, joint }
        })
    }

    /// Finds the positions that keep the mesh best.
    ///
    /// - `targets`: `[m]`, `frames × vertices`; read where a joint is soft or fixed.
    /// - `lengths`: `[m]`, one per bone in [`crate::mesh::Pair::bones`] order.
    /// - `out`: `[m]`, `frames × vertices`, overwritten; fixed joints are their targets.
    ///
    /// # Errors
    /// [`RetargetError`] on shapes, targets that are not finite, lengths that are not positive.
    pub fn solve(
        &self,
        mesh: &InteractionMesh,
        targets: &[Point],
        lengths: &[f64],
        workspace: &mut Workspace,
        out: &mut [Point],
    ) -> Result<Residual, RetargetError> {
        self.prepare(mesh, targets, lengths, workspace, out.len())?;
        out.copy_from_slice(&workspace.reference);
        Ok(self.iterate(targets, lengths, workspace, out))
    }

    /// As [`Self::solve`], but the first iterate is `out` as it stands: a solution of a moment ago,
    /// whose bones point nearly where they will.
    ///
    /// # Errors
    /// As [`Self::solve`].
    pub fn solve_on(
        &self,
        mesh: &InteractionMesh,
        targets: &[Point],
        lengths: &[f64],
        workspace: &mut Workspace,
        out: &mut [Point],
    ) -> Result<Residual, RetargetError> {
        self.prepare(mesh, targets, lengths, workspace, out.len())?;
        Ok(self.iterate(targets, lengths, workspace, out))
    }

    /// Checks what a solve takes, and loads it.
    fn prepare(
        &self,
        mesh: &InteractionMesh,
        targets: &[Point],
        lengths: &[f64],
        workspace: &mut Workspace,
        out: usize,
    ) -> Result<(), RetargetError> {
        self.check_mesh(mesh)?;
        self.check_inputs(targets, lengths, out)?;
        self.load(mesh, targets, workspace);
        Ok(())
    }

    /// What stays over the steps: where the reference stands, and the constant pull.
    pub(super) fn load(
        &self,
        mesh: &InteractionMesh,
        targets: &[Point],
        workspace: &mut Workspace,
    ) {
        self.place_reference(mesh, targets, &mut workspace.reference);
        workspace.constant.fill(Vector::zeros());
        self.pull_of_targets(targets, &mut workspace.constant);
        for vertex in self.pattern.open_rows.iter().map(|vertex| *vertex as usize) {
            self.pull_of_row(mesh, targets, vertex, self.settings.laplacian_weight, workspace);
        }
    }

    /// The steps, from `out` on.
    pub(super) fn iterate(
        &self,
        targets: &[Point],
        lengths: &[f64],
        workspace: &mut Workspace,
        out: &mut [Point],
    ) -> Residual {
        for (vertex, constraint) in self.pattern.constraints.iter().enumerate() {
            if *constraint == Constraint::Fixed {
                out[vertex] = targets[vertex];
            }
        }
        if self.settings.transform == Transform::LocalGlobal {
            let Workspace { neighbourhoods, coefficients, reference, .. } = workspace;
            let memory = self.settings.rotation_memory;
            neighbourhoods.pack(&self.pattern, coefficients, reference, memory);
        }
        let mut residual = Residual { steps: 0, last_step: f64::INFINITY, bones: 0.0 };
        while residual.steps < self.settings.steps && residual.last_step > self.settings.tolerance {
            residual.last_step = self.step(lengths, workspace, out);
            residual.steps += 1;
        }
        residual.bones = self.bone_error(lengths, out);
        residual
    }

    /// One linear solve with the bones (and rotations) of the last iterate; how far it moved.
    fn step(&self, lengths: &[f64], workspace: &mut Workspace, out: &mut [Point]) -> f64 {
        let Workspace { matrix, constant, rhs, columns, stacked, neighbourhoods, .. } = workspace;
        rhs.copy_from_slice(constant);
        let bone_weight = self.settings.bone_weight;
        self.pattern.bone_pull(out, lengths, bone_weight, |at, pull| rhs[at] += pull);
        if stacked.is_empty() {
            for (column, pull) in columns.iter_mut().zip(&*rhs) {
                *column = [pull.x, pull.y, pull.z, 0.0];
            }
            if self.settings.transform == Transform::LocalGlobal {
                neighbourhoods.turn(out, self.settings.laplacian_weight, columns);
            }
            matrix.solve(columns);
        } else {
            for (values, pull) in stacked.chunks_exact_mut(3).zip(&*rhs) {
                values.iter_mut().zip(pull.iter()).for_each(|(value, pull)| value[0] = *pull);
            }
            matrix.solve(stacked);
        }
        let mut farthest = 0.0f64;
        for (vertex, point) in out.iter_mut().enumerate() {
            let Some(at) = self.pattern.unknown(vertex) else { continue };
            let place = if stacked.is_empty() {
                Vector3::new(columns[at][0], columns[at][1], columns[at][2])
            } else {
                Vector3::new(stacked[3 * at][0], stacked[3 * at + 1][0], stacked[3 * at + 2][0])
            };
            farthest = farthest.max((place - point.coords).amax());
            point.coords = place;
        }
        farthest
    }

    fn place(&self, vertex: usize) -> (usize, usize) {
        let vertices = self.pattern.topology.pair().len();
        (vertex / vertices, vertex % vertices)
    }

    fn check_mesh(&self, mesh: &InteractionMesh) -> Result<(), RetargetError> {
        let (ours, theirs) = (&self.pattern.topology, mesh.topology());
        assert!(Arc::ptr_eq(ours, theirs) || ours == theirs, "the mesh has another topology");
        check_count("mesh positions", self.pattern.constraints.len(), mesh.positions().len())
    }

    pub(super) fn check_inputs(
        &self,
        targets: &[Point],
        lengths: &[f64],
        out: usize,
    ) -> Result<(), RetargetError> {
        let constraints = &self.pattern.constraints;
        check_count("targets", constraints.len(), targets.len())?;
        check_count("bone lengths", self.pattern.topology.pair().bones().count(), lengths.len())?;
        check_count("output positions", constraints.len(), out)?;
        let known = constraints.iter().zip(targets).enumerate();
        for (vertex, (constraint, target)) in known {
            if *constraint != Constraint::Free && !is_finite(target) {
                let (frame, joint) = self.place(vertex);
                return Err(RetargetError::NotFinite { frame, joint });
            }
        }
        match lengths.iter().position(|length| !(length.is_finite() && *length > 0.0)) {
            Some(bone) => Err(RetargetError::Length { bone, length: lengths[bone] }),
            None => Ok(()),
        }
    }

    fn place_reference(&self, mesh: &InteractionMesh, targets: &[Point], reference: &mut [Point]) {
        reference.copy_from_slice(mesh.positions());
        if self.settings.start == Start::Aligned {
            let known = self.pattern.constraints.iter().zip(mesh.positions()).zip(targets);
            let known = known.filter(|((constraint, _), _)| **constraint != Constraint::Free);
            let target_from_mesh = rigid_alignment(known.map(|((_, from), to)| (from, to)));
            reference.iter_mut().for_each(|p| *p = target_from_mesh * *p);
        }
    }
}

fn check_count(what: &'static str, expected: usize, got: usize) -> Result<(), RetargetError> {
    if got == expected { Ok(()) } else { Err(RetargetError::Shape { what, expected, got }) }
}
