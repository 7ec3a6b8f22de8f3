//! One insertion: the cells in conflict are removed and their hole is joined to the point.

use super::Workspace;
use super::cells::{Cell, FACET, FREE, above, plane};
use crate::geometry::Point;

/// A facet of the cavity: positively oriented with the new point before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    corners: [u32; 3],
    /// The facet as the cell outside numbers it, `4 · cell + facet`.
    outside: u32,
}

impl Workspace {
    /// Makes `point` a vertex; `first` is in conflict with it.
    pub(super) fn insert(&mut self, points: &[Point], point: u32, first: u32) {
        self.round += 1;
        self.collect(points, point, first);
        self.fill(points.len() as u32, point);
        self.link();
    }

    /// Collects the cells in conflict, which are connected, and the facets around them.
    fn collect(&mut self, points: &[Point], point: u32, first: u32) {
        let (clear, conflict) = (2 * self.round, 2 * self.round + 1);
        self.cavity.clear();
        self.boundary.clear();
        self.cavity.push(first);
        self.cells[first as usize].mark = conflict;
        let mut next = 0;
        while let Some(&cell) = self.cavity.get(next) {
            next += 1;
            let Cell { vertices, neighbours, .. } = self.cells[cell as usize];
            for (facet, outside) in neighbours.into_iter().enumerate() {
                let other = outside >> 2;
                let mark = self.cells[other as usize].mark;
                if mark == conflict {
                    continue;
                }
                if mark != clear {
                    if self.conflicts(points, other, point) {
                        self.cells[other as usize].mark = conflict;
                        self.cavity.push(other);
                        continue;
                    }
                    self.cells[other as usize].mark = clear;
                }
                self.boundary.push(Facet { corners: FACET[facet].map(|i| vertices[i]), outside });
            }
        }
    }

    /// Puts a cell on every facet of the cavity, first in the places of the cells removed.
    fn fill(&mut self, infinity: u32, point: u32) {
        let q = self.lifted[point as usize];
        self.lifted[infinity as usize] = above(&q, &self.bounds);
        let mut vacant = self.cavity.iter().copied();
        self.links.round(self.round);
        for &Facet { corners, outside } in &self.boundary {
            let [a, b, c] = corners.map(|v| &self.lifted[v as usize]);
            let made = Cell {
                vertices: [point, corners[0], corners[1], corners[2]],
                neighbours: [outside, 0, 0, 0],
                plane: plane(&q, a, b, c),
                mark: 0,
            };
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
            self.cells[(outside >> 2) as usize].neighbours[(outside & 3) as usize] = 4 * cell;
            self.links.add(cell, corners);
            self.last = cell;
        }
        for cell in vacant {
            self.cells[cell as usize].vertices = FREE;
            self.free.push(cell);
        }
    }

    /// Makes the new cells each other's neighbours.
    fn link(&mut self) {
        self.links.join(&mut self.cells);
    }
}

/// Pairs the edges of the cavity's facets, each of which two facets share in opposite directions.
///
/// Corners get numbers from 0 within the round and the edge `(i, j)` the place `SIDE · i + j` of a
/// table, which needs no clearing: what is read was written in the same round. Cavities of more
/// corners are rare and sorted instead.
#[derive(Clone, Debug, Default)]
pub(super) struct Links {
    /// `SIDE · round + number` for each vertex; stale where the round is another.
    numbers: Vec<u32>,
    table: Vec<u32>,
    /// Cells made this round with their corners' numbers.
    made: Vec<(u32, [u32; 3])>,
    /// The edges of a large cavity.
    edges: Vec<(u64, u32)>,
    round: u32,
    next: u32,
}

/// Corners a cavity may have to be linked by the table.
const SIDE: u32 = 64;

impl Links {
    /// Prepares for `count` points and the vertex at infinity.
    pub(super) fn start(&mut self, count: usize) {
        self.numbers.clear();
        self.numbers.resize(count + 1, 0);
        self.table.resize((SIDE * SIDE) as usize, 0);
    }

    fn round(&mut self, round: u32) {
        self.made.clear();
        (self.round, self.next) = (round, 0);
    }

    /// Adds a cell made on a facet with these corners.
    fn add(&mut self, cell: u32, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|v| {
            let number = &mut self.numbers[v as usize];
            if *number / SIDE != self.round {
                *number = SIDE * self.round + (self.next % SIDE);
                self.next += 1;
            }
            *number % SIDE
        });
        self.made.push((cell, [a, b, c]));
        for (facet, [i, j]) in [(1, [b, c]), (2, [c, a]), (3, [a, b])] {
            self.table[(SIDE * i + j) as usize] = 4 * cell + facet;
        }
    }

    fn join(&mut self, cells: &mut [Cell]) {
        if self.next > SIDE {
            return self.join_sorted(cells);
        }
        for &(cell, [a, b, c]) in &self.made {
            let across = |i: u32, j: u32| self.table[(SIDE * i + j) as usize];
            let neighbours = &mut cells[cell as usize].neighbours;
            neighbours[1] = across(c, b);
            neighbours[2] = across(a, c);
            neighbours[3] = across(b, a);
        }
    }

    #[cold]
    fn join_sorted(&mut self, cells: &mut [Cell]) {
        self.edges.clear();
        for &(cell, _) in &self.made {
            let [_, a, b, c] = cells[cell as usize].vertices;
            for (facet, [i, j]) in [(1, [b, c]), (2, [c, a]), (3, [a, b])] {
                let key = u64::from(i.min(j)) << 32 | u64::from(i.max(j));
                self.edges.push((key, 4 * cell + facet));
            }
        }
        self.edges.sort_unstable();
        for pair in self.edges.chunks_exact(2) {
            let (one, other) = (pair[0].1, pair[1].1);
            cells[(one >> 2) as usize].neighbours[(one & 3) as usize] = other;
            cells[(other >> 2) as usize].neighbours[(other & 3) as usize] = one;
        }
    }
}
