//! Finding a tetrahedron in conflict with a point: a visibility walk from the one made last.
//!
//! Each step crosses a facet that has the point strictly on its far side. In a Delaunay
//! triangulation such steps lower the power of the point to the sphere, so no cell comes twice
//! (Edelsbrunner 1989; Devillers, Pion & Teillaud 2002).

use super::Workspace;
use super::cells::Lifted;
use super::predicates::{in_sphere, orientation};
use crate::geometry::Point;

/// Where a point is.
pub(super) enum Place {
    /// In conflict with this cell.
    Conflict(u32),
    /// Equal to this vertex.
    Vertex(u32),
}

impl Workspace {
    /// Finds a cell in conflict with `point`, or the vertex it equals.
    pub(super) fn locate(&self, points: &[Point], point: u32) -> Place {
        let infinity = points.len() as u32;
        let mut cell = self.last;
        let outer = self.cells[cell as usize].vertices.iter().position(|&v| v == infinity);
        if let Some(facet) = outer {
            cell = self.cells[cell as usize].neighbours[facet] >> 2;
        }
        let mut entered = usize::MAX;
        'walk: loop {
            if self.conflicts(points, cell, point) {
                return Place::Conflict(cell);
            }
            let neighbours = self.cells[cell as usize].neighbours;
            for facet in 0..4 {
                if facet != entered && self.sees(points, cell, facet, point) {
                    let next = neighbours[facet];
                    (cell, entered) = (next >> 2, (next & 3) as usize);
                    if self.cells[cell as usize].vertices.contains(&infinity) {
                        // Strictly beyond a face of the hull.
                        return Place::Conflict(cell);
                    }
                    continue 'walk;
                }
            }
            // In the closed tetrahedron, yet not strictly inside its sphere.
            let mut corners = self.cells[cell as usize].vertices.into_iter();
            let same = corners.find(|&v| points[v as usize] == points[point as usize]);
            return Place::Vertex(same.unwrap_or_else(|| unreachable!("a sphere holds its cell")));
        }
    }

    /// Whether `point` is strictly on the far side of a finite cell's facet.
    #[inline]
    fn sees(&self, points: &[Point], cell: u32, facet: usize, point: u32) -> bool {
        let mut corners = self.cells[cell as usize].vertices;
        corners[facet] = point;
        let [a, b, c, d] = corners.map(|v| self.lifted[v as usize]);
        let value = determinant(&a, &b, &c, &d);
        if value.abs() > self.bounds.solid {
            return value < 0.0;
        }
        let [a, b, c, d] = corners.map(|v| &points[v as usize]);
        orientation(a, b, c, d) < 0.0
    }

    /// Whether `point` is strictly inside the cell's sphere or strictly beyond the hull's face it
    /// stands on, or in that face's plane and strictly inside its circle.
    #[inline]
    pub(super) fn conflicts(&self, points: &[Point], cell: u32, point: u32) -> bool {
        let n = &self.cells[cell as usize].plane;
        let p = &self.lifted[point as usize];
        let value = n[0] * p[0] + n[1] * p[1] + n[2] * p[2] + n[3] * p[3] + n[4];
        if value.abs() > self.bounds.sphere {
            return value > 0.0;
        }
        self.conflicts_exactly(points, cell, point)
    }

    #[cold]
    fn conflicts_exactly(&self, points: &[Point], cell: u32, point: u32) -> bool {
        let infinity = points.len() as u32;
        let mut cell = &self.cells[cell as usize];
        let p = &points[point as usize];
        if let Some(place) = cell.vertices.iter().position(|&v| v == infinity) {
            let mut corners = cell.vertices;
            corners[place] = point;
            let [a, b, c, d] = corners.map(|v| &points[v as usize]);
            let side = orientation(a, b, c, d);
            if side != 0.0 {
                return side > 0.0;
            }
            // The sphere of the cell behind the face cuts its plane in the face's circle.
            cell = &self.cells[(cell.neighbours[place] >> 2) as usize];
        }
        in_sphere(cell.vertices.map(|v| &points[v as usize]), p) > 0.0
    }
}

/// `det(b − a, c − a, d − a)`, rounded.
#[inline(always)]
fn determinant(a: &Lifted, b: &Lifted, c: &Lifted, d: &Lifted) -> f64 {
    let minus = |p: &Lifted| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
    let (b, c, d) = (minus(b), minus(c), minus(d));
    b[0] * (c[1] * d[2] - c[2] * d[1])
        + b[1] * (c[2] * d[0] - c[0] * d[2])
        + b[2] * (c[0] * d[1] - c[1] * d[0])
}
