//! Which axis of a file points up → points with z up.
//!
//! `(x, y, z) → (x, −z, y)`: a quarter turn about x, so right-handed stays right-handed.

use crate::geometry::Point;

/// The axis of a file's right-handed frame that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum UpAxis {
    /// y up, as cameras and animation have it.
    Y,
    /// z up, as everything in this crate has it.
    #[default]
    Z,
}

impl UpAxis {
    /// The file's point `[m]` in the frame with z up.
    ///
    /// ```
    /// use handover_mesh::{Point, formats::UpAxis};
    /// assert_eq!(UpAxis::Y.to_z_up(Point::new(1.0, 2.0, 3.0)), Point::new(1.0, -3.0, 2.0));
    /// ```
    pub fn to_z_up(self, point: Point) -> Point {
        match self {
            Self::Y => Point::new(point.x, -point.z, point.y),
            Self::Z => point,
        }
    }
}
