//! Triangles → tetrahedra, by a ghost vertex above each face, edge or vertex (Kaji 2015, section 4).
//!
//! | | ghost | tetrahedra |
//! | --- | --- | --- |
//! | face | `(v₁ + v₂ + v₃)/3 + n √‖(v₂ − v₁) × (v₃ − v₁)‖` | one a triangle |
//! | edge | `(v₁ + v₂)/2 + ‖v₁ − v₂‖ (n₁ + n₂)/‖n₁ + n₂‖` | two an edge of two triangles |
//! | vertex | `v + √(Σ area) Σ n/‖Σ n‖` | one a triangle at a vertex of several |
//!
//! A triangle without an edge or vertex in common with another has none of the latter two kinds and
//! takes the first. Edges and vertices of one triangle alone, as on a border, have no ghost.

use nalgebra::Unit;
use rayon::prelude::*;

use super::triangles::Side;
use super::{BlendError, Structure, Triangles};
use crate::geometry::{Point, Vector};

/// Above what the ghosts are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Tetrisation {
    /// Faces: sees no angle between them.
    Face,
    /// Edges: sees how much they are bent.
    Edge,
    /// Vertices: sees how pointed they are.
    Vertex,
}

impl Tetrisation {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Face, Self::Edge, Self::Vertex];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Face => "face",
            Self::Edge => "edge",
            Self::Vertex => "vertex",
        }
    }
}

/// A vertex that is not among the given ones, but follows from them.
#[derive(Debug, Clone, PartialEq)]
enum Ghost {
    Face(u32),
    Edge {
        ends: [u32; 2],
        triangles: [u32; 2],
    },
    /// The triangles are a range of [`Tetrised::fans`].
    Vertex {
        vertex: u32,
        fan: [u32; 2],
    },
}

/// A triangle mesh as tetrahedra.
#[derive(Debug, Clone)]
pub struct Tetrised {
    triangles: Triangles,
    structure: Structure,
    ghosts: Vec<Ghost>,
    fans: Vec<u32>,
    flipped: usize,
    replaced: usize,
}

/// Cuts triangles into tetrahedra that are positive in every shape.
///
/// - `shapes`: one place `[m]` a vertex each, the reference first.
///
/// A tetrahedron that is not positive in every shape is left out; a triangle left without any takes
/// its face-normal one. Only a triangle (all but) without area, in some shape, has none at all.
///
/// # Errors
/// [`BlendError::NotManifold`] of edge- and vertex-normal tetrisations, with all faults:
/// face-normal ones take any triangles. [`BlendError::Shape`], [`BlendError::NotFinite`],
/// [`BlendError::NoShape`]; [`BlendError::Empty`] if no tetrahedron is left.
pub fn tetrise(
    triangles: &Triangles,
    shapes: &[&[Point]],
    tetrisation: Tetrisation,
) -> Result<Tetrised, BlendError> {
    super::blender::check_shapes(shapes, triangles.vertices())?;
    let mut tetrised = Tetrised {
        triangles: triangles.clone(),
        structure: Structure::with_ghosts(triangles.vertices(), 0, Vec::new()),
        ghosts: Vec::new(),
        fans: Vec::new(),
        flipped: 0,
        replaced: 0,
    };
    let normals: Vec<Vec<(Vector, f64)>> =
        shapes.par_iter().map(|shape| triangles.normals(shape)).collect();
    let mut places = vec![Vec::new(); shapes.len()];
    let mut raised = match tetrisation {
        Tetrisation::Face => Vec::new(),
        Tetrisation::Edge => tetrised.over_edges()?,
        Tetrisation::Vertex => tetrised.over_vertices()?,
    };
    tetrised.flipped = tetrised.keep_positive(&mut raised, shapes, &normals, &mut places);
    let mut has_own = vec![false; triangles.as_slice().len()];
    raised.iter().for_each(|(triangle, _)| has_own[*triangle as usize] = true);
    let lonely = (0u32..).zip(&has_own).filter(|(_, has_own)| !**has_own);
    let first = tetrised.ghosts.len() as u32;
    let faces: Vec<u32> = lonely.map(|(triangle, _)| triangle).collect();
    tetrised.ghosts.extend(faces.iter().map(|triangle| Ghost::Face(*triangle)));
    let mut fallback: Vec<(u32, u32)> = faces.into_iter().zip(first..).collect();
    let flat = tetrised.keep_positive(&mut fallback, shapes, &normals, &mut places);
    if tetrisation == Tetrisation::Face {
        tetrised.flipped = flat;
    } else {
        tetrised.flipped += flat;
        tetrised.replaced = fallback.len();
    }
    raised.append(&mut fallback);
    tetrised.settle(raised);
    let is_empty = tetrised.structure.tetrahedra().is_empty();
    if is_empty { Err(BlendError::Empty) } else { Ok(tetrised) }
}

impl Tetrised {
    /// The tetrahedra, all positive in every shape.
    pub fn structure(&self) -> &Structure {
        &self.structure
    }

    /// How many tetrahedra were left out: not positive in every shape.
    pub fn flipped(&self) -> usize {
        self.flipped
    }

    /// How many triangles have a face-normal tetrahedron in place of those they should have.
    pub fn replaced(&self) -> usize {
        self.replaced
    }

    /// A shape with its ghosts: `[m]`, the structure's vertices.
    ///
    /// # Panics
    /// If the shape has not one place a vertex: the caller's bug.
    pub fn with_ghosts(&self, shape: &[Point]) -> Vec<Point> {
        assert_eq!(shape.len(), self.triangles.vertices(), "one place a vertex");
        let normals = self.triangles.normals(shape);
        let mut all = Vec::with_capacity(self.structure.vertices());
        all.extend_from_slice(shape);
        for ghost in &self.ghosts {
            all.push(self.place(ghost, shape, &normals));
        }
        all
    }

    fn place(&self, ghost: &Ghost, shape: &[Point], normals: &[(Vector, f64)]) -> Point {
        let unit = |triangle: u32| normals[triangle as usize].0;
        // Normals that cancel out point nowhere: the ghost stays in the surface, its tetrahedra
        // have no volume and are left out.
        let up = |sum: Vector| Unit::try_new(sum, 1e-9).map_or(Vector::zeros(), Unit::into_inner);
        let place = |vertex: u32| shape[vertex as usize];
        match ghost {
            Ghost::Face(triangle) => {
                let [a, b, c] = self.triangles.as_slice()[*triangle as usize].map(place);
                let middle = a + ((b - a) + (c - a)) / 3.0;
                middle + unit(*triangle) * normals[*triangle as usize].1.sqrt()
            }
            Ghost::Edge { ends, triangles } => {
                let [a, b] = ends.map(place);
                a + (b - a) / 2.0 + (b - a).norm() * up(unit(triangles[0]) + unit(triangles[1]))
            }
            Ghost::Vertex { vertex, fan } => {
                let fan = &self.fans[fan[0] as usize..fan[1] as usize];
                let (mut sum, mut area) = (Vector::zeros(), 0.0);
                for triangle in fan {
                    let (unit, length) = &normals[*triangle as usize];
                    area += 0.5 * length;
                    sum += unit;
                }
                place(*vertex) + area.sqrt() * up(sum)
            }
        }
    }

    /// Ghosts over the edges of two triangles: `(triangle, ghost)` of each tetrahedron.
    fn over_edges(&mut self) -> Result<Vec<(u32, u32)>, BlendError> {
        let sides = self.triangles.sides();
        let mut raised = Vec::new();
        let mut faults = Vec::new();
        for edge in sides.chunk_by(|a, b| a.edge == b.edge) {
            match edge {
                [_] => {}
                [a, b] if a.rises != b.rises => {
                    let ghost = self.ghosts.len() as u32;
                    let triangles = [a.triangle, b.triangle];
                    self.ghosts.push(Ghost::Edge { ends: a.edge, triangles });
                    raised.extend(triangles.map(|triangle| (triangle, ghost)));
                }
                [a, ..] => faults.push(a.edge),
                [] => {}
            }
        }
        match faults.is_empty() {
            true => Ok(raised),
            false => Err(BlendError::NotManifold { edges: faults, vertices: Vec::new() }),
        }
    }

    /// Ghosts over the vertices of several triangles.
    fn over_vertices(&mut self) -> Result<Vec<(u32, u32)>, BlendError> {
        let sides = self.triangles.sides();
        let is_fault =
            |edge: &&[Side]| edge.len() > 2 || edge.len() == 2 && edge[0].rises == edge[1].rises;
        let edges = sides.chunk_by(|a, b| a.edge == b.edge);
        let faults: Vec<[u32; 2]> = edges.filter(is_fault).map(|edge| edge[0].edge).collect();
        let (starts, fans) = self.triangles.fans();
        let mut raised = Vec::with_capacity(fans.len());
        let mut split = Vec::new();
        for vertex in 0..self.triangles.vertices() {
            let range = [starts[vertex], starts[vertex + 1]];
            let fan = &fans[range[0] as usize..range[1] as usize];
            if fan.len() < 2 {
                continue;
            }
            if !self.is_one_fan(vertex as u32, fan) {
                split.push(vertex as u32);
            }
            let ghost = self.ghosts.len() as u32;
            self.ghosts.push(Ghost::Vertex { vertex: vertex as u32, fan: range });
            raised.extend(fan.iter().map(|triangle| (*triangle, ghost)));
        }
        self.fans = fans;
        match faults.is_empty() && split.is_empty() {
            true => Ok(raised),
            false => Err(BlendError::NotManifold { edges: faults, vertices: split }),
        }
    }

    /// Whether one goes from triangle to triangle around a vertex without leaving it.
    fn is_one_fan(&self, vertex: u32, fan: &[u32]) -> bool {
        // The corner after the vertex and the one before it: where one triangle ends the next
        // begins. An open fan is walked from its beginning, a closed one from anywhere.
        let ends = fan.iter().map(|triangle| {
            let corners = self.triangles.as_slice()[*triangle as usize];
            let at = corners.iter().position(|corner| *corner == vertex).unwrap_or(0);
            [corners[(at + 1) % 3], corners[(at + 2) % 3]]
        });
        let mut by_begin: Vec<[u32; 2]> = ends.collect();
        let mut all_ends: Vec<u32> = by_begin.iter().map(|[_, end]| *end).collect();
        by_begin.sort_unstable();
        all_ends.sort_unstable();
        let open = by_begin.iter().find(|[begin, _]| all_ends.binary_search(begin).is_err());
        let start = open.unwrap_or(&by_begin[0]);
        let (mut reached, mut end) = (1, start[1]);
        while let Ok(next) = by_begin.binary_search_by_key(&end, |[begin, _]| *begin)
            && end != start[0]
            && reached <= fan.len()
        {
            (reached, end) = (reached + 1, by_begin[next][1]);
        }
        reached == fan.len()
    }

    /// Leaves out the tetrahedra that are not positive in every shape, and says how many.
    ///
    /// - `normals`: the triangles' in each shape.
    /// - `places`: where the ghosts are in each shape; those not there yet are added.
    fn keep_positive(
        &self,
        raised: &mut Vec<(u32, u32)>,
        shapes: &[&[Point]],
        normals: &[Vec<(Vector, f64)>],
        places: &mut [Vec<Point>],
    ) -> usize {
        let before = raised.len();
        let in_shapes = shapes.par_iter().zip(normals).zip(places);
        let in_shapes = in_shapes.map(|((shape, normals), places)| {
            for ghost in &self.ghosts[places.len()..] {
                places.push(self.place(ghost, shape, normals));
            }
            let is_positive = |(triangle, ghost): &(u32, u32)| {
                let [a, b, c] = self.triangles.as_slice()[*triangle as usize];
                let [a, b, c] = [&shape[a as usize], &shape[b as usize], &shape[c as usize]];
                super::structure::is_positive([a, b, c, &places[*ghost as usize]])
            };
            raised.iter().map(is_positive).collect::<Vec<bool>>()
        });
        let kept: Vec<Vec<bool>> = in_shapes.collect();
        let mut at = 0..;
        raised.retain(|_| at.next().is_some_and(|at: usize| kept.iter().all(|kept| kept[at])));
        before - raised.len()
    }

    /// Forgets ghosts without tetrahedra and numbers the rest.
    fn settle(&mut self, mut raised: Vec<(u32, u32)>) {
        raised.sort_unstable_by_key(|(triangle, ghost)| (*ghost, *triangle));
        let vertices = self.triangles.vertices();
        let (mut ghosts, mut corners) = (Vec::new(), Vec::with_capacity(raised.len()));
        for of_ghost in raised.chunk_by(|a, b| a.1 == b.1) {
            let ghost = (vertices + ghosts.len()) as u32;
            for (triangle, old) in of_ghost {
                if ghosts.len() + vertices == ghost as usize {
                    ghosts.push(self.ghosts[*old as usize].clone());
                }
                let [a, b, c] = self.triangles.as_slice()[*triangle as usize];
                corners.push([a, b, c, ghost]);
            }
        }
        self.ghosts = ghosts;
        self.structure = Structure::with_ghosts(vertices, self.ghosts.len(), corners);
    }
}
