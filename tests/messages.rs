//! Bytes that should be messages.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use handover_mesh::Stamp;
use handover_mesh::messages::{
    DiagnosticArray, Header, JointState, Marker, MarkerArray, Message, MessageError,
    MultiDofJointState, MultiDofTrajectory, PoseStamped, Text, Time, Transform, TransformStamped,
    TransformTree, Vector3, decode, encode,
};
use proptest::prelude::*;

fn skeleton() -> MultiDofJointState {
    let place =
        |z| Transform { translation: Vector3 { x: 0.5, y: -1.0, z }, ..Transform::default() };
    MultiDofJointState {
        header: Header { stamp: Time { sec: 7, nanosec: 11 }, frame_id: "world".to_owned() },
        joint_names: vec!["head".to_owned(), "torso".to_owned()],
        transforms: vec![place(1.7), place(1.2)],
        ..MultiDofJointState::default()
    }
}

#[test]
fn the_bytes_are_those_of_fast_cdr() {
    // By rclpy.serialization.serialize_message of the same message.
    let expected = "00010000070000000b00000006000000776f726c6400000002000000050000006865616400000000\
                    06000000746f72736f0000000200000000000000000000000000e03f000000000000f0bf33333333\
                    3333fb3f000000000000000000000000000000000000000000000000000000000000f03f00000000\
                    0000e03f000000000000f0bf333333333333f33f0000000000000000000000000000000000000000\
                    00000000000000000000f03f0000000000000000";
    let hexadecimal: String =
        encode(&skeleton()).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(hexadecimal, expected);
}

#[test]
fn either_byte_order_is_read() {
    let bytes = [0, 0, 0, 0, 0, 0, 0, 3, b'h', b'i', 0];
    assert_eq!(decode::<Text>(&bytes).unwrap().data, "hi");
}

#[test]
fn what_is_no_message_says_why() {
    let short = decode::<Text>(&[0, 1]).unwrap_err();
    assert_eq!(short.to_string(), "std_msgs/msg/String: 2 bytes are no message");
    let other = decode::<Text>(&[0, 7, 0, 0, 1, 0, 0, 0, 0]).unwrap_err();
    assert!(matches!(other, MessageError::Encoding { encoding: 7, .. }), "{other}");
    let bytes = encode(&skeleton());
    for length in 0..bytes.len() {
        assert!(decode::<MultiDofJointState>(&bytes[..length]).is_err(), "{length} bytes");
    }
}

#[test]
fn claimed_lengths_fill_no_memory() {
    // Four thousand million transforms, says the header of twenty bytes.
    let mut bytes = vec![0, 1, 0, 0];
    bytes.extend([0xff; 4]);
    bytes.extend([0; 12]);
    let used = allocation_counter::measure(|| {
        assert!(decode::<TransformTree>(&bytes).is_err());
        assert!(decode::<MarkerArray>(&bytes).is_err());
        assert!(decode::<Text>(&bytes).is_err());
    });
    assert!(used.bytes_max < 4 << 20, "{used:?}");
}

#[test]
fn stamps_go_through_to_the_nanosecond_and_are_held_at_the_ends() {
    for nanoseconds in [0, 1, -1, 999_999_999, 1_750_000_000_123_456_789, -1_500_000_000] {
        assert_eq!(Time::of(Stamp(nanoseconds)).stamp(), Stamp(nanoseconds));
    }
    assert_eq!(Time::of(Stamp(i64::MAX)), Time { sec: i32::MAX, nanosec: 999_999_999 });
    assert_eq!(Time::of(Stamp(i64::MIN)), Time { sec: i32::MIN, nanosec: 0 });
}

/// What decodes from some bytes has bytes of its own that say the same.
fn check<M: Message + PartialEq + std::fmt::Debug>(bytes: &[u8]) {
    if let Ok(message) = decode::<M>(bytes) {
        let again = encode(&message);
        assert_eq!(encode(&decode::<M>(&again).unwrap()), again);
    }
}

fn check_all(bytes: &[u8]) {
    check::<MultiDofJointState>(bytes);
    check::<MultiDofTrajectory>(bytes);
    check::<JointState>(bytes);
    check::<TransformTree>(bytes);
    check::<MarkerArray>(bytes);
    check::<PoseStamped>(bytes);
    check::<DiagnosticArray>(bytes);
    check::<Text>(bytes);
}

proptest! {
    #[test]
    fn any_message_bytes_never_panic(mut bytes in prop::collection::vec(any::<u8>(), 0..300), order in 0_u8..2) {
        if let [first, second, ..] = &mut bytes[..] {
            (*first, *second) = (0, order);
        }
        check_all(&bytes);
    }

    #[test]
    fn flipped_message_bytes_never_panic(at in any::<prop::sample::Index>(), value in any::<u8>()) {
        let edge = TransformStamped { child_frame_id: "head_1".to_owned(), ..TransformStamped::default() };
        let tree = TransformTree { transforms: vec![edge; 3] };
        let markers = MarkerArray { markers: vec![Marker::default(); 2] };
        for mut bytes in [encode(&skeleton()), encode(&tree), encode(&markers)] {
            let at = at.index(bytes.len());
            bytes[at] = value;
            check_all(&bytes);
        }
    }
}
