//! What the messages that are written into bags look like, for whoever reads them without our code.
//!
//! Definitions are those of ROS 2 (the same from Humble to Kilted but for constants), without their
//! comments; hashes are RIHS01 (REP-2016), by which ROS 2 knows a type.

use crate::messages::{
    Clock, DiagnosticArray, JointState, MarkerArray, Message, MultiDofJointState,
    MultiDofTrajectory, PoseStamped, Text, TransformTree,
};

/// Every type by itself: a line of `=`, `MSG: package/Name`, the fields.
const ALL: &str = include_str!("definitions.txt");

/// The hash of each type that is written.
const HASHES: [(&str, &str); 9] = [
    (
        MultiDofJointState::TYPE,
        "RIHS01_4d4ded702cfba7ff3ec783835c1a1425f75e53939a430ff355d1fee4b3bbc40b",
    ),
    (
        MultiDofTrajectory::TYPE,
        "RIHS01_3a18fd095292a65cfde8833c72985a30af981f3ec44494655c6267262b443a4a",
    ),
    (PoseStamped::TYPE, "RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8"),
    (
        TransformTree::TYPE,
        "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    ),
    (MarkerArray::TYPE, "RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf"),
    (Text::TYPE, "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"),
    (
        DiagnosticArray::TYPE,
        "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e",
    ),
    (Clock::TYPE, "RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564"),
    (JointState::TYPE, "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"),
];

/// The hash of a type, if it is one of those that are written.
pub(super) fn hash(type_name: &str) -> Option<&'static str> {
    HASHES.iter().find(|(known, _)| *known == type_name).map(|(_, hash)| *hash)
}

/// The fields of a type, and behind them those of all types that it is made of, as `ros2msg` has
/// them.
///
/// - `type_name`: `package/msg/Name`.
pub(super) fn definition(type_name: &str) -> Option<String> {
    let mut parts = vec![type_name.replace("/msg/", "/")];
    let mut text = fields(&parts[0])?.to_owned();
    let mut at = 0;
    while at < parts.len() {
        for field in fields(&parts[at])?.lines() {
            let kind = field.split([' ', '[']).next().unwrap_or_default();
            if kind.contains('/') && !parts.iter().any(|known| known == kind) {
                parts.push(kind.to_owned());
            }
        }
        at += 1;
    }
    for part in &parts[1..] {
        text += &format!("{}\nMSG: {part}\n{}", "=".repeat(80), fields(part)?);
    }
    Some(text)
}

/// The fields of one type.
fn fields(name: &str) -> Option<&'static str> {
    let blocks = ALL.split("MSG: ").skip(1);
    let mut named = blocks.filter_map(|block| block.split_once('\n'));
    let (_, fields) = named.find(|(known, _)| *known == name)?;
    Some(fields.trim_end_matches(['=', '\n'])).map(|kept| &fields[..kept.len() + 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_that_is_written_is_defined() {
        for (type_name, _) in HASHES {
            let definition = definition(type_name).unwrap();
            assert!(definition.ends_with('\n') && !definition.contains("=\n="), "{definition}");
        }
        let pose = definition(PoseStamped::TYPE).unwrap();
        assert!(
            pose.starts_with("std_msgs/Header header\ngeometry_msgs/Pose pose\n===="),
            "{pose}"
        );
        assert_eq!(pose.matches("MSG: ").count(), 5, "{pose}");
        assert_eq!(definition("nav_msgs/msg/Path"), None);
    }
}
