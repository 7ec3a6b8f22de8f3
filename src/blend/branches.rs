//! Rotations' vectors → those that go on from tetrahedron to tetrahedron: the continuous logarithm
//! (Kaji 2015, section 5).
//!
//! The vectors of one rotation differ by whole turns about its axis. What hangs together is gone
//! through breadth-first: each tetrahedron takes the vector nearest to the mean of those before it
//! at its corners, so that few that are turned oddly lead nobody astray. It begins with the one that
//! is turned least. If that is not at rest it may have come there by a whole turn: so it begins again
//! where it went beyond half a turn, and of a few such beginnings the one that turns all together
//! least counts.
//!
//! Near a whole turn there is no such vector: one that is turned by it and besides a little about
//! another axis has that other axis alone. So beyond half a turn a rotation is `exp(v) exp(r)`: `v`
//! goes on along the neighbours' axis as far as it takes, and the small rest `r` is blended apart.

use std::f64::consts::{PI, TAU};

use nalgebra::UnitQuaternion;

use super::Structure;
use super::connections::Connections;
use crate::geometry::Vector;

/// From how many beginnings it is tried at most.
const BEGINNINGS: usize = 3;

/// What is turned by less than this `[rad]` is at rest, and stays so.
const AT_REST: f64 = 1e-6;

/// A rotation by less than this `[rad]` has no axis worth its name.
const NO_AXIS: f64 = 1e-10;

/// A rotation: by one vector `[rad]` after the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Turn {
    /// Nearly all of it.
    pub(super) vector: Vector,
    /// What is done first; 0 up to half a turn.
    pub(super) rest: Vector,
}

/// The turns of all tetrahedra, continuous over neighbours.
///
/// - `principal`: their rotations' vectors of length ≤ π `[rad]`.
pub(super) fn continuous(
    structure: &Structure,
    connections: &Connections,
    principal: &[Vector],
) -> Vec<Turn> {
    let turning = |turns: &[Turn]| {
        let mut sums = vec![0.0; connections.parts()];
        for (part, turn) in connections.part_of().iter().zip(turns) {
            sums[*part as usize] += turn.vector.norm_squared();
        }
        sums
    };
    let from_least = |rank: &dyn Fn(usize) -> f64| {
        go_on(structure, &connections.breadth_first(structure, rank), principal)
    };
    let mut best = from_least(&|at| principal[at].norm_squared());
    let mut least = turning(&best);
    for (part, vector) in connections.part_of().iter().zip(principal) {
        if vector.norm() < AT_REST {
            least[*part as usize] = 0.0;
        }
    }
    for _ in 1..BEGINNINGS {
        let is_beyond = |at: usize| best[at].vector.norm_squared() > (PI + 1e-6) * (PI + 1e-6);
        if !(0..principal.len()).any(is_beyond) {
            break;
        }
        let rank = |at: usize| principal[at].norm() + if is_beyond(at) { 0.0 } else { TAU };
        let other = from_least(&rank);
        let turns = turning(&other);
        if turns.iter().zip(&least).all(|(turns, least)| turns >= least) {
            break;
        }
        for (at, part) in connections.part_of().iter().enumerate() {
            if turns[*part as usize] < least[*part as usize] {
                best[at] = other[at];
            }
        }
        for (least, turns) in least.iter_mut().zip(turns) {
            *least = least.min(turns);
        }
    }
    best
}

/// Each turn as it goes on from those before it.
fn go_on(structure: &Structure, order: &[u32], principal: &[Vector]) -> Vec<Turn> {
    let alone = |vector: &Vector| Turn { vector: *vector, rest: Vector::zeros() };
    let mut turns: Vec<Turn> = principal.iter().map(alone).collect();
    // The sum of those before at each vertex, and how many they are.
    let mut before = vec![(Vector::zeros(), 0.0); structure.vertices()];
    for here in order {
        let corners = structure.tetrahedra()[*here as usize];
        let (mut mean, mut count) = (Vector::zeros(), 0.0);
        for corner in corners {
            let (sum, of_corner) = &before[corner as usize];
            if *of_corner > 0.0 {
                mean += sum / *of_corner;
                count += 1.0;
            }
        }
        let turn = &mut turns[*here as usize];
        if count > 0.0 {
            *turn = from_neighbour(turn.vector, mean / count);
        }
        for corner in corners {
            let (sum, of_corner) = &mut before[corner as usize];
            *sum += turn.vector;
            *of_corner += 1.0;
        }
    }
    turns
}

/// A rotation's turn where its neighbours are turned by a vector.
fn from_neighbour(principal: Vector, neighbour: Vector) -> Turn {
    let long = neighbour.norm();
    if long <= PI {
        let vector = nearest_branch(principal, neighbour);
        return Turn { vector, rest: Vector::zeros() };
    }
    let rotation = UnitQuaternion::new(principal);
    let after = |vector: Vector| (UnitQuaternion::new(-vector) * rotation).scaled_axis();
    let axis = neighbour / long;
    let vector = neighbour + axis * after(neighbour).dot(&axis);
    Turn { vector, rest: after(vector) }
}

/// Of all vectors of one rotation the nearest to that of a neighbour.
fn nearest_branch(principal: Vector, neighbour: Vector) -> Vector {
    let angle = principal.norm();
    if angle < NO_AXIS {
        return principal;
    }
    let axis = principal / angle;
    let turns = ((neighbour.dot(&axis) - angle) / TAU).round();
    if turns == 0.0 { principal } else { axis * (angle + turns * TAU) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_go_on_where_the_neighbour_is() {
        for degrees in -1200..=1200 {
            let whole = f64::from(degrees).to_radians();
            // As read off a tetrahedron that is also turned a little about another axis.
            let wobble = Vector::new(0.05, 0.0, -0.03);
            let rotation = UnitQuaternion::new(Vector::y() * whole) * UnitQuaternion::new(wobble);
            for neighbour in [whole - 0.3, whole + 0.2] {
                let neighbour = Vector::new(0.02, neighbour, 0.04);
                let turn = from_neighbour(rotation.scaled_axis(), neighbour);
                assert!((turn.vector.y - whole).abs() < 0.15, "{degrees}: {turn:?}");
                assert!(turn.rest.norm() < 0.2, "{degrees}: {turn:?}");
                let again = UnitQuaternion::new(turn.vector) * UnitQuaternion::new(turn.rest);
                assert!(again.angle_to(&rotation) < 1e-7, "{degrees}");
            }
        }
    }
}
