//! How far apart two segments are, and which way.

use crate::geometry::{Point, Vector};

/// Closest points of the segments `a` and `b`, ends included: on `a`, on `b` (Ericson, Real-Time
/// Collision Detection, 2005, 5.1.9). A segment may be a point.
pub(super) fn closest_points(a: [Point; 2], b: [Point; 2]) -> [Point; 2] {
    let (along_a, along_b, between) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (aa, bb, ab) = (along_a.norm_squared(), along_b.norm_squared(), along_a.dot(&along_b));
    let (ar, br) = (along_a.dot(&between), along_b.dot(&between));
    // Squared lengths below this are points: (0.1 nm)².
    const POINT: f64 = 1e-20;
    let (s, t) = if aa <= POINT {
        (0.0, if bb <= POINT { 0.0 } else { (br / bb).clamp(0.0, 1.0) })
    } else if bb <= POINT {
        ((-ar / aa).clamp(0.0, 1.0), 0.0)
    } else {
        let spread = aa * bb - ab * ab;
        // Parallel: any place will do.
        let s = if spread > 1e-12 * aa * bb {
            ((ab * br - ar * bb) / spread).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let t = (ab * s + br) / bb;
        match t {
            t if t < 0.0 => ((-ar / aa).clamp(0.0, 1.0), 0.0),
            t if t > 1.0 => (((ab - ar) / aa).clamp(0.0, 1.0), 1.0),
            t => (s, t),
        }
    };
    [a[0] + along_a * s, b[0] + along_b * t]
}

/// How a bone stands to a part of the partner.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearness {
    /// `[m]`.
    pub(super) distance: f64,
    /// From the partner to the bone, length 1; none where they touch.
    pub(super) away: Option<Vector>,
    /// The part's largest `away · q` `[m]`: what is past it is as far from the part as it is past.
    pub(super) wall: f64,
}

impl Nearness {
    pub(super) fn of(bone: [Point; 2], part: [Point; 2]) -> Self {
        let [on_bone, on_part] = closest_points(bone, part);
        let between: Vector = on_bone - on_part;
        let distance = between.norm();
        if distance < 1e-6 {
            return Self { distance, away: None, wall: 0.0 };
        }
        let away = between / distance;
        let wall = part.iter().map(|q| away.dot(&q.coords)).fold(f64::NEG_INFINITY, f64::max);
        Self { distance, away: Some(away), wall }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Point> {
        // A coarse grid among them: parallel, crossing and touching segments.
        let coordinate = || prop_oneof![-1.0f64..1.0, (-2i8..3).prop_map(f64::from)];
        [coordinate(), coordinate(), coordinate()].prop_map(|[x, y, z]| Point::new(x, y, z))
    }

    proptest! {
        #[test]
        fn no_two_points_are_closer(a in [point(), point()], b in [point(), point()]) {
            let [on_a, on_b] = closest_points(a, b);
            let distance = (on_a - on_b).norm();
            for i in 0..=20 {
                for j in 0..=20 {
                    let p = a[0] + (a[1] - a[0]) * (f64::from(i) / 20.0);
                    let q = b[0] + (b[1] - b[0]) * (f64::from(j) / 20.0);
                    prop_assert!(distance <= (p - q).norm() + 1e-9);
                }
            }
            // And they are on the segments: the distance to the ends adds up.
            for (on, ends) in [(on_a, a), (on_b, b)] {
                let sum = (on - ends[0]).norm() + (on - ends[1]).norm();
                prop_assert!((sum - (ends[1] - ends[0]).norm()).abs() < 1e-9);
            }
            let near = Nearness::of(a, b);
            if let Some(away) = near.away {
                // The wall stands between them.
                let least = a.iter().map(|p| away.dot(&p.coords)).fold(f64::INFINITY, f64::min);
                prop_assert!((least - near.wall - distance).abs() < 1e-6);
            }
        }
    }
}
