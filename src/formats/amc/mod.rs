//! Acclaim skeletons (ASF) and motions (AMC) → the joint angles of one person over time.
//!
//! The format is that of the Acclaim company as the CMU Graphics Lab's motion capture database
//! uses it (mocap.cs.cmu.edu): `.asf` says which bones there are, how long and which way, and
//! about which axes each may turn; `.amc` says by how much each is turned in every frame. Values
//! come out in metres and radians; where points come out, z is up.
//!
//! Makes no [`Recording`](crate::Recording): that takes two people, and here is one. Mends
//! nothing, leaves angles as they are (a full turn more stays one), and holds no motion to the
//! skeleton's limits.

mod axes;
mod hierarchy;
mod kinematics;
mod lines;
mod motion;
mod read_bone;
mod read_motion;
mod read_root;
mod read_skeleton;
mod skeleton;

pub use axes::Axis;
pub use motion::{Motion, Root};
pub use skeleton::{Asf, Bone, BoneId, Dof};

pub(super) use read_motion::SECTIONS as MOTION_SECTIONS;
pub(super) use read_skeleton::SECTIONS as SKELETON_SECTIONS;
