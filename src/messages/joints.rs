//! Joints: where they are, and where they are to be.

use serde::{Deserialize, Serialize};

use super::{Duration, Header, Message, Transform, Vector3};

/// `geometry_msgs/msg/Twist`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// `[m/s]`.
    pub linear: Vector3,
    /// `[rad/s]`.
    pub angular: Vector3,
}

/// `geometry_msgs/msg/Wrench`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Wrench {
    /// `[N]`.
    pub force: Vector3,
    /// `[N m]`.
    pub torque: Vector3,
}

/// `sensor_msgs/msg/MultiDOFJointState`: a skeleton.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MultiDofJointState {
    /// When, in which frame.
    pub header: Header,
    /// Names.
    pub joint_names: Vec<String>,
    /// Places, one per name.
    pub transforms: Vec<Transform>,
    /// One per name, or none.
    pub twist: Vec<Twist>,
    /// One per name, or none.
    pub wrench: Vec<Wrench>,
}

impl Message for MultiDofJointState {
    const TYPE: &'static str = "sensor_msgs/msg/MultiDOFJointState";
}

/// `sensor_msgs/msg/JointState`: where an arm is.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    /// When.
    pub header: Header,
    /// Names.
    pub name: Vec<String>,
    /// `[rad]` or `[m]`, one per name, or none.
    pub position: Vec<f64>,
    /// `[rad/s]` or `[m/s]`, one per name, or none.
    pub velocity: Vec<f64>,
    /// `[N m]` or `[N]`, one per name, or none.
    pub effort: Vec<f64>,
}

impl Message for JointState {
    const TYPE: &'static str = "sensor_msgs/msg/JointState";
}

/// `trajectory_msgs/msg/MultiDOFJointTrajectoryPoint`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MultiDofPoint {
    /// One per joint.
    pub transforms: Vec<Transform>,
    /// One per joint, or none.
    pub velocities: Vec<Twist>,
    /// One per joint, or none.
    pub accelerations: Vec<Twist>,
    /// After the header's stamp.
    pub time_from_start: Duration,
}

/// `trajectory_msgs/msg/MultiDOFJointTrajectory`: where joints are to be.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MultiDofTrajectory {
    /// When it starts, in which frame.
    pub header: Header,
    /// Names.
    pub joint_names: Vec<String>,
    /// One after another in time.
    pub points: Vec<MultiDofPoint>,
}

impl Message for MultiDofTrajectory {
    const TYPE: &'static str = "trajectory_msgs/msg/MultiDOFJointTrajectory";
}
