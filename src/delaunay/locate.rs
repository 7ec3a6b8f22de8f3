//! Finding a simplex in conflict with a point: a visibility walk from the one made last.
//!
//! Each step crosses a facet that has the point strictly on its far side. In a Delaunay
//! triangulation such steps lower the power of the point to the sphere, so no cell comes twice
//! (Edelsbrunner 1989; Devillers, Pion & Teillaud 2002).

use super::dimension::Dimension;
use super::triangulation::Triangulation;

/// Where a point is.
pub(super) enum Place {
    /// In conflict with this cell.
    Conflict(u32),
    /// Equal to this vertex.
    Vertex(u32),
}

impl<const D: usize, const N: usize> Triangulation<D, N>
where
    Self: Dimension<D, N>,
{
    /// Finds a cell in conflict with `point`, or the vertex it equals.
    pub(super) fn locate(&self, point: u32) -> Place {
        let infinity = self.infinity();
        let mut cell = self.last;
        let outer = self.cells[cell as usize].vertices.iter().position(|&v| v == infinity);
        if let Some(facet) = outer {
            cell = self.cells[cell as usize].neighbours[facet].cell();
        }
        let mut entered = usize::MAX;
        'walk: loop {
            if self.conflicts(cell, point) {
                return Place::Conflict(cell);
            }
            let neighbours = self.cells[cell as usize].neighbours;
            for facet in 0..N {
                if facet != entered && self.sees(cell, facet, point) {
                    let next = neighbours[facet];
                    (cell, entered) = (next.cell(), next.facet());
                    if self.cells[cell as usize].vertices.contains(&infinity) {
                        // Strictly beyond a facet of the hull.
                        return Place::Conflict(cell);
                    }
                    continue 'walk;
                }
            }
            // In the closed simplex, yet not strictly inside its sphere.
            let mut corners = self.cells[cell as usize].vertices.into_iter();
            let same = corners.find(|&v| self.points[v as usize] == self.points[point as usize]);
            return Place::Vertex(same.unwrap_or_else(|| unreachable!("a sphere holds its cell")));
        }
    }

    /// Whether `point` is strictly on the far side of a finite cell's facet.
    #[inline]
    fn sees(&self, cell: u32, facet: usize, point: u32) -> bool {
        let mut corners = self.cells[cell as usize].vertices;
        corners[facet] = point;
        let mut lifted = [&self.lifted[corners[0] as usize]; N];
        for i in 1..N {
            lifted[i] = &self.lifted[corners[i] as usize];
        }
        let value = Self::determinant(lifted);
        if value.abs() > self.bounds.solid {
            return value < 0.0;
        }
        Self::orientation(corners.map(|v| &self.points[v as usize])) < 0.0
    }

    /// Whether `point` is strictly inside the cell's sphere or strictly beyond the hull's facet it
    /// stands on, or in that facet's hyperplane and strictly inside its sphere there.
    #[inline]
    pub(super) fn conflicts(&self, cell: u32, point: u32) -> bool {
        let value = self.cells[cell as usize].plane.value(&self.lifted[point as usize]);
        if value.abs() > self.bounds.sphere {
            return value > 0.0;
        }
        self.conflicts_exactly(cell, point)
    }

    #[cold]
    fn conflicts_exactly(&self, cell: u32, point: u32) -> bool {
        let infinity = self.infinity();
        let mut cell = &self.cells[cell as usize];
        if let Some(place) = cell.vertices.iter().position(|&v| v == infinity) {
            let mut corners = cell.vertices;
            corners[place] = point;
            let side = Self::orientation(corners.map(|v| &self.points[v as usize]));
            if side != 0.0 {
                return side > 0.0;
            }
            // The sphere of the cell behind the facet cuts its hyperplane in the facet's sphere.
            cell = &self.cells[cell.neighbours[place].cell() as usize];
        }
        let corners = cell.vertices.map(|v| &self.points[v as usize]);
        Self::in_sphere(corners, &self.points[point as usize]) > 0.0
    }
}
