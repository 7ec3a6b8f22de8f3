//! What is at a vertex, and what hangs together.

use super::Structure;
use super::structure::incidence;

/// The tetrahedra at each vertex, and the parts that hang together by vertices.
#[derive(Debug, Clone)]
pub(super) struct Connections {
    starts: Vec<u32>,
    at: Vec<u32>,
    /// The part of each tetrahedron.
    part_of: Vec<u32>,
    parts: usize,
}

impl Connections {
    pub(super) fn new(structure: &Structure) -> Self {
        let (starts, at) = incidence(structure.tetrahedra(), structure.vertices());
        let part_of = vec![u32::MAX; structure.tetrahedra().len()];
        let mut found = Self { starts, at, part_of, parts: 0 };
        let mut spread = Spread::new(structure);
        for seed in 0..structure.tetrahedra().len() {
            if found.part_of[seed] == u32::MAX {
                let from = spread.order.len();
                spread.from(&found, structure, seed as u32);
                for tetrahedron in &spread.order[from..] {
                    found.part_of[*tetrahedron as usize] = found.parts as u32;
                }
                found.parts += 1;
            }
        }
        found
    }

    /// The tetrahedra at a vertex.
    pub(super) fn at(&self, vertex: usize) -> &[u32] {
        &self.at[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// The part of each tetrahedron.
    pub(super) fn part_of(&self) -> &[u32] {
        &self.part_of
    }

    /// How many parts there are.
    pub(super) fn parts(&self) -> usize {
        self.parts
    }

    /// The part of a vertex, if it is in any tetrahedron.
    pub(super) fn part_of_vertex(&self, vertex: usize) -> Option<usize> {
        self.at(vertex).first().map(|tetrahedron| self.part_of[*tetrahedron as usize] as usize)
    }

    /// All tetrahedra, breadth-first from the one of each part whose `rank` is least, the first of
    /// equals: each but these shares a vertex with an earlier one.
    pub(super) fn breadth_first(
        &self,
        structure: &Structure,
        rank: impl Fn(usize) -> f64,
    ) -> Vec<u32> {
        let mut seeds: Vec<Option<(f64, u32)>> = vec![None; self.parts];
        for (tetrahedron, part) in self.part_of.iter().enumerate() {
            let (seed, rank) = (&mut seeds[*part as usize], rank(tetrahedron));
            if seed.is_none_or(|(least, _)| rank < least) {
                *seed = Some((rank, tetrahedron as u32));
            }
        }
        let mut spread = Spread::new(structure);
        for (_, seed) in seeds.into_iter().flatten() {
            spread.from(self, structure, seed);
        }
        spread.order
    }
}

/// A walk that goes everywhere once.
struct Spread {
    order: Vec<u32>,
    is_reached: Vec<bool>,
    is_spent: Vec<bool>,
}

impl Spread {
    fn new(structure: &Structure) -> Self {
        let tetrahedra = structure.tetrahedra().len();
        Self {
            order: Vec::with_capacity(tetrahedra),
            is_reached: vec![false; tetrahedra],
            is_spent: vec![false; structure.vertices()],
        }
    }

    fn from(&mut self, connections: &Connections, structure: &Structure, seed: u32) {
        let Self { order, is_reached, is_spent } = self;
        let mut next = order.len();
        is_reached[seed as usize] = true;
        order.push(seed);
        while let Some(here) = order.get(next).copied() {
            next += 1;
            // The last corner first: around a ghost neighbours share a face.
            for corner in structure.tetrahedra()[here as usize].iter().rev() {
                if std::mem::replace(&mut is_spent[*corner as usize], true) {
                    continue;
                }
                for other in connections.at(*corner as usize) {
                    if !std::mem::replace(&mut is_reached[*other as usize], true) {
                        order.push(*other);
                    }
                }
            }
        }
    }
}
