//! What trackers call joints → what this crate calls them.
//!
//! Frames: `{joint}_{id}` by OpenNI/NiTE's names (openni_tracker, nuitrack), or by REP-155's
//! (`l_elbow_7`), whose wrists and ankles stand for hands and feet. Markers: the joint numbers of
//! Azure Kinect body tracking, `100 body + joint`.

/// REP-155's names that are not NiTE's too.
const REP_155: [(&str, &str); 12] = [
    ("l_shoulder", "left_shoulder"),
    ("l_elbow", "left_elbow"),
    ("l_wrist", "left_hand"),
    ("r_shoulder", "right_shoulder"),
    ("r_elbow", "right_elbow"),
    ("r_wrist", "right_hand"),
    ("l_hip", "left_hip"),
    ("l_knee", "left_knee"),
    ("l_ankle", "left_foot"),
    ("r_hip", "right_hip"),
    ("r_knee", "right_knee"),
    ("r_ankle", "right_foot"),
];

/// Azure Kinect's joint numbers and NiTE's names, in NiTE's order; `spine_navel` is the torso.
pub(super) const AZURE_KINECT: [(u32, &str); 15] = [
    (26, "head"),
    (3, "neck"),
    (1, "torso"),
    (5, "left_shoulder"),
    (6, "left_elbow"),
    (8, "left_hand"),
    (12, "right_shoulder"),
    (13, "right_elbow"),
    (15, "right_hand"),
    (18, "left_hip"),
    (19, "left_knee"),
    (21, "left_foot"),
    (22, "right_hip"),
    (23, "right_knee"),
    (25, "right_foot"),
];

/// How many marker numbers a body has.
pub(super) const MARKERS_A_BODY: u32 = 100;

/// A frame's name that ends in a body's number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameName {
    /// Whose.
    pub id: u32,
    /// The joint by NiTE's name; none of a frame that is no joint of ours (`body_7`).
    pub joint: Option<&'static str>,
}

/// Whose joint a frame is; `None` unless its name ends in `_` and a number.
///
/// ```
/// use handover_mesh::bodies::{FrameName, joint_of_frame};
/// assert_eq!(joint_of_frame("left_hand_2"), Some(FrameName { id: 2, joint: Some("left_hand") }));
/// assert_eq!(joint_of_frame("/l_wrist_2"), joint_of_frame("left_hand_2"));
/// assert_eq!(joint_of_frame("body_2"), Some(FrameName { id: 2, joint: None }));
/// assert_eq!(joint_of_frame("camera_link"), None);
/// ```
pub fn joint_of_frame(frame: &str) -> Option<FrameName> {
    let (name, id) = frame.strip_prefix('/').unwrap_or(frame).rsplit_once('_')?;
    // `parse` takes a sign too, which is no digit.
    let digits = id.bytes().all(|byte| byte.is_ascii_digit());
    let id = id.parse().ok().filter(|_| digits)?;
    let nite = AZURE_KINECT.iter().map(|(_, nite)| (*nite, *nite));
    let joint = nite.chain(REP_155).find(|(known, _)| *known == name).map(|(_, nite)| nite);
    Some(FrameName { id, joint })
}

/// Whose joint a marker of this number is: the body's number and NiTE's name.
pub fn joint_of_marker(number: i32) -> Option<(u32, &'static str)> {
    let number = u32::try_from(number).ok()?;
    let joint = AZURE_KINECT.iter().find(|(joint, _)| *joint == number % MARKERS_A_BODY)?;
    Some((number / MARKERS_A_BODY, joint.1))
}

/// The number of a joint's marker, if Azure Kinect has such a joint and such numbers.
pub(super) fn marker_of_joint(body: u32, name: &str) -> Option<i32> {
    let (joint, _) = AZURE_KINECT.iter().find(|(_, known)| *known == name)?;
    i32::try_from(body.checked_mul(MARKERS_A_BODY)?.checked_add(*joint)?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::skeleton::Skeleton;

    #[test]
    fn every_way_to_name_joints_names_nites() {
        let nite = Skeleton::nite();
        assert_eq!(AZURE_KINECT.map(|(_, name)| name.to_owned())[..], *nite.names());
        for name in nite.names() {
            let found = joint_of_frame(&format!("{name}_17"));
            assert_eq!(found.and_then(|found| found.joint), Some(name.as_str()));
            let number = marker_of_joint(17, name).unwrap();
            assert_eq!(joint_of_marker(number), Some((17, name.as_str())));
        }
        assert!(REP_155.iter().all(|(_, nite_name)| nite.joint(nite_name).is_some()));
    }

    #[test]
    fn what_is_no_joint_is_none() {
        for frame in ["", "_", "head", "head_", "head_x", "head_+1", "head_-1", "head_4294967296"] {
            assert_eq!(joint_of_frame(frame), None, "{frame}");
        }
        assert_eq!(joint_of_frame("wheel_1"), Some(FrameName { id: 1, joint: None }));
        assert_eq!(joint_of_marker(-74), None);
        assert_eq!(joint_of_marker(102), None);
        assert_eq!(marker_of_joint(u32::MAX, "head"), None);
        assert_eq!(marker_of_joint(0, "tail"), None);
    }
}
