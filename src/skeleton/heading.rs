//! Which way a person faces.

use super::{Part, Sequence, Side, Skeleton};
use crate::geometry::Point;

impl Skeleton {
    /// The direction a person faces `[rad]`, counter-clockwise from +x seen from above: the
    /// horizontal normal of the hip line, or of the shoulder line where there are no hips.
    ///
    /// - `positions`: `[m]`, one frame in skeleton order.
    ///
    /// 0 where the skeleton has neither, or the line stands upright.
    pub fn heading(&self, positions: &[Point]) -> f64 {
        for part in [Part::Hip, Part::Shoulder] {
            let [Some(left), Some(right)] = Side::BOTH.map(|side| self.part(part(side))) else {
                continue;
            };
            let across = positions[right.index()] - positions[left.index()];
            if across.xy().norm() > 1e-9 {
                // Up × (towards the right): forwards.
                return across.x.atan2(-across.y);
            }
        }
        0.0
    }
}

impl Sequence {
    /// The direction the person faces at a frame `[rad]`: see [`Skeleton::heading`].
    pub fn heading(&self, frame: usize) -> f64 {
        self.skeleton().heading(&self.frames()[frame].positions)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_person_whose_right_is_at_minus_y_faces_x() {
        let skeleton = Skeleton::nite();
        let mut positions = vec![Point::origin(); 15];
        for (side, sign) in [(Side::Left, 1.0), (Side::Right, -1.0)] {
            let hip = skeleton.part(Part::Hip(side)).unwrap();
            positions[hip.index()] = Point::new(0.5, 0.1 * sign, 0.9);
        }
        assert!(skeleton.heading(&positions).abs() < 1e-12);
        let turn = crate::geometry::yaw_isometry(1.2, crate::Vector::zeros());
        let turned: Vec<Point> = positions.iter().map(|p| turn * p).collect();
        assert!((skeleton.heading(&turned) - 1.2).abs() < 1e-12);
        assert_eq!(skeleton.heading(&vec![Point::origin(); 15]), 0.0);
    }
}
