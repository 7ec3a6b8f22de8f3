//! Messages of body trackers ⇄ whose joints are where.
//!
//! Four ways to say it are known: a skeleton by joint names ([`from_joint_state`]), one frame of
//! the transform tree for each joint ([`TransformAssembler`]), one marker for each joint
//! ([`from_markers`]), and where a robot is to be ([`from_trajectory`]). Whatever it was, a [`Body`]
//! comes out: the joints that are tracked, by name, in metres, to the bit as they were sent.
//!
//! Live nodes and bags are read by the same code. Orientations of joints say nothing here; whether
//! a frame is the world is for the caller to know.

mod assemble;
mod markers;
mod names;

pub use assemble::TransformAssembler;
pub use markers::{from_markers, to_markers};
pub use names::{FrameName, joint_of_frame, joint_of_marker};

use crate::frames::bare;
use crate::geometry::{Point, is_finite};
use crate::messages::{
    Header, MultiDofJointState, MultiDofTrajectory, Time, Transform, TransformStamped,
    TransformTree,
};
use crate::time::Stamp;

/// Somebody's joints at one instant, as a tracker says.
///
/// ```
/// use handover_mesh::bodies::{Body, from_joint_state, to_joint_state};
/// use handover_mesh::{Point, Stamp};
/// let body = Body {
///     stamp: Stamp(1_500_000_000),
///     frame: "world".to_owned(),
///     id: None,
///     joints: vec![("head".to_owned(), Point::new(0.1, 0.2, 1.7))],
/// };
/// assert_eq!(from_joint_state(&to_joint_state(&body))?, body);
/// # Ok::<(), handover_mesh::bodies::BodyError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// When.
    pub stamp: Stamp,
    /// The frame that places are in, without a leading `/`.
    pub frame: String,
    /// The tracker's number of whoever it is, where it numbers people.
    pub id: Option<u32>,
    /// Where `[m]` in the frame, finite, each name once; a joint that is not tracked is absent.
    pub joints: Vec<(String, Point)>,
}

/// Why a message shows no body.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BodyError {
    /// Names and places do not belong together.
    #[error("{names} joint names, but {places} places")]
    Counts {
        /// How many names there are.
        names: usize,
        /// How many places there are.
        places: usize,
    },
    /// Nobody knows which of the two it is.
    #[error("joint '{name}' appears twice")]
    Repeated {
        /// The name.
        name: String,
    },
    /// A trajectory without a point.
    #[error("a trajectory without a point")]
    NoPoint,
}

impl Body {
    /// Where the joint of this name is `[m]`.
    pub fn place(&self, joint: &str) -> Option<Point> {
        self.joints.iter().find(|(name, _)| name == joint).map(|(_, place)| *place)
    }
}

/// A skeleton by joint names; joints at NaN are not tracked.
///
/// # Errors
/// [`BodyError`].
pub fn from_joint_state(message: &MultiDofJointState) -> Result<Body, BodyError> {
    named(&message.header, &message.joint_names, &message.transforms)
}

/// Where a robot is to be at once: the first point, at the header's stamp.
///
/// # Errors
/// [`BodyError`].
pub fn from_trajectory(message: &MultiDofTrajectory) -> Result<Body, BodyError> {
    let now = message.points.first().ok_or(BodyError::NoPoint)?;
    named(&message.header, &message.joint_names, &now.transforms)
}

fn named(header: &Header, names: &[String], places: &[Transform]) -> Result<Body, BodyError> {
    if names.len() != places.len() {
        return Err(BodyError::Counts { names: names.len(), places: places.len() });
    }
    let mut sorted: Vec<&String> = names.iter().collect();
    sorted.sort_unstable();
    if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(BodyError::Repeated { name: pair[0].clone() });
    }
    let places = places.iter().map(|transform| Point::from(transform.translation));
    let joints = names.iter().cloned().zip(places).filter(|(_, place)| is_finite(place)).collect();
    Ok(Body { stamp: header.stamp.stamp(), frame: frame(&header.frame_id), id: None, joints })
}

/// The name of a frame without the `/` that ROS 1 put before it.
fn frame(id: &str) -> String {
    bare(id).to_owned()
}

fn header(body: &Body) -> Header {
    Header { stamp: Time::of(body.stamp), frame_id: body.frame.clone() }
}

fn at(place: Point) -> Transform {
    Transform { translation: place.into(), ..Transform::default() }
}

/// The body as a skeleton message, nothing turned; [`from_joint_state`] reads it back to the bit
/// (without its number, for which such a message has no place).
pub fn to_joint_state(body: &Body) -> MultiDofJointState {
    let (joint_names, places): (Vec<String>, Vec<Point>) = body.joints.iter().cloned().unzip();
    let transforms = places.into_iter().map(at).collect();
    MultiDofJointState { header: header(body), joint_names, transforms, ..Default::default() }
}

/// The body as frames `{joint}_{id}` (number 0 where it has none), nothing turned.
pub fn to_transforms(body: &Body) -> TransformTree {
    let id = body.id.unwrap_or(0);
    let edge = |(name, place): &(String, Point)| TransformStamped {
        header: header(body),
        child_frame_id: format!("{name}_{id}"),
        transform: at(*place),
    };
    TransformTree { transforms: body.joints.iter().map(edge).collect() }
}
