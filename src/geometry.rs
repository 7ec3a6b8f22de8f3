//! Points, rigid motions and the rotation that fits two sets of directions best.
//!
//! Metres, right-handed, z up. A transform `a_from_b` takes a point `p_in_b` to `p_in_a`.
//! The one formula: `argmax_R tr(Rᵀ C)` over rotations (Kabsch 1976), of which the horizontal
//! (yaw-only) form has the closed solution `atan2`.
//!
//! Knows nothing of people, joints or time.

use std::f64::consts::PI;

use nalgebra::{
    Isometry3, Matrix3, Point3, Quaternion, Rotation3, Translation3, Unit, UnitQuaternion, Vector3,
};

/// A place `[m]`.
pub type Point = Point3<f64>;
/// A displacement `[m]`, or a direction.
pub type Vector = Vector3<f64>;
/// A rigid motion, named `a_from_b`.
pub type Isometry = Isometry3<f64>;

/// Whether every coordinate is finite.
pub fn is_finite(point: &Point) -> bool {
    point.coords.iter().all(|c| c.is_finite())
}

/// `vector` at unit length, or `fallback` where it is shorter than 1e-12 m and has no direction.
pub fn direction_or(vector: Vector, fallback: Vector) -> Vector {
    let length = vector.norm();
    if length > 1e-12 { vector / length } else { fallback }
}

/// The smallest rotation that turns one direction into another; none where one of them has no
/// length. Opposite directions have no smallest one: a half turn about an axis across them.
pub fn smallest_rotation(from: Vector, to: Vector) -> UnitQuaternion<f64> {
    let (Some(from), Some(to)) = (from.try_normalize(1e-12), to.try_normalize(1e-12)) else {
        return UnitQuaternion::identity();
    };
    let half = Quaternion::from_parts(1.0 + from.dot(&to), from.cross(&to));
    UnitQuaternion::try_new(half, 1e-9).unwrap_or_else(|| {
        let across = from.cross(&Vector::ith(from.iamin(), 1.0));
        UnitQuaternion::from_axis_angle(&Unit::new_normalize(across), PI)
    })
}

/// The outermost of some points (of a mesh' vertices, say): those that are farthest in one of many
/// evenly spread directions, and of these the ones that lie farthest apart.
///
/// - `most`: how many, at most.
///
/// Returns their places among `points`, rising; equal points count once, those that are not finite
/// never.
///
/// ```
/// use handover_mesh::Point;
/// use handover_mesh::geometry::outermost;
/// let line: Vec<Point> = (0..9).map(|k| Point::new(f64::from(k), 0.0, 0.0)).collect();
/// assert_eq!(outermost(&line, 4), [0, 8]);
/// ```
pub fn outermost(points: &[Point], most: usize) -> Vec<usize> {
    /// Neighbouring directions are 4 degrees apart.
    const DIRECTIONS: u32 = 2000;
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let places: Vec<usize> = (0..points.len()).filter(|at| is_finite(&points[*at])).collect();
    let extreme = (0..DIRECTIONS).filter_map(|k| {
        // Fibonacci's lattice: equal steps of height, the golden angle around.
        let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(DIRECTIONS);
        let (sine, cosine) = (golden * f64::from(k)).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        let direction = Vector::new(radius * cosine, radius * sine, z);
        let height = |at: &usize| points[*at].coords.dot(&direction);
        // The first of equals.
        places.iter().copied().reduce(|a, b| if height(&b) > height(&a) { b } else { a })
    });
    let mut extreme: Vec<usize> = extreme.collect();
    extreme.sort_unstable();
    extreme.dedup();
    let middle = means(extreme.iter().map(|at| (&points[*at], &points[*at]))).0;
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < most.min(extreme.len()) {
        let apart = |at: &usize| {
            let distances = chosen.iter().map(|one| (points[*at] - points[*one]).norm());
            let nearest = distances.fold(f64::INFINITY, f64::min);
            if chosen.is_empty() { (points[*at].coords - middle).norm() } else { nearest }
        };
        let farthest = extreme.iter().copied().filter(|at| apart(at) > 0.0);
        let Some(next) = farthest.reduce(|a, b| if apart(&b) > apart(&a) { b } else { a }) else {
            break;
        };
        chosen.push(next);
    }
    // All of them may lie on their middle.
    if chosen.is_empty() {
        chosen.extend(extreme.first().filter(|_| most > 0));
    }
    chosen.sort_unstable();
    chosen
}

/// A turn about the vertical through the origin, then a shift: `a_from_b`.
///
/// - `yaw`: `[rad]`, counter-clockwise seen from above.
/// - `shift`: `[m]`, in `a`.
pub fn yaw_isometry(yaw: f64, shift: Vector) -> Isometry {
    Isometry::from_parts(
        Translation3::from(shift),
        UnitQuaternion::from_axis_angle(&Vector::z_axis(), yaw),
    )
}

/// The rotation closest to `covariance`: `argmax_R tr(Rᵀ C)`, determinant +1 (Kabsch 1976).
///
/// Where `covariance` has rank 0 or 1 the maximiser is not unique and one of them is returned.
pub fn closest_rotation(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = covariance.svd(true, true);
    let (Some(mut u), Some(v_t)) = (svd.u, svd.v_t) else {
        return Matrix3::identity();
    };
    if (u * v_t).determinant() < 0.0 {
        // nalgebra sorts singular values downwards: the last column is the cheapest to flip.
        u.column_mut(2).neg_mut();
    }
    u * v_t
}

/// The rigid motion `b_from_a` that takes `points_in_a` closest to `points_in_b` (least squares).
///
/// Pairs by position in the iterators; the identity where there are no pairs.
pub fn rigid_alignment<'a>(
    pairs: impl Iterator<Item = (&'a Point, &'a Point)> + Clone,
) -> Isometry {
    let (mean_a, mean_b, count) = means(pairs.clone());
    if count == 0 {
        return Isometry::identity();
    }
    let mut covariance = Matrix3::zeros();
    for (a, b) in pairs {
        covariance += (b.coords - mean_b) * (a.coords - mean_a).transpose();
    }
    let rotation = closest_rotation(&covariance);
    let rotation =
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    Isometry::from_parts(Translation3::from(mean_b - rotation * mean_a), rotation)
}

/// As [`rigid_alignment`], turning about the vertical only: people stand on a floor.
pub fn yaw_alignment<'a>(pairs: impl Iterator<Item = (&'a Point, &'a Point)> + Clone) -> Isometry {
    let (mean_a, mean_b, _) = means(pairs.clone());
    let (mut cosine, mut sine) = (0.0, 0.0);
    for (a, b) in pairs {
        let (a, b) = (a.coords - mean_a, b.coords - mean_b);
        cosine += a.x * b.x + a.y * b.y;
        sine += a.x * b.y - a.y * b.x;
    }
    let turn = yaw_isometry(sine.atan2(cosine), Vector::zeros());
    Isometry::from_parts(Translation3::from(mean_b - turn * mean_a), turn.rotation)
}

fn means<'a>(pairs: impl Iterator<Item = (&'a Point, &'a Point)>) -> (Vector, Vector, usize) {
    let (mut sum_a, mut sum_b, mut count) = (Vector::zeros(), Vector::zeros(), 0);
    for (a, b) in pairs {
        sum_a += a.coords;
        sum_b += b.coords;
        count += 1;
    }
    let scale = 1.0 / f64::from(count.max(1));
    (sum_a * scale, sum_b * scale, count as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud() -> Vec<Point> {
        (0..9).map(f64::from).map(|i| Point::new(i.sin(), (2.0 * i).cos(), 0.3 * i)).collect()
    }

    #[test]
    fn alignments_recover_the_motion_that_was_applied() {
        let a = cloud();
        let turn = Isometry::new(Vector::new(0.3, -2.0, 1.0), Vector::new(0.4, -0.2, 2.5));
        let b: Vec<Point> = a.iter().map(|p| turn * p).collect();
        let found = rigid_alignment(a.iter().zip(&b));
        assert!((found.to_homogeneous() - turn.to_homogeneous()).amax() < 1e-12);

        let yaw = yaw_isometry(2.9, Vector::new(1.0, 2.0, 3.0));
        let b: Vec<Point> = a.iter().map(|p| yaw * p).collect();
        let found = yaw_alignment(a.iter().zip(&b));
        assert!((found.to_homogeneous() - yaw.to_homogeneous()).amax() < 1e-12);
    }

    #[test]
    fn the_smallest_rotation_turns_one_into_the_other_and_no_more() {
        let (a, b) = (Vector::new(0.3, -2.0, 1.0), Vector::new(-1.0, 0.2, 0.4));
        for (from, to) in [(a, b), (a, 3.0 * a), (a, -a), (Vector::z(), -Vector::z())] {
            let turn = smallest_rotation(from, to);
            assert!((turn * from.normalize() - to.normalize()).norm() < 1e-12, "{from} {to}");
            assert!((turn.angle() - from.angle(&to)).abs() < 1e-7, "{from} {to}");
        }
        assert_eq!(smallest_rotation(Vector::zeros(), a), UnitQuaternion::identity());
        assert_eq!(smallest_rotation(a, Vector::zeros()), UnitQuaternion::identity());
    }

    #[test]
    fn the_outermost_points_of_a_cube_are_its_corners() {
        // A cube of 5 × 5 × 5 points, standing on no axis; two of them twice, one nowhere.
        let turn = Isometry::new(Vector::new(0.1, 0.2, 0.3), Vector::new(0.4, -0.2, 0.5));
        let place = |k: usize| [k / 25, k / 5 % 5, k % 5].map(|i| 0.02 * i as f64);
        let mut points: Vec<Point> = (0..125).map(|k| turn * Point::from(place(k))).collect();
        points.extend([points[124], points[62], Point::new(f64::NAN, 0.0, 0.0)]);
        let corners = [0, 4, 20, 24, 100, 104, 120, 124];
        for most in [8, 16, 64] {
            assert_eq!(outermost(&points, most), corners);
        }
        // Of fewer, those that are far apart: a corner and the one across.
        let [a, b] = outermost(&points, 2)[..] else { panic!("two") };
        assert_eq!(a + b, 124);
        assert!(outermost(&points, 0).is_empty());
        assert_eq!(outermost(&points[..1], 5), [0]);
        assert_eq!(outermost(&[points[3]; 3], 5), [0]);
        assert!(outermost(&[], 5).is_empty());
    }

    #[test]
    fn a_mirror_image_still_gives_a_rotation() {
        let covariance = Matrix3::new(-2.0, 0.1, 0.0, 0.2, 1.0, 0.0, 0.0, 0.3, 0.5);
        let rotation = closest_rotation(&covariance);
        assert!((rotation.determinant() - 1.0).abs() < 1e-12);
        assert!((rotation.transpose() * rotation - Matrix3::identity()).amax() < 1e-12);
    }

    #[test]
    fn no_pairs_leave_everything_where_it_is() {
        let none: [(&Point, &Point); 0] = [];
        assert_eq!(rigid_alignment(none.into_iter()), Isometry::identity());
        assert_eq!(yaw_alignment(none.into_iter()), Isometry::identity());
    }
}
