//! Who stands where: joints and bones, their places in time, two people and what they hand over.
//!
//! Everything here is checked once, where it is made; whoever holds a [`Sequence`] or a
//! [`Recording`] never checks again. Positions are metres in a right-handed world, z up.
//!
//! Reads no file and knows nothing of meshes or robots.

mod attached;
mod difference;
mod heading;
mod joints;
mod mirror;
mod part;
mod recording;
mod rootless;
mod sequence;
mod smooth;

pub use attached::{AttachError, Riders};
pub use difference::joint_differences;
pub use joints::{Bone, JointId, Skeleton, SkeletonError};
pub use part::{Part, Side};
pub use recording::{ObjectTrack, Person, PointTrack, Recording, RecordingError, Role};
pub use sequence::{Frame, Sequence, SequenceError, StampsError};
