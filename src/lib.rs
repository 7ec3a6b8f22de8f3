//! A robot takes one side of a human-human handover.
//!
//! Two people's joints over time make an interaction mesh; its Laplacian coordinates, learned from
//! demonstrations, say where the robot's joints belong when the partner stands and moves as seen
//! now. Values in, values out: positions in metres (right-handed, z up), time in integer
//! nanoseconds; the library opens no file, reads no clock and prints nothing.

pub mod align;
pub mod blend;
pub mod bodies;
pub mod config;
pub mod delaunay;
pub mod demonstration;
pub mod evaluate;
pub mod filter;
pub mod forecast;
pub mod formats;
pub mod frames;
pub mod geometry;
pub mod kinematics;
pub mod learn;
pub mod lifecycle;
mod linear;
pub mod live;
pub mod mesh;
pub mod messages;
pub mod model;
pub mod motion;
pub mod online;
pub mod parameters;
pub mod predict;
pub mod retarget;
#[cfg(feature = "ros")]
pub mod ros;
mod rotations;
pub mod safety;
pub mod settings;
pub mod skeleton;
pub mod statistics;
pub mod time;
pub mod track;

pub use config::{Config, ConfigError, NodeSettings, RobotState};
pub use geometry::{Isometry, Point, Vector};
pub use skeleton::{
    Bone, Frame, JointId, ObjectTrack, Part, Person, PointTrack, Recording, RecordingError, Role,
    Sequence, SequenceError, Side, Skeleton, SkeletonError,
};
pub use time::{Span, Stamp};

/// The README's code has to compile.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
