//! What the tracker believes.

use nalgebra::UnitComplex;

use crate::demonstration::Hands;
use crate::geometry::Vector;

/// A demonstration that the interaction follows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Followed {
    /// Which, by its place in the library.
    pub exemplar: usize,
    /// How much it counts `[-]`; all together 1.
    pub weight: f64,
    /// Where in it the interaction is, in frames of the grid.
    pub frame: f64,
    /// How it is turned about the vertical to lie on the interaction.
    pub turn: UnitComplex<f64>,
}

impl Followed {
    /// A vector of the demonstration's `[m]`, as the interaction sees it.
    pub fn turned(&self, vector: Vector) -> Vector {
        let turned = self.turn * vector.xy();
        Vector::new(turned.x, turned.y, vector.z)
    }
}

/// Where an interaction is in the demonstrations.
#[derive(Debug, Clone, PartialEq)]
pub struct Belief {
    /// The demonstrations followed, those that count most first.
    pub followed: Vec<Followed>,
    /// The hands that will meet.
    pub hands: Hands,
    /// How fast time goes, as a multiple of the demonstrations' `[-]`, 0 to 2.
    pub tempo: f64,
    /// How far the partner is from the demonstrations `[m]`: mean distance of a joint.
    pub distance: f64,
    /// How far the way they face, as seen from the robot, is from that of the demonstrations `[rad]`,
    /// of late: 0 to π.
    pub turned: f64,
    /// Whether both are near enough to be one of the interactions demonstrated.
    pub is_familiar: bool,
    /// When the hands meet, in frames of the grid from now at the demonstrations' tempo; below 0
    /// once they have.
    pub contact: f64,
}
