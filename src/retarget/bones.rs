//! Exact bones: joints moved along their bones' directions until every length is right.

use crate::geometry::{Point, Vector, direction_or};
use crate::skeleton::Skeleton;

/// Gives every bone its exact length, root outwards: a child goes along the solved direction from
/// its parent's new place.
///
/// - `positions`: `[m]`, one person's joints in one frame, changed in place; the root stays.
/// - `lengths`: `[m]`, in the skeleton's bone order.
///
/// A bone of no length points down.
///
/// # Panics
/// If `positions` or `lengths` do not fit the skeleton: the caller's bug.
pub fn project_bones(skeleton: &Skeleton, lengths: &[f64], positions: &mut [Point]) {
    assert_eq!(positions.len(), skeleton.len(), "one position per joint");
    assert_eq!(lengths.len(), skeleton.bones().len(), "one length per bone");
    // Directions are those of the solution, so a child's shift never turns its own children.
    let mut shifts = [Vector::zeros(); Skeleton::MAX_JOINTS];
    for (bone, length) in skeleton.bones().zip(lengths) {
        let (parent, child) = (bone.parent.index(), bone.child.index());
        let solved_parent = positions[parent] - shifts[parent];
        let along = direction_or(positions[child] - solved_parent, -Vector::z());
        let place = positions[parent] + along * *length;
        shifts[child] = place - positions[child];
        positions[child] = place;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_become_exact_and_directions_stay() {
        let skeleton = Skeleton::nite();
        let solved: Vec<Point> = (0..15)
            .map(f64::from)
            .map(|i| Point::new(i.sin(), (2.0 * i).cos(), (0.7 * i).sin()))
            .collect();
        let lengths: Vec<f64> = (0..14).map(|i| 0.2 + 0.01 * f64::from(i)).collect();
        let mut exact = solved.clone();
        project_bones(&skeleton, &lengths, &mut exact);
        assert_eq!(exact[skeleton.root().index()], solved[skeleton.root().index()]);
        for (bone, length) in skeleton.bones().zip(&lengths) {
            let along = |p: &[Point]| p[bone.child.index()] - p[bone.parent.index()];
            assert!((along(&exact).norm() - length).abs() < 1e-12);
            assert!((along(&exact).normalize() - along(&solved).normalize()).norm() < 1e-12);
        }
        let once = exact.clone();
        project_bones(&skeleton, &lengths, &mut exact);
        assert!(once.iter().zip(&exact).all(|(a, b)| (a - b).norm() < 1e-12), "idempotent");
    }
}
