//! Markers with Azure Kinect's numbers ⇄ bodies.

use super::names::{joint_of_marker, marker_of_joint};
use super::{Body, frame, header};
use crate::geometry::{Point, is_finite};
use crate::messages::{Color, Marker, MarkerArray, Pose, Vector3};

/// A marker that is there, not one that goes.
const ADD: i32 = 0;
/// How large a joint is shown `[m]`.
const DIAMETER: f64 = 0.06;

/// Everybody in the markers, in the order in which they begin.
///
/// A body's stamp and frame are its first marker's; what is in another frame, deleted, not finite
/// or there already is left out, and so is every marker whose number is that of no known joint.
pub fn from_markers(message: &MarkerArray) -> Vec<Body> {
    let mut bodies: Vec<Body> = Vec::new();
    for marker in message.markers.iter().filter(|marker| marker.action == ADD) {
        let Some((id, joint)) = joint_of_marker(marker.id) else { continue };
        let place = Point::from(marker.pose.position);
        if !is_finite(&place) {
            continue;
        }
        let known = bodies.iter().position(|body| body.id == Some(id));
        let at = known.unwrap_or_else(|| {
            bodies.push(Body {
                stamp: marker.header.stamp.stamp(),
                frame: frame(&marker.header.frame_id),
                id: Some(id),
                joints: Vec::new(),
            });
            bodies.len() - 1
        });
        let body = &mut bodies[at];
        if body.frame == frame(&marker.header.frame_id) && body.place(joint).is_none() {
            body.joints.push((joint.to_owned(), place));
        }
    }
    bodies
}

/// The body as balls with Azure Kinect's numbers (body 0 where it has none); joints that Azure
/// Kinect does not have are left out.
pub fn to_markers(body: &Body) -> MarkerArray {
    let markers = body.joints.iter().filter_map(|(name, place)| {
        Some(Marker {
            header: header(body),
            ns: "body".to_owned(),
            id: marker_of_joint(body.id.unwrap_or(0), name)?,
            kind: Marker::SPHERE,
            pose: Pose { position: (*place).into(), ..Pose::default() },
            scale: Vector3 { x: DIAMETER, y: DIAMETER, z: DIAMETER },
            color: Color { r: 0.2, g: 0.6, b: 1.0, a: 1.0 },
            ..Marker::default()
        })
    });
    MarkerArray { markers: markers.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Stamp;

    fn body(id: u32, shift: f64) -> Body {
        let joints = ["head", "torso", "left_hand"].into_iter().enumerate();
        let joints = joints.map(|(k, name)| (name.to_owned(), Point::new(shift, 0.1, k as f64)));
        Body { stamp: Stamp(7), frame: "depth".into(), id: Some(id), joints: joints.collect() }
    }

    #[test]
    fn bodies_survive_their_markers() {
        let mut message = to_markers(&body(3, 0.25));
        message.markers.extend(to_markers(&body(1, -0.5)).markers);
        assert_eq!(from_markers(&message), [body(3, 0.25), body(1, -0.5)]);
        let torso = &mut message.markers[1];
        torso.pose.position.x = f64::NAN;
        message.markers[2].action = 2;
        message.markers[0].header.frame_id = "/depth".into();
        let found = from_markers(&message);
        assert_eq!((found[0].joints.len(), found[1].joints.len()), (1, 3));
        assert_eq!(found[0].frame, "depth");
    }
}
