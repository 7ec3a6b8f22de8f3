//! What is sent, and on which topic.

use handover_mesh::messages::{
    Clock, MarkerArray, Message, MultiDofJointState, PoseStamped, TransformTree, encode,
};

/// One message, due.
#[derive(Debug, Clone, PartialEq)]
pub enum Outgoing {
    /// The simulated time.
    Clock(Clock),
    /// The partner's joints, as the sensor sees them.
    Skeleton(MultiDofJointState),
    /// The same as frames `{joint}_{body}`.
    Transforms(TransformTree),
    /// The same as markers with Azure Kinect's numbers.
    Markers(MarkerArray),
    /// The robot's joints.
    RobotSkeleton(MultiDofJointState),
    /// The object.
    ObjectPose(PoseStamped),
    /// Whether all has been played and nothing more comes.
    Finished(bool),
}

/// Where messages go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Topic {
    /// `/clock`
    Clock,
    /// `skeleton`
    Skeleton,
    /// `/tf`
    Transforms,
    /// `skeleton_markers`
    Markers,
    /// `robot_skeleton`
    RobotSkeleton,
    /// `object_pose`
    ObjectPose,
    /// `~/finished`
    Finished,
}

/// How sure it is that messages arrive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reliability {
    /// As of a sensor: best effort, the last five.
    Sensor,
    /// Reliable, the last so many.
    Reliable(usize),
    /// Reliable, and whoever comes later hears the last one.
    Kept,
}

impl Topic {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Skeleton,
        Self::Transforms,
        Self::Markers,
        Self::RobotSkeleton,
        Self::ObjectPose,
        Self::Clock,
        Self::Finished,
    ];

    /// Those that say where the partner is.
    pub const PARTNER: [Self; 3] = [Self::Skeleton, Self::Transforms, Self::Markers];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clock => "/clock",
            Self::Skeleton => "skeleton",
            Self::Transforms => "/tf",
            Self::Markers => "skeleton_markers",
            Self::RobotSkeleton => "robot_skeleton",
            Self::ObjectPose => "object_pose",
            Self::Finished => "~/finished",
        }
    }

    /// The type of its messages.
    pub fn type_name(self) -> &'static str {
        match self {
            Self::Clock => Clock::TYPE,
            Self::Skeleton | Self::RobotSkeleton => MultiDofJointState::TYPE,
            Self::Transforms => TransformTree::TYPE,
            Self::Markers => MarkerArray::TYPE,
            Self::ObjectPose => PoseStamped::TYPE,
            Self::Finished => "std_msgs/msg/Bool",
        }
    }

    /// How sure it is that its messages arrive.
    pub fn reliability(self) -> Reliability {
        match self {
            Self::Skeleton | Self::RobotSkeleton | Self::ObjectPose => Reliability::Sensor,
            Self::Transforms => Reliability::Reliable(100),
            // Viewers ask for reliable ones, and no clock should miss the end of a leap.
            Self::Markers | Self::Clock => Reliability::Reliable(1),
            Self::Finished => Reliability::Kept,
        }
    }
}

impl Outgoing {
    /// Where it goes.
    pub fn topic(&self) -> Topic {
        match self {
            Self::Clock(_) => Topic::Clock,
            Self::Skeleton(_) => Topic::Skeleton,
            Self::Transforms(_) => Topic::Transforms,
            Self::Markers(_) => Topic::Markers,
            Self::RobotSkeleton(_) => Topic::RobotSkeleton,
            Self::ObjectPose(_) => Topic::ObjectPose,
            Self::Finished(_) => Topic::Finished,
        }
    }

    /// Its bytes on the wire.
    pub fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Clock(message) => encode(message),
            Self::Skeleton(message) | Self::RobotSkeleton(message) => encode(message),
            Self::Transforms(message) => encode(message),
            Self::Markers(message) => encode(message),
            Self::ObjectPose(message) => encode(message),
            // std_msgs/msg/Bool is one byte.
            Self::Finished(is_finished) => vec![0, 1, 0, 0, u8::from(*is_finished)],
        }
    }
}
