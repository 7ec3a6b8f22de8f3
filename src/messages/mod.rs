//! Standard ROS 2 messages as plain values ⇄ their bytes on the wire and in bags.
//!
//! The bytes are plain CDR in either byte order behind the four bytes that name it (OMG DDSI-RTPS
//! 2.3, 10.2.1.2), as every ROS 2 middleware writes them; ours are little endian, byte for byte
//! what Fast CDR makes. Fields have the names and the order of the `.msg` files.
//!
//! Needs no ROS: bags are read without one, and the nodes send and receive these very bytes. Says
//! nothing of what a message means to a handover.

mod basic;
mod joints;
mod marker;
mod status;

use byteorder::{BigEndian, LittleEndian};
use serde::Serialize;
use serde::de::DeserializeOwned;

pub use basic::{
    Clock, Duration, Header, Point3, Pose, PoseStamped, Quaternion, Text, Time, Transform,
    TransformStamped, TransformTree, Vector3,
};
pub use joints::{
    JointState, MultiDofJointState, MultiDofPoint, MultiDofTrajectory, Twist, Wrench,
};
pub use marker::{Color, CompressedImage, Marker, MarkerArray, MeshFile, UvCoordinate};
pub use status::{Diagnostic, DiagnosticArray, KeyValue};

/// A message of a known type.
pub trait Message: Serialize + DeserializeOwned {
    /// Its name, e.g. `sensor_msgs/msg/JointState`.
    const TYPE: &'static str;
}

/// Why some bytes are no message of a type.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MessageError {
    /// Too short to say how it is encoded.
    #[error("{type_name}: {length} bytes are no message")]
    Short {
        /// What it should be.
        type_name: &'static str,
        /// How many bytes there are.
        length: usize,
    },
    /// Not plain CDR.
    #[error("{type_name}: encoding {encoding:#06x} is not plain CDR (0x0000 or 0x0001)")]
    Encoding {
        /// What it should be.
        type_name: &'static str,
        /// The first two bytes.
        encoding: u16,
    },
    /// The bytes end too early or hold what the type cannot.
    #[error("{type_name}: {reason}")]
    Malformed {
        /// What it should be.
        type_name: &'static str,
        /// What the decoder says.
        reason: String,
    },
}

/// A message from its bytes.
///
/// ```
/// use handover_mesh::messages::{Text, decode, encode};
/// let state = Text { data: "approach".to_owned() };
/// let bytes = encode(&state);
/// assert_eq!(bytes, b"\0\x01\0\0\x09\0\0\0approach\0");
/// assert_eq!(decode::<Text>(&bytes)?, state);
/// # Ok::<(), handover_mesh::messages::MessageError>(())
/// ```
///
/// # Errors
/// [`MessageError`]; no bytes panic, nor cost more memory than a small multiple of their length and
/// a megabyte.
pub fn decode<M: Message>(bytes: &[u8]) -> Result<M, MessageError> {
    let type_name = M::TYPE;
    let Some((&[high, low, _, _], body)) = bytes.split_first_chunk() else {
        return Err(MessageError::Short { type_name, length: bytes.len() });
    };
    let decoded = match u16::from_be_bytes([high, low]) {
        0 => cdr_encoding::from_bytes::<M, BigEndian>(body),
        1 => cdr_encoding::from_bytes::<M, LittleEndian>(body),
        encoding => return Err(MessageError::Encoding { type_name, encoding }),
    };
    let malformed = |error: cdr_encoding::Error| MessageError::Malformed {
        type_name,
        reason: error.to_string(),
    };
    decoded.map(|(message, _)| message).map_err(malformed)
}

/// A message's bytes.
///
/// # Panics
/// If a string or a sequence is longer than 2³²: none of ours is.
#[expect(clippy::expect_used, reason = "writing to memory fails only where a length has no number")]
pub fn encode<M: Message>(message: &M) -> Vec<u8> {
    let mut bytes = vec![0, 1, 0, 0];
    cdr_encoding::to_writer::<M, LittleEndian, _>(&mut bytes, message)
        .expect("messages are far shorter than 2³²");
    bytes
}
