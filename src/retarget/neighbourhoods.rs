//! The neighbourhoods that `local_global` turns: packed once a solve, turned eight at a time.
//!
//! `C = Σⱼ w̄ⱼ e'ⱼ eⱼᵀ + ε Σⱼ w̄ⱼ‖eⱼ‖² R_before`, `R = argmax tr(Rᵀ C)` (Sorkine & Alexa 2007,
//! eq. 5, with the memory of DESIGN 4.2, which keeps flat neighbourhoods' rotations unique and the
//! energy falling).
//!
//! Only what can move the solution is packed: edges without weight are left out, and so are the
//! neighbourhoods that then hold no unknown, such as most of a known partner's. Packed with every
//! solve and not with the assembly, so that the coefficients alone say what the mesh is.

use nalgebra::Matrix3;
use pulp::{Arch, Simd, WithSimd};

use super::system::Pattern;
use crate::geometry::Point;
use crate::rotations::{IDENTITIES, LANES, Quaternions, best_rotations, lane_of, matrix};

/// One edge of a neighbourhood.
#[derive(Debug, Clone, Copy, Default)]
struct Edge {
    /// `w̄ e` `x y z 0` `[m]` in the reference, from the neighbour to the centre.
    weighted: [f64; 4],
    /// The neighbour.
    vertex: u32,
    /// The unknown that the neighbour is; not read of a known one.
    unknown: u32,
}

/// One neighbourhood: its centre and where its edges are.
#[derive(Debug, Clone, Copy, Default)]
struct Neighbourhood {
    /// The centre.
    vertex: u32,
    /// The unknown that the centre is, if it is one.
    unknown: Option<u32>,
    /// Edges to unknowns are `first..known`, edges to known vertices `known..end`.
    first: u32,
    known: u32,
    end: u32,
    /// `ε Σⱼ w̄ⱼ‖eⱼ‖²` `[m²]`.
    memory: f64,
}

/// The neighbourhoods of a solve and their rotations.
#[derive(Debug, Clone)]
pub(super) struct Neighbourhoods {
    /// The first `count` are in use, rising by vertex.
    neighbourhoods: Vec<Neighbourhood>,
    count: usize,
    edges: Vec<Edge>,
    /// Neighbourhood `i` has lane `i % LANES` of `i / LANES`.
    rotations: Vec<Quaternions>,
    arch: Arch,
}

impl Neighbourhoods {
    /// Room for that many vertices and edges; everything later works inside it.
    pub(super) fn new(vertices: usize, edges: usize) -> Self {
        Self {
            neighbourhoods: vec![Neighbourhood::default(); vertices],
            count: 0,
            edges: vec![Edge::default(); edges],
            rotations: vec![IDENTITIES; vertices.div_ceil(LANES)],
            arch: Arch::new(),
        }
    }

    /// Packs the neighbourhoods that hold an unknown, unturned.
    ///
    /// - `coefficients`: `−w̄` per entry of the pattern's rows.
    /// - `reference`: `[m]`, where the edges are taken from.
    /// - `memory`: `ε` `[-]`.
    pub(super) fn pack(
        &mut self,
        pattern: &Pattern,
        coefficients: &[f64],
        reference: &[Point],
        memory: f64,
    ) {
        let (mut count, mut end) = (0, 0);
        for vertex in pattern.open_rows.iter().map(|vertex| *vertex as usize) {
            let centre = reference[vertex];
            let row = || {
                let row = pattern.row(vertex).filter(|(_, column)| *column != vertex);
                row.filter(|(entry, _)| coefficients[*entry] != 0.0)
            };
            let (unknown, first, mut size) = (pattern.unknown(vertex), end, 0.0);
            let mut push = |entry: usize, column: usize, unknown: usize| {
                let (weight, edge) = (-coefficients[entry], centre - reference[column]);
                size += weight * edge.norm_squared();
                let weighted = (weight * edge).push(0.0).into();
                self.edges[end] = Edge { weighted, vertex: column as u32, unknown: unknown as u32 };
                end += 1;
                end
            };
            let mut known = first;
            for (entry, column) in row() {
                if let Some(at) = pattern.unknown(column) {
                    known = push(entry, column, at);
                }
            }
            if unknown.is_none() && known == first {
                continue;
            }
            for (entry, column) in row().filter(|(_, column)| pattern.unknown(*column).is_none()) {
                push(entry, column, 0);
            }
            self.neighbourhoods[count] = Neighbourhood {
                vertex: vertex as u32,
                unknown: unknown.map(|at| at as u32),
                first: first as u32,
                known: known as u32,
                end: end as u32,
                memory: memory * size,
            };
            count += 1;
        }
        self.count = count;
        self.rotations.fill(IDENTITIES);
    }

    /// The rotation of a vertex' neighbourhood, if it is among those that are turned.
    pub(super) fn rotation(&self, vertex: usize) -> Option<Matrix3<f64>> {
        let turned = &self.neighbourhoods[..self.count];
        let at = turned.binary_search_by_key(&vertex, |n| n.vertex as usize).ok()?;
        let rotation = matrix(lane_of(&self.rotations[at / LANES], at % LANES));
        Some(Matrix3::from_fn(|i, j| rotation[i][j]))
    }

    /// Turns every neighbourhood to its best at `positions`, and adds `weight` times what its
    /// turned edges pull the unknowns towards to `pulls` (`x y z 0` `[m]`).
    pub(super) fn turn(&mut self, positions: &[Point], weight: f64, pulls: &mut [[f64; 4]]) {
        self.arch.dispatch(Turn { neighbourhoods: self, positions, weight, pulls });
    }
}

/// [`Neighbourhoods::turn`], compiled once for each set of vector instructions; all it calls is
/// inlined.
struct Turn<'a> {
    neighbourhoods: &'a mut Neighbourhoods,
    positions: &'a [Point],
    weight: f64,
    pulls: &'a mut [[f64; 4]],
}

impl WithSimd for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { neighbourhoods, positions, weight, pulls } = self;
        let Neighbourhoods { neighbourhoods, count, edges, rotations, .. } = neighbourhoods;
        for (block, stored) in neighbourhoods[..*count].chunks(LANES).zip(rotations) {
            // All numbers of a block stand in local arrays: only of those does the compiler know
            // that they do not overlap, and finds the lanes. Lanes to spare do not turn.
            let mut rotations = *stored;
            let mut matrices = [[[0.0; LANES]; 3]; 3];
            let mut memory = [1.0; LANES];
            for (lane, neighbourhood) in block.iter().enumerate() {
                let covariance = covariance(neighbourhood, edges, positions);
                for i in 0..3 {
                    for j in 0..3 {
                        matrices[i][j][lane] = covariance[i][j];
                    }
                }
                memory[lane] = neighbourhood.memory;
            }
            for lane in 0..LANES {
                let before = matrix(lane_of(&rotations, lane));
                for i in 0..3 {
                    for j in 0..3 {
                        let kept = memory[lane] * before[i][j];
                        matrices[i][j][lane] += kept;
                    }
                }
            }
            best_rotations(&matrices, &mut rotations);
            *stored = rotations;
            let mut columns = [[[0.0; 4]; 3]; LANES];
            for lane in 0..LANES {
                let rotation = matrix(lane_of(&rotations, lane));
                for i in 0..3 {
                    for j in 0..3 {
                        columns[lane][j][i] = weight * rotation[i][j];
                    }
                }
            }
            for (neighbourhood, columns) in block.iter().zip(&columns) {
                pull(neighbourhood, edges, columns, pulls);
            }
        }
    }
}

/// `Σⱼ w̄ⱼ e'ⱼ eⱼᵀ`, its columns `x y z 0`.
#[inline(always)]
fn covariance(neighbourhood: &Neighbourhood, edges: &[Edge], positions: &[Point]) -> [[f64; 4]; 3] {
    let centre = positions[neighbourhood.vertex as usize];
    let mut sum = [[0.0; 4]; 3];
    for edge in &edges[neighbourhood.first as usize..neighbourhood.end as usize] {
        let other = positions[edge.vertex as usize];
        let along = [centre.x - other.x, centre.y - other.y, centre.z - other.z];
        for i in 0..3 {
            for j in 0..4 {
                sum[i][j] = along[i].mul_add(edge.weighted[j], sum[i][j]);
            }
        }
    }
    sum
}

/// Adds what the turned edges pull both of their ends towards; `columns` of the rotation.
#[inline(always)]
fn pull(
    neighbourhood: &Neighbourhood,
    edges: &[Edge],
    columns: &[[f64; 4]; 3],
    pulls: &mut [[f64; 4]],
) {
    let mut sum = [0.0; 4];
    let (first, known, end) =
        (neighbourhood.first as usize, neighbourhood.known as usize, neighbourhood.end as usize);
    for edge in &edges[first..known] {
        let target = &mut pulls[edge.unknown as usize];
        for j in 0..4 {
            sum[j] += edge.weighted[j];
        }
        for j in 0..3 {
            for i in 0..4 {
                target[i] = (-edge.weighted[j]).mul_add(columns[j][i], target[i]);
            }
        }
    }
    if let Some(at) = neighbourhood.unknown {
        for edge in &edges[known..end] {
            for j in 0..4 {
                sum[j] += edge.weighted[j];
            }
        }
        let target = &mut pulls[at as usize];
        for j in 0..3 {
            for i in 0..4 {
                target[i] = sum[j].mul_add(columns[j][i], target[i]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::mesh::{Edge, Pair, Topology};
    use crate::retarget::{Constraint, Transform};
    use crate::skeleton::{Role, Skeleton};

    /// A handshake without weight is as if it were not there; with weight it adds the partner's
    /// hand to the robot's joints.
    #[test]
    fn only_what_can_move_the_solution_is_packed() {
        const FRAMES: usize = 3;
        let skeleton = Skeleton::nite();
        let pair = Arc::new(Pair::new([skeleton.clone(), skeleton.clone()]));
        let hand = |role| pair.vertices(role).nth(8).unwrap();
        let hands = [hand(Role::First), hand(Role::Second)];
        let handshake = Edge::new(hands[0], hands[1]);
        let topology = Arc::new(Topology::new(pair.clone(), [handshake]).unwrap());
        let constraints: Vec<Constraint> = (0..FRAMES * 30)
            .map(|v| if v % 30 < 15 { Constraint::Fixed } else { Constraint::Free })
            .collect();
        let pattern = Pattern::new(topology, &constraints, Transform::LocalGlobal);
        let reference: Vec<Point> = (0..FRAMES * 30)
            .map(|v| f64::from(v as u32))
            .map(|v| Point::new(v.sin(), v.cos(), 0.1 * v))
            .collect();
        let mut neighbourhoods = Neighbourhoods::new(reference.len(), pattern.entries());
        for (weight, per_frame) in [(0.0, 15), (0.5, 16)] {
            let mut coefficients = vec![-1.0; pattern.entries()];
            for vertex in 0..reference.len() {
                for (entry, column) in pattern.row(vertex) {
                    if (vertex % 30 < 15) != (column % 30 < 15) {
                        coefficients[entry] = -weight;
                    }
                }
            }
            neighbourhoods.pack(&pattern, &coefficients, &reference, 1e-3);
            let packed = &neighbourhoods.neighbourhoods[..neighbourhoods.count];
            assert_eq!(packed.len(), FRAMES * per_frame);
            let hand = hands[0].index();
            assert_eq!(neighbourhoods.rotation(hand).is_some(), weight > 0.0);
            let robots = packed.iter().find(|n| n.vertex as usize == hands[1].index()).unwrap();
            // Forearm and the next frame's hand; the handshake is the only known end.
            assert_eq!(
                (robots.known - robots.first, robots.end - robots.known),
                (2, per_frame as u32 - 15)
            );
        }
    }
}
