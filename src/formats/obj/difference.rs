//! In what the connections of two shapes differ.

use std::fmt;

use super::shape::{Corner, Obj};
use super::statements::Statements;

/// The first thing in which two shapes differ that should be one in two poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Difference {
    /// One has more vertices.
    Vertices {
        /// How many each has.
        counts: [usize; 2],
    },
    /// A face names other vertices, or names them in another order.
    Face {
        /// Which face, counted from 1.
        number: usize,
        /// The line of each file where it is.
        lines: [u64; 2],
    },
    /// One has more faces, and all that both have are the same.
    Faces {
        /// How many each has.
        counts: [usize; 2],
    },
}

impl fmt::Display for Difference {
    /// `8 vertices and 9`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Vertices { counts: [first, second] } => {
                write!(f, "{first} vertices and {second}")
            }
            Self::Faces { counts: [first, second] } => write!(f, "{first} faces and {second}"),
            Self::Face { number, lines: [first, second] } => {
                write!(f, "face {number} has other vertices (lines {first} and {second})")
            }
        }
    }
}

impl Obj {
    /// In what the two differ besides where their vertices are; `None` of two poses of one shape.
    ///
    /// Only what belongs to blending is compared: the number of vertices, and which of them the
    /// faces name.
    pub fn difference(&self, other: &Self) -> Option<Difference> {
        let both = [self, other];
        let counts = both.map(|obj| obj.positions.len());
        if counts[0] != counts[1] {
            return Some(Difference::Vertices { counts });
        }
        let unequal = |(one, other): (&[Corner], &[Corner])| {
            !one.iter().map(|corner| corner.vertex).eq(other.iter().map(|corner| corner.vertex))
        };
        if let Some(at) = self.faces().zip(other.faces()).position(unequal) {
            return Some(Difference::Face { number: at + 1, lines: both.map(|obj| obj.line(at)) });
        }
        let counts = both.map(Self::face_count);
        (counts[0] != counts[1]).then_some(Difference::Faces { counts })
    }

    /// The line of a face.
    fn line(&self, face: usize) -> u64 {
        let mut faces = Statements::of(&self.bytes).filter(|statement| statement.keyword == b"f");
        faces.nth(face).map_or(0, |statement| statement.line)
    }
}
