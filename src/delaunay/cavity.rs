//! One insertion: the cells in conflict are removed and their hole is joined to the point.

use super::cells::{Cell, FREE, Plane, Side};
use super::dimension::Dimension;
use super::triangulation::Triangulation;

/// A facet of the cavity: positively oriented with the new point before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet<const D: usize, const N: usize> {
    pub(super) corners: [u32; D],
    /// The facet as the cell outside numbers it.
    pub(super) outside: Side<N>,
}

impl<const D: usize, const N: usize> Triangulation<D, N>
where
    Self: Dimension<D, N>,
{
    /// Makes `point` a vertex; `first` is in conflict with it.
    pub(super) fn insert(&mut self, point: u32, first: u32) {
        self.round += 1;
        self.collect(point, first);
        self.fill(point);
        self.links.join(self.round, &self.boundary, &mut self.cells);
    }

    /// Collects the cells in conflict, which are connected, and the facets around them.
    fn collect(&mut self, point: u32, first: u32) {
        let (clear, conflict) = (2 * self.round, 2 * self.round + 1);
        self.cavity.clear();
        self.boundary.clear();
        self.cavity.push(first);
        self.cells[first as usize].mark = conflict;
        let mut next = 0;
        while let Some(&cell) = self.cavity.get(next) {
            next += 1;
            let Cell { vertices, neighbours, .. } = self.cells[cell as usize];
            for (corners, outside) in Self::facets(vertices).into_iter().zip(neighbours) {
                let other = outside.cell();
                let mark = self.cells[other as usize].mark;
                if mark == conflict {
                    continue;
                }
                if mark != clear {
                    if self.conflicts(other, point) {
                        self.cells[other as usize].mark = conflict;
                        self.cavity.push(other);
                        continue;
                    }
                    self.cells[other as usize].mark = clear;
                }
                self.boundary.push(Facet { corners, outside });
            }
        }
    }

    /// Puts a cell on every facet of the cavity, first in the places of the cells removed.
    fn fill(&mut self, point: u32) {
        let infinity = self.infinity();
        self.lifted[infinity as usize] = self.bounds.above(&self.lifted[point as usize]);
        let mut vacant = self.cavity.iter().copied();
        let mut numbering = self.links.begin(self.round);
        for facet in &mut self.boundary {
            let Facet { corners, outside } = *facet;
            let mut vertices = [point; N];
            let mut lifted = [&self.lifted[point as usize]; N];
            for i in 0..D {
                vertices[i + 1] = corners[i];
                lifted[i + 1] = &self.lifted[corners[i] as usize];
            }
            let mut neighbours = [Side::default(); N];
            neighbours[0] = outside;
            let plane = Plane::through(lifted);
            let made = Cell { vertices, neighbours, plane, mark: 0 };
            let cell = match vacant.next().or_else(|| self.free.pop()) {
                Some(cell) => {
                    self.cells[cell as usize] = made;
                    cell
                }
                None => {
                    self.cells.push(made);
                    self.cells.len() as u32 - 1
                }
            };
            self.cells[outside.cell() as usize].neighbours[outside.facet()] = Side::new(cell, 0);
            *facet = numbering.add(cell, corners);
            self.last = cell;
        }
        for cell in vacant {
            self.cells[cell as usize].vertices[0] = FREE;
            self.free.push(cell);
        }
    }
}
