//! Conditions of the protocol `displaced`: interactions that nobody took part in.

use crate::demonstration::Observation;
use crate::geometry::{Vector, direction_or, yaw_isometry};

/// Where the partner is moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// Up: +z.
    Up,
    /// To the left of the robot that looks at the partner.
    Left,
    /// To its right.
    Right,
    /// From the partner's base towards the robot's, level.
    Nearer,
}

impl Direction {
    /// The name in tables and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Up => "up",
            Self::Left => "left",
            Self::Right => "right",
            Self::Nearer => "nearer",
        }
    }

    /// The unit vector in the world, by where the two bases are at a frame. Where one is above the
    /// other, the partner comes nearer the way it faces.
    pub fn in_world(self, observation: &Observation, frame: usize) -> Vector {
        let mut apart = observation.base[frame] - observation.partner_place(frame);
        apart.z = 0.0;
        let heading = yaw_isometry(observation.partner.heading(frame), Vector::zeros());
        let nearer = direction_or(apart, heading * Vector::x());
        match self {
            Self::Up => Vector::z(),
            // The robot looks against `nearer`: its left is a quarter turn from there.
            Self::Left => nearer.cross(&Vector::z()),
            Self::Right => Vector::z().cross(&nearer),
            Self::Nearer => nearer,
        }
    }
}

/// What is not as it was recorded: one thing at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Condition {
    /// The partner is elsewhere, by so much `[m]`, from the first frame to the last.
    Displaced(Direction, f64),
    /// The robot is so many times as large `[-]`, > 0.
    Scaled(f64),
}

impl Condition {
    /// All of the protocol, in the order tables show them.
    pub const ALL: [Self; 10] = [
        Self::Displaced(Direction::Up, 0.1),
        Self::Displaced(Direction::Up, 0.2),
        Self::Displaced(Direction::Left, 0.1),
        Self::Displaced(Direction::Left, 0.2),
        Self::Displaced(Direction::Right, 0.1),
        Self::Displaced(Direction::Right, 0.2),
        Self::Displaced(Direction::Nearer, 0.1),
        Self::Displaced(Direction::Nearer, 0.2),
        Self::Scaled(0.8),
        Self::Scaled(1.2),
    ];

    /// The name in tables and JSON: `up_0.1`, `scale_0.8`.
    pub fn name(self) -> String {
        match self {
            Self::Displaced(direction, distance) => format!("{}_{distance:.1}", direction.name()),
            Self::Scaled(scale) => format!("scale_{scale:.1}"),
        }
    }

    /// How many times as large as recorded the robot is `[-]`.
    pub fn scale(self) -> f64 {
        match self {
            Self::Displaced(..) => 1.0,
            Self::Scaled(scale) => scale,
        }
    }

    /// By what the partner is moved `[m]`, in the world.
    ///
    /// - `frame`: that of the true contact, at which directions are taken.
    pub fn displacement(self, recorded: &Observation, frame: usize) -> Vector {
        match self {
            Self::Displaced(direction, by) => direction.in_world(recorded, frame) * by,
            Self::Scaled(_) => Vector::zeros(),
        }
    }

    /// An observation under this condition.
    ///
    /// - `displacement`: of [`Self::displacement`], `[m]`.
    pub(super) fn apply(self, recorded: Observation, displacement: Vector) -> Observation {
        match self {
            Self::Displaced(..) => recorded.with_partner_moved(displacement),
            Self::Scaled(scale) => recorded.with_robot_scaled(scale),
        }
    }
}
