//! Shapes and weights → a shape.

use nalgebra::Matrix3;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::connections::Connections;
use super::gradients::{self, Block};
use super::logarithms::{
    Logarithms, add_weighted, logarithms, products, rotations_and_stretches, times, turned_further,
};
use super::normal::{Normal, Room};
use super::tangent::Symmetric;
use super::{BlendError, BlendSettings, Energy, Structure, Triangles, tetrise};
use crate::geometry::{Point, Vector, closest_rotation, is_finite};
use crate::rotations::{IDENTITIES, LANES, Matrices, Quaternions, best_rotations};

/// How a blend ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blended {
    /// Iterations of `E_S`; 0 of `E_T`.
    pub iterations: usize,
    /// `Σ W‖Â − C‖²` `[-]`; of `E_S` what is made least, `Σ W‖Â − R S(C)‖²` with the best rotations.
    pub energy: f64,
    /// How far the last iteration moved a vertex at most `[m]`; 0 of `E_T`.
    pub change: f64,
    /// Whether that is within [`Blender::at_rest`].
    pub is_settled: bool,
}

/// Vertices that hang together by tetrahedra.
#[derive(Debug, Default)]
struct Part {
    /// Its vertices but ghosts.
    vertices: Vec<u32>,
    /// Where their mean is in each shape; none where a vertex is pinned.
    means: Option<Vec<Point>>,
}

/// Shapes that were taken apart; immutable, shared between threads.
///
/// ```
/// use handover_mesh::Point;
/// use handover_mesh::blend::{BlendSettings, Blender, Triangles};
///
/// let roof = |top: f64| {
///     [[0.0, 0.0, 0.0], [1.0, 0.0, top], [1.0, 1.0, 0.0], [0.0, 1.0, top]].map(Point::from)
/// };
/// let triangles = Triangles::new(4, vec![[0, 1, 2], [0, 2, 3]])?;
/// let (low, high) = (roof(0.0), roof(0.5));
/// let blender = Blender::of_triangles(&triangles, &[&low, &high], BlendSettings::default())?;
/// let mut half = low;
/// blender.blend(&[0.5], &mut blender.workspace(), &mut half);
/// assert!(half[1].z - half[0].z > 0.2);
/// # Ok::<(), handover_mesh::blend::BlendError>(())
/// ```
#[derive(Debug)]
pub struct Blender {
    settings: BlendSettings,
    /// Given vertices; behind them the ghosts.
    vertices: usize,
    all_vertices: usize,
    tetrahedra: usize,
    blocks: Vec<Block>,
    /// The part of each tetrahedron.
    part_of: Vec<u32>,
    /// Of each shape but the reference.
    logarithms: Vec<Logarithms>,
    normal: Normal,
    parts: Vec<Part>,
    /// Vertices in no tetrahedron and those that hold their part, with their places in each shape.
    linear: Vec<(u32, Vec<Point>)>,
    free: usize,
    pins: Vec<u32>,
    flipped: usize,
    replaced: usize,
    /// The reference's extent `[m]`.
    extent: f64,
    arch: Arch,
}

/// Room to blend; carries nothing from one blend to the next.
#[derive(Debug)]
pub struct Workspace {
    shape: Vec<Point>,
    before: Vec<Point>,
    pulls: Vec<Vector>,
    /// As blended.
    targets: Vec<Quaternions>,
    /// As turned by the iteration.
    rotations: Vec<Quaternions>,
    stretches: Vec<Symmetric>,
    covariances: Vec<Matrix3<f64>>,
    room: Room,
}

/// Whether there are shapes, each with a finite place for each vertex.
pub(super) fn check_shapes(shapes: &[&[Point]], vertices: usize) -> Result<(), BlendError> {
    if shapes.is_empty() {
        return Err(BlendError::NoShape);
    }
    for (shape, places) in shapes.iter().enumerate() {
        if places.len() != vertices {
            return Err(BlendError::Shape { shape, places: places.len(), vertices });
        }
        if let Some(vertex) = places.iter().position(|place| !is_finite(place)) {
            return Err(BlendError::NotFinite { shape, vertex });
        }
    }
    Ok(())
}

impl Blender {
    /// Takes shapes of a triangle mesh apart.
    ///
    /// - `shapes`: one place `[m]` a vertex each, the reference first.
    ///
    /// # Errors
    /// As [`tetrise()`]; [`BlendError::Settings`], [`BlendError::Undetermined`].
    pub fn of_triangles(
        triangles: &Triangles,
        shapes: &[&[Point]],
        settings: BlendSettings,
    ) -> Result<Self, BlendError> {
        let settings = settings.check()?;
        let tetrised = tetrise(triangles, shapes, settings.tetrisation)?;
        let shapes = shapes.par_iter().map(|shape| tetrised.with_ghosts(shape)).collect();
        let structure = tetrised.structure().clone();
        let blender = Self::of_positive(structure, shapes, &[], settings)?;
        let (flipped, replaced) = (tetrised.flipped(), tetrised.replaced());
        Ok(Self { flipped, replaced, ..blender })
    }

    /// Takes shapes of tetrahedra apart.
    ///
    /// - `shapes`: one place `[m]` a vertex each, the reference first.
    /// - `pins`: vertices whose places are given to each blend.
    ///
    /// Tetrahedra that are not positive in every shape are left out.
    ///
    /// # Errors
    /// [`BlendError`]: shapes that are none, pins that are no vertices, settings out of bounds,
    /// tetrahedra of which none is positive in every shape.
    pub fn of_tetrahedra(
        structure: &Structure,
        shapes: &[&[Point]],
        pins: &[usize],
        settings: BlendSettings,
    ) -> Result<Self, BlendError> {
        let settings = settings.check()?;
        let vertices = structure.vertices();
        check_shapes(shapes, vertices)?;
        if let Some(vertex) = pins.iter().copied().find(|pin| *pin >= vertices) {
            return Err(BlendError::Pin { vertex, vertices });
        }
        let shapes: Vec<Vec<Point>> = shapes.iter().map(|shape| shape.to_vec()).collect();
        let (structure, flipped) = structure.clone().positive(&shapes);
        let blender = Self::of_positive(structure, shapes, pins, settings)?;
        Ok(Self { flipped, ..blender })
    }

    fn of_positive(
        structure: Structure,
        shapes: Vec<Vec<Point>>,
        pins: &[usize],
        settings: BlendSettings,
    ) -> Result<Self, BlendError> {
        if structure.tetrahedra().is_empty() {
            return Err(BlendError::Empty);
        }
        let (vertices, all_vertices) = (structure.ghosts().start, structure.vertices());
        let blocks = gradients::blocks(&structure, &shapes[0]);
        let connections = Connections::new(&structure);
        let arch = Arch::new();
        let count = connections.parts();
        let mut parts: Vec<Part> = (0..count).map(|_| Part::default()).collect();
        let mut is_known = vec![false; all_vertices];
        pins.iter().for_each(|pin| is_known[*pin] = true);
        let mut is_pinned = vec![false; count];
        let mut linear = Vec::new();
        let places = |vertex: usize| shapes.iter().map(|shape| shape[vertex]).collect();
        for vertex in 0..vertices {
            match connections.part_of_vertex(vertex) {
                Some(part) => {
                    parts[part].vertices.push(vertex as u32);
                    is_pinned[part] |= is_known[vertex];
                }
                None if !is_known[vertex] => linear.push((vertex as u32, places(vertex))),
                None => {}
            }
        }
        let free = linear.len();
        for (part, is_pinned) in parts.iter_mut().zip(is_pinned) {
            if !is_pinned {
                // Held at one vertex to be solved for, shifted to its mean afterwards.
                let anchor = part.vertices[0] as usize;
                is_known[anchor] = true;
                linear.push((anchor as u32, places(anchor)));
                part.means = Some(shapes.iter().map(|shape| mean(&part.vertices, shape)).collect());
            }
        }
        let take_logarithms = |shape: &Vec<Point>| {
            logarithms(arch, &structure, &connections, &blocks, shape, settings.rotation)
        };
        let (normal, logarithms) = rayon::join(
            || Normal::new(&structure, &connections, &blocks, &is_known),
            || shapes[1..].par_iter().map(take_logarithms).collect(),
        );
        let normal = normal?;
        let part_of = connections.part_of().to_vec();
        let tetrahedra = structure.tetrahedra().len();
        let extent = extent(&shapes[0][..vertices]);
        let pins = pins.iter().map(|pin| *pin as u32).collect();
        Ok(Self {
            settings,
            vertices,
            all_vertices,
            tetrahedra,
            blocks,
            part_of,
            logarithms,
            normal,
            parts,
            linear,
            free,
            pins,
            flipped: 0,
            replaced: 0,
            extent,
            arch,
        })
    }

    /// How many tetrahedra were left out: not positive in every shape.
    pub fn flipped(&self) -> usize {
        self.flipped
    }

    /// How many triangles have a face-normal tetrahedron in place of those they should have.
    pub fn replaced(&self) -> usize {
        self.replaced
    }

    /// How many vertices are in no tetrahedron, and take the weighted mean.
    pub fn free(&self) -> usize {
        self.free
    }

    /// How many tetrahedra there are.
    pub fn tetrahedra(&self) -> usize {
        self.tetrahedra
    }

    /// How it blends.
    pub fn settings(&self) -> &BlendSettings {
        &self.settings
    }

    /// An iteration of `E_S` that moves no vertex farther is the last `[m]`.
    pub fn at_rest(&self) -> f64 {
        self.settings.tolerance * self.extent
    }

    /// Room for [`Self::blend`].
    pub fn workspace(&self) -> Workspace {
        let blocks = self.blocks.len();
        Workspace {
            shape: vec![Point::origin(); self.all_vertices],
            before: vec![Point::origin(); self.vertices],
            pulls: vec![Vector::zeros(); self.all_vertices],
            targets: vec![IDENTITIES; blocks],
            rotations: vec![IDENTITIES; blocks],
            stretches: vec![[[0.0; LANES]; 6]; blocks],
            covariances: vec![Matrix3::zeros(); self.parts.len()],
            room: self.normal.room(),
        }
    }

    /// The shape of these weights: 0 gives the reference, 1 and else 0 a shape.
    ///
    /// - `weights`: `[-]`, one for each shape after the reference, any finite numbers.
    /// - `out`: `[m]`, one place a vertex: those of pinned vertices given, the rest overwritten.
    ///
    /// Parts without pinned vertices have their mean at the weighted mean of theirs in the shapes,
    /// and with `E_S` are turned as `E_T` would best have them. Without allocation.
    ///
    /// # Panics
    /// If there is not one weight a shape or one place a vertex: the caller's bug.
    pub fn blend(&self, weights: &[f64], workspace: &mut Workspace, out: &mut [Point]) -> Blended {
        assert_eq!(
            weights.len(),
            self.logarithms.len(),
            "one weight for each shape after the reference"
        );
        assert_eq!(out.len(), self.vertices, "one place a vertex");
        for (vertex, places) in &self.linear {
            workspace.shape[*vertex as usize] = weighted(places, weights);
        }
        for pin in &self.pins {
            workspace.shape[*pin as usize] = out[*pin as usize];
        }
        self.arch.dispatch(SetTargets { blender: self, weights, workspace });
        self.normal.solve(&mut workspace.pulls, &mut workspace.shape, &mut workspace.room);
        let mut blended = Blended { iterations: 0, energy: 0.0, change: 0.0, is_settled: true };
        if self.settings.energy == Energy::Transforms {
            blended.energy = self.arch.dispatch(MeasureEnergy { blender: self, workspace });
        } else {
            blended = self.iterate(workspace);
            self.turn(workspace);
        }
        self.centre(weights, &mut workspace.shape);
        out.copy_from_slice(&workspace.shape[..self.vertices]);
        blended
    }

    /// Turns the targets and solves until nothing moves.
    fn iterate(&self, workspace: &mut Workspace) -> Blended {
        workspace.rotations.copy_from_slice(&workspace.targets);
        let (iterations, change) = (0, f64::INFINITY);
        let mut blended = Blended { iterations, energy: 0.0, change, is_settled: false };
        while blended.iterations < self.settings.iterations && !blended.is_settled {
            workspace.before.copy_from_slice(&workspace.shape[..self.vertices]);
            self.arch.dispatch(TurnTargets { blender: self, workspace });
            self.normal.solve(&mut workspace.pulls, &mut workspace.shape, &mut workspace.room);
            let moved = workspace.before.iter().zip(&workspace.shape);
            let moved = moved.map(|(before, after)| (after - before).norm_squared());
            blended.change = moved.fold(0.0, f64::max).sqrt();
            blended.is_settled = blended.change <= self.at_rest();
            blended.iterations += 1;
        }
        blended.energy = self.arch.dispatch(TurnTargets { blender: self, workspace });
        blended
    }

    /// Turns each part without pins about its mean, so that its maps are nearest to the targets.
    fn turn(&self, workspace: &mut Workspace) {
        let Workspace { shape, targets, stretches, covariances, .. } = workspace;
        covariances.fill(Matrix3::zeros());
        for (at, block) in self.blocks.iter().enumerate() {
            let (maps, targets) = (block.maps(shape), products(&targets[at], &stretches[at]));
            for (lane, part) in self.part_of[at * LANES..].iter().take(LANES).enumerate() {
                let one = |of: &Matrices| Matrix3::from_fn(|i, j| of[i][j][lane]);
                let weight = block.weights[lane];
                covariances[*part as usize] += weight * one(&targets) * one(&maps).transpose();
            }
        }
        for (part, covariance) in self.parts.iter().zip(covariances) {
            if part.means.is_some() {
                let rotation = closest_rotation(covariance);
                let middle = mean(&part.vertices, shape);
                for vertex in &part.vertices {
                    let place = &mut shape[*vertex as usize];
                    *place = middle + rotation * (*place - middle);
                }
            }
        }
    }

    /// Shifts each part without pins to where its mean belongs.
    fn centre(&self, weights: &[f64], shape: &mut [Point]) {
        for part in &self.parts {
            if let Some(means) = &part.means {
                let shift = weighted(means, weights) - mean(&part.vertices, shape);
                part.vertices.iter().for_each(|vertex| shape[*vertex as usize] += shift);
            }
        }
    }
}

/// Blends the maps, and lets them pull.
struct SetTargets<'a> {
    blender: &'a Blender,
    weights: &'a [f64],
    workspace: &'a mut Workspace,
}

impl WithSimd for SetTargets<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { blender, weights, workspace } = self;
        workspace.pulls.fill(Vector::zeros());
        for (at, block) in blender.blocks.iter().enumerate() {
            let mut sums = [[0.0; LANES]; 9];
            let (mut rests, mut has_rests) = ([[0.0; LANES]; 3], false);
            for (weight, of_shape) in weights.iter().zip(&blender.logarithms) {
                add_weighted(*weight, &of_shape.sums[at], &mut sums);
                if let Some(of_shape) = &of_shape.rests {
                    add_weighted(*weight, &of_shape[at], &mut rests);
                    has_rests = true;
                }
            }
            let (mut rotations, stretches) =
                rotations_and_stretches(&sums, blender.settings.rotation);
            if has_rests {
                rotations = turned_further(&rotations, &rests);
            }
            block.pull(&products(&rotations, &stretches), &mut workspace.pulls);
            workspace.targets[at] = rotations;
            workspace.stretches[at] = stretches;
        }
    }
}

/// `Σ W‖Â − C‖²` of the blended maps.
struct MeasureEnergy<'a> {
    blender: &'a Blender,
    workspace: &'a Workspace,
}

impl WithSimd for MeasureEnergy<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let Self { blender, workspace } = self;
        let mut energy = 0.0;
        for (at, block) in blender.blocks.iter().enumerate() {
            let maps = block.maps(&workspace.shape);
            let targets = products(&workspace.targets[at], &workspace.stretches[at]);
            energy += gradients::squared_differences(&maps, &targets, &block.weights);
        }
        energy
    }
}

/// Turns each target to how its tetrahedron is turned, and lets it pull: the energy as they are.
struct TurnTargets<'a> {
    blender: &'a Blender,
    workspace: &'a mut Workspace,
}

impl WithSimd for TurnTargets<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let Self { blender, workspace } = self;
        let Workspace { shape, pulls, rotations, stretches, .. } = workspace;
        pulls.fill(Vector::zeros());
        let mut energy = 0.0;
        for (at, block) in blender.blocks.iter().enumerate() {
            let (maps, stretches) = (block.maps(shape), &stretches[at]);
            // In a local array: of that the compiler knows that nothing else is there.
            let mut turned = rotations[at];
            match blender.settings.energy {
                Energy::ShearsPrinted => best_rotations(&maps, &mut turned),
                _ => best_rotations(&times(&maps, stretches), &mut turned),
            }
            let targets = products(&turned, stretches);
            rotations[at] = turned;
            energy += gradients::squared_differences(&maps, &targets, &block.weights);
            block.pull(&targets, pulls);
        }
        energy
    }
}

/// `P₀ + Σ wₖ (Pₖ − P₀)`.
fn weighted(places: &[Point], weights: &[f64]) -> Point {
    let steps = weights.iter().zip(&places[1..]).map(|(weight, to)| *weight * (to - places[0]));
    places[0] + steps.sum::<Vector>()
}

fn mean(vertices: &[u32], shape: &[Point]) -> Point {
    let sum: Vector = vertices.iter().map(|vertex| shape[*vertex as usize].coords).sum();
    Point::from(sum / vertices.len() as f64)
}

/// The diagonal of the box around places `[m]`.
fn extent(places: &[Point]) -> f64 {
    let low = places.iter().fold(places[0], |low, place| low.inf(place));
    let high = places.iter().fold(places[0], |high, place| high.sup(place));
    (high - low).norm()
}
