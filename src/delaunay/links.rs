//! The cells of one insertion made each other's neighbours.
//!
//! All hold the new point, so two are neighbours exactly if their facets of the cavity share a
//! ridge: an edge in three dimensions, a triangle in four.

use super::cavity::Facet;
use super::cells::{Cell, Side};

/// Pairs the ridges of the cavity's facets, each of which two facets share.
///
/// In three dimensions they do so in opposite directions: corners get numbers from 0 within the
/// round and the edge `(i, j)` the place `SIDE · i + j` of a table, which needs no clearing, as what
/// is read was written in the same round. Ridges of more corners, and those of cavities of more
/// corners, which are rare, are found by a hash of their corners instead.
#[derive(Clone, Debug, Default)]
pub(super) struct Links<const D: usize, const N: usize> {
    /// `SIDE · round + number` for each vertex; stale where the round is another.
    numbers: Vec<u32>,
    table: Vec<Side<N>>,
    /// Corners met this round.
    count: u32,
    /// Ridges by hash, in the first free place from there on.
    pub(super) ridges: Vec<Ridge<N>>,
}

/// A ridge of which one side has been met.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ridge<const N: usize> {
    /// Its corners, ascending, and last the round, 32 bits each; the place is free if that is
    /// another.
    key: u128,
    side: Side<N>,
}

/// Corners a cavity may have to be linked by the table.
pub(super) const SIDE: usize = 64;
const TABLE: usize = SIDE * SIDE;

/// One round of [`Links`] while facets come in.
pub(super) struct Numbering<'a, const N: usize> {
    numbers: &'a mut [u32],
    table: &'a mut [Side<N>; TABLE],
    count: &'a mut u32,
    round: u32,
}

/// The place of the directed edge `(i, j)`; the mask says to the compiler that there is one.
#[inline(always)]
fn place(i: u32, j: u32) -> usize {
    (SIDE * i as usize + j as usize) & (TABLE - 1)
}

impl<const N: usize> Numbering<'_, N> {
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
    pub(super) fn add<const D: usize>(&mut self, cell: u32, corners: [u32; D]) -> Facet<D, N> {
        let mut numbered = corners;
        if D == 3 {
            for i in 0..D {
                numbered[i] = self.number(corners[i]);
            }
            for i in 0..D {
                let edge = place(numbered[(i + 1) % D], numbered[(i + 2) % D]);
                self.table[edge] = Side::new(cell, i + 1);
            }
        }
        Facet { corners: numbered, outside: Side::new(cell, 0) }
    }
}

impl<const D: usize, const N: usize> Links<D, N> {
    /// Prepares for `count` points and the vertex at infinity.
    pub(super) fn start(&mut self, count: usize) {
        self.numbers.clear();
        self.numbers.resize(count + 1, 0);
        self.table.resize(TABLE, Side::default());
        self.ridges.clear();
    }

    pub(super) fn begin(&mut self, round: u32) -> Numbering<'_, N> {
        let Links { numbers, table, count, .. } = self;
        let table = table.first_chunk_mut().unwrap_or_else(|| unreachable!("sized by start"));
        *count = 0;
        Numbering { numbers, table, count, round }
    }

    /// Makes the cells of a round each other's neighbours; `made` as [`Numbering::add`] gave it.
    pub(super) fn join(&mut self, round: u32, made: &[Facet<D, N>], cells: &mut [Cell<N>]) {
        if D != 3 || self.count as usize > SIDE {
            return self.join_by_hash(round, made, cells);
        }
        let Some(table) = self.table.first_chunk::<TABLE>() else { return };
        for Facet { corners, outside } in made {
            let neighbours = &mut cells[outside.cell() as usize].neighbours;
            for i in 0..D {
                neighbours[i + 1] = table[place(corners[(i + 2) % D], corners[(i + 1) % D])];
            }
        }
    }

    #[inline(never)]
    fn join_by_hash(&mut self, round: u32, made: &[Facet<D, N>], cells: &mut [Cell<N>]) {
        // Half full when the last ridge has come.
        let bits = (made.len() * D).next_power_of_two().ilog2().max(1);
        if self.ridges.len() < 1 << bits {
            self.ridges.resize(1 << bits, Ridge { key: 0, side: Side::default() });
        }
        let ridges = &mut self.ridges[..1 << bits];
        for facet in made {
            let cell = facet.outside.cell();
            let mut corners = [0; D];
            for place in 0..D {
                let vertex = cells[cell as usize].vertices[place + 1];
                corners[place] = u64::from(vertex) << 32 | (place + 1) as u64;
            }
            // NOTE: without branches, which nobody could predict.
            for last in (1..D).rev() {
                for i in 0..last {
                    let (one, other) = (corners[i], corners[i + 1]);
                    (corners[i], corners[i + 1]) = (one.min(other), one.max(other));
                }
            }
            let vertex = |i: usize| (corners[i] >> 32) as u32;
            let all = (0..D).fold(0, |sum: u64, i| sum.wrapping_add(mixed(vertex(i))));
            for opposite in 0..D {
                let place = corners[opposite] as u32 as usize;
                let others = (0..D).filter(|&i| i != opposite);
                let key = others.fold(0, |key, i| key << 32 | u128::from(vertex(i)));
                let key = key << 32 | u128::from(round);
                let one = Side::new(cell, place);
                let mut at = (all.wrapping_sub(mixed(vertex(opposite))) >> (64 - bits)) as usize;
                while ridges[at].key as u32 == round && ridges[at].key != key {
                    at = (at + 1) & (ridges.len() - 1);
                }
                if ridges[at].key == key {
                    let other = ridges[at].side;
                    cells[cell as usize].neighbours[place] = other;
                    cells[other.cell() as usize].neighbours[other.facet()] = one;
                } else {
                    ridges[at] = Ridge { key, side: one };
                }
            }
        }
    }
}

/// A number whose sums over sets of vertices rarely agree in the upper bits.
#[inline(always)]
fn mixed(vertex: u32) -> u64 {
    let product = (u64::from(vertex) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (product ^ (product >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93)
}
