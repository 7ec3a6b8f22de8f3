//! One insertion: the cells in conflict are removed and their hole is joined to the point.

use super::Workspace;
use super::cells::{Cell, FREE, above, facets, plane};
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
        self.links.join(&self.boundary, &mut self.cells);
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
            for (corners, outside) in facets(vertices).into_iter().zip(neighbours) {
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
                self.boundary.push(Facet { corners, outside });
            }
        }
    }

    /// Puts a cell on every facet of the cavity, first in the places of the cells removed.
    fn fill(&mut self, infinity: u32, point: u32) {
        let q = self.lifted[point as usize];
        self.lifted[infinity as usize] = above(&q, &self.bounds);
        let mut vacant = self.cavity.iter().copied();
        let mut numbering = self.links.begin(self.round);
        for facet in &mut self.boundary {
            let Facet { corners: [i, j, k], outside } = *facet;
            let [a, b, c] = [i, j, k].map(|v| &self.lifted[v as usize]);
            let made = Cell {
                vertices: [point, i, j, k],
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
            *facet = numbering.add(cell, [i, j, k]);
            self.last = cell;
        }
        for cell in vacant {
            self.cells[cell as usize].vertices = FREE;
            self.free.push(cell);
        }
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
    /// The edges of a large cavity.
    pub(super) edges: Vec<(u64, u32)>,
    /// Corners met this round.
    count: u32,
}

/// Corners a cavity may have to be linked by the table.
pub(super) const SIDE: usize = 64;
const TABLE: usize = SIDE * SIDE;

/// One round of [`Links`] while facets come in.
struct Numbering<'a> {
    numbers: &'a mut [u32],
    table: &'a mut [u32; TABLE],
    count: &'a mut u32,
    round: u32,
}

/// The place of the directed edge `(i, j)`; the mask says to the compiler that there is one.
#[inline(always)]
fn place(i: u32, j: u32) -> usize {
    (SIDE * i as usize + j as usize) & (TABLE - 1)
}

impl Numbering<'_> {
    #[inline(always)]
    fn number(&mut self, vertex: u32) -> u32 {
        let side = SIDE as u32;
        let number = &mut self.numbers[vertex as usize];
        if *number / side != self.round {
            *number = side * self.round + *self.count % side;
            *self.count += 1;
        }
        *number % side
    }

    /// Adds a cell made on a facet; returns the facet with numbers for corners and the cell.
    #[inline(always)]
    fn add(&mut self, cell: u32, [i, j, k]: [u32; 3]) -> Facet {
        let (a, b, c) = (self.number(i), self.number(j), self.number(k));
        self.table[place(b, c)] = 4 * cell + 1;
        self.table[place(c, a)] = 4 * cell + 2;
        self.table[place(a, b)] = 4 * cell + 3;
        Facet { corners: [a, b, c], outside: cell }
    }
}

impl Links {
    /// Prepares for `count` points and the vertex at infinity.
    pub(super) fn start(&mut self, count: usize) {
        self.numbers.clear();
        self.numbers.resize(count + 1, 0);
        self.table.resize(TABLE, 0);
    }

    fn begin(&mut self, round: u32) -> Numbering<'_> {
        let Links { numbers, table, count, .. } = self;
        let table = table.first_chunk_mut().unwrap_or_else(|| unreachable!("sized by start"));
        *count = 0;
        Numbering { numbers, table, count, round }
    }

    /// Makes the cells of a round each other's neighbours; `made` as [`Numbering::add`] gave it.
    fn join(&mut self, made: &[Facet], cells: &mut [Cell]) {
        if self.count as usize > SIDE {
            return self.join_sorted(made, cells);
        }
        let Some(table) = self.table.first_chunk::<TABLE>() else { return };
        for &Facet { corners: [a, b, c], outside: cell } in made {
            let neighbours = &mut cells[cell as usize].neighbours;
            neighbours[1] = table[place(c, b)];
            neighbours[2] = table[place(a, c)];
            neighbours[3] = table[place(b, a)];
        }
    }

    #[cold]
    fn join_sorted(&mut self, made: &[Facet], cells: &mut [Cell]) {
        self.edges.clear();
        for &Facet { outside: cell, .. } in made {
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
