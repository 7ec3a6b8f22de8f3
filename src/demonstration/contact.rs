//! Where two hands met: which ones, when, and the gap between them.

use crate::geometry::{Vector, yaw_isometry};
use crate::skeleton::{Part, Recording, Role, Side};

/// One hand of the robot's role and one of its partner's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Hands {
    /// The robot role's hand.
    pub robot: Side,
    /// The partner's hand.
    pub partner: Side,
}

impl Hands {
    /// All four pairs; the order breaks ties.
    pub fn all() -> impl Iterator<Item = Self> {
        let sides = Side::BOTH.into_iter();
        sides.flat_map(|robot| Side::BOTH.map(|partner| Self { robot, partner }))
    }

    /// The place in [`Self::all`], below 4.
    pub fn index(self) -> usize {
        2 * self.robot as usize + self.partner as usize
    }
}

/// The moment a pair of hands is closest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Which hands.
    pub hands: Hands,
    /// The frame, counted from 0; the first of equals.
    pub frame: usize,
    /// How close they come `[m]`.
    pub distance: f64,
    /// Robot's hand minus partner's `[m]`, in the partner's heading frame at that moment
    /// (x where the partner faces, z up).
    pub gap: Vector,
}

impl Contact {
    /// When these hands are closest; `None` if a skeleton lacks one.
    pub fn of(recording: &Recording, robot: Role, hands: Hands) -> Option<Self> {
        let partner = &recording.person(robot.partner()).motion;
        let robot = &recording.person(robot).motion;
        let robot_hand = robot.skeleton().part(Part::Hand(hands.robot))?;
        let partner_hand = partner.skeleton().part(Part::Hand(hands.partner))?;
        let gap = |k: usize| robot.position(k, robot_hand) - partner.position(k, partner_hand);
        let frame =
            (0..recording.len()).min_by(|a, b| gap(*a).norm().total_cmp(&gap(*b).norm()))?;
        let heading_from_world = yaw_isometry(-partner.heading(frame), Vector::zeros());
        let distance = gap(frame).norm();
        Some(Self { hands, frame, distance, gap: heading_from_world * gap(frame) })
    }

    /// When the closest of all hands are closest.
    pub fn closest(recording: &Recording, robot: Role) -> Option<Self> {
        let contacts = Hands::all().filter_map(|hands| Self::of(recording, robot, hands));
        contacts.min_by(|a, b| a.distance.total_cmp(&b.distance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hands_know_their_place() {
        assert!(Hands::all().map(Hands::index).eq(0..4));
    }
}
