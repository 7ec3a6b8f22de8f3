//! Time, places, frames, text.

use serde::{Deserialize, Serialize};

use super::Message;
use crate::geometry::{Point, Vector};
use crate::time::{Span, Stamp};

/// `builtin_interfaces/msg/Time`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Time {
    /// Whole seconds.
    pub sec: i32,
    /// Nanoseconds besides, below 10⁹.
    pub nanosec: u32,
}

impl Time {
    /// The stamp `[ns]`; whatever the fields hold.
    pub fn stamp(self) -> Stamp {
        Stamp(i64::from(self.sec) * 1_000_000_000 + i64::from(self.nanosec))
    }

    /// A stamp as a message has it; one beyond ±68 years is held at that bound.
    pub fn of(stamp: Stamp) -> Self {
        let (sec, nanosec) = parts(stamp.0);
        Self { sec, nanosec }
    }
}

/// `builtin_interfaces/msg/Duration`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Duration {
    /// Whole seconds, downwards.
    pub sec: i32,
    /// Nanoseconds besides, below 10⁹.
    pub nanosec: u32,
}

impl Duration {
    /// The time `[ns]`.
    pub fn span(self) -> Span {
        Span(i64::from(self.sec) * 1_000_000_000 + i64::from(self.nanosec))
    }

    /// A time as a message has it; one beyond ±68 years is held at that bound.
    pub fn of(span: Span) -> Self {
        let (sec, nanosec) = parts(span.0);
        Self { sec, nanosec }
    }
}

fn parts(nanoseconds: i64) -> (i32, u32) {
    let seconds = nanoseconds.div_euclid(1_000_000_000);
    // The rest is below 10⁹.
    let rest = nanoseconds.rem_euclid(1_000_000_000) as u32;
    match i32::try_from(seconds) {
        Ok(seconds) => (seconds, rest),
        Err(_) if seconds < 0 => (i32::MIN, 0),
        Err(_) => (i32::MAX, 999_999_999),
    }
}

/// `rosgraph_msgs/msg/Clock`: the time that simulated clocks show.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Clock {
    /// The time.
    pub clock: Time,
}

impl Message for Clock {
    const TYPE: &'static str = "rosgraph_msgs/msg/Clock";
}

/// `std_msgs/msg/Header`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// Of what the message shows.
    pub stamp: Time,
    /// The frame that places are in.
    pub frame_id: String,
}

/// `std_msgs/msg/String`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Text {
    /// The text.
    pub data: String,
}

impl Message for Text {
    const TYPE: &'static str = "std_msgs/msg/String";
}

/// `geometry_msgs/msg/Vector3`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    /// First coordinate.
    pub x: f64,
    /// Second coordinate.
    pub y: f64,
    /// Third coordinate.
    pub z: f64,
}

impl From<Vector3> for Vector {
    fn from(Vector3 { x, y, z }: Vector3) -> Self {
        Self::new(x, y, z)
    }
}

impl From<Vector> for Vector3 {
    fn from(vector: Vector) -> Self {
        Self { x: vector.x, y: vector.y, z: vector.z }
    }
}

impl From<Vector3> for Point {
    fn from(Vector3 { x, y, z }: Vector3) -> Self {
        Self::new(x, y, z)
    }
}

impl From<Point> for Vector3 {
    fn from(point: Point) -> Self {
        Self { x: point.x, y: point.y, z: point.z }
    }
}

/// `geometry_msgs/msg/Point`: on the wire a [`Vector3`].
pub type Point3 = Vector3;

/// `geometry_msgs/msg/Quaternion`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// First imaginary part.
    pub x: f64,
    /// Second imaginary part.
    pub y: f64,
    /// Third imaginary part.
    pub z: f64,
    /// Real part.
    pub w: f64,
}

impl Default for Quaternion {
    /// No rotation.
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

/// `geometry_msgs/msg/Pose`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Where `[m]`.
    pub position: Point3,
    /// Which way round.
    pub orientation: Quaternion,
}

/// `geometry_msgs/msg/PoseStamped`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseStamped {
    /// When, in which frame.
    pub header: Header,
    /// The pose.
    pub pose: Pose,
}

impl Message for PoseStamped {
    const TYPE: &'static str = "geometry_msgs/msg/PoseStamped";
}

/// `geometry_msgs/msg/Transform`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    /// Where the child is in its parent `[m]`.
    pub translation: Vector3,
    /// Which way round.
    pub rotation: Quaternion,
}

/// `geometry_msgs/msg/TransformStamped`: parent from child.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    /// When; the frame is the parent.
    pub header: Header,
    /// The child.
    pub child_frame_id: String,
    /// Parent from child.
    pub transform: Transform,
}

/// `tf2_msgs/msg/TFMessage`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TransformTree {
    /// Some edges of the tree of frames.
    pub transforms: Vec<TransformStamped>,
}

impl Message for TransformTree {
    const TYPE: &'static str = "tf2_msgs/msg/TFMessage";
}
