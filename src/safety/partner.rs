//! The part of the partner that the robot keeps away from.

use crate::geometry::{Point, is_finite};

/// Head, neck and torso as last seen: `[m]` in the world; none: not known.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PartnerBody {
    /// The head.
    pub head: Option<Point>,
    /// The neck.
    pub neck: Option<Point>,
    /// The middle of the trunk.
    pub torso: Option<Point>,
}

/// More parts than the partner has.
pub(super) const PARTS: usize = 2;

/// Nobody stands farther out than this `[m]`, and no robot is sent there: nearer than what a sensor may
/// say at all (the filter's own bound), so that rounding of places stays far below limits.
const FARTHEST_STANDING: f64 = 1e4;

/// Whether a place is one to stand or go to: finite, and within 10 km of the origin in each direction.
pub(crate) fn is_place(point: &Point) -> bool {
    is_finite(point) && point.coords.amax() <= FARTHEST_STANDING
}

impl PartnerBody {
    /// Whether all that is given are places.
    pub(super) fn is_somewhere(&self) -> bool {
        [self.head, self.neck, self.torso].iter().flatten().all(is_place)
    }

    /// Segments between what is known, from head to torso; a lone point is a segment of no length.
    pub(super) fn parts(&self) -> [Option<[Point; 2]>; PARTS] {
        match (self.head, self.neck, self.torso) {
            (Some(head), Some(neck), Some(torso)) => [Some([head, neck]), Some([neck, torso])],
            (Some(a), Some(b), None) | (Some(a), None, Some(b)) | (None, Some(a), Some(b)) => {
                [Some([a, b]), None]
            }
            (Some(a), None, None) | (None, Some(a), None) | (None, None, Some(a)) => {
                [Some([a, a]), None]
            }
            (None, None, None) => [None, None],
        }
    }
}
