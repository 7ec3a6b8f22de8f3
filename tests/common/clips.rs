//! Short handovers as files, and the names in what is said of them: what the tests of
//! `handover evaluate` and `handover replay` share; included by path.

use std::collections::BTreeMap;
use std::fs;
use std::sync::Arc;

use handover_mesh::formats::csv;
use handover_mesh::geometry::yaw_isometry;
use handover_mesh::kinematics::{minimum_jerk, two_bone};
use handover_mesh::{Frame, Person, Point, Recording, Sequence, Skeleton, Stamp, Vector};
use serde_json::Value;
use tempfile::TempDir;

use crate::common::folder;

pub(crate) const FRAMES: i64 = 24;
pub(crate) const METHODS: [&str; 8] =
    ["hold", "replay", "knn", "ridge", "promp", "attach", "none", "mesh"];
pub(crate) const FIGURES: [&str; 9] = [
    "joint_cm",
    "hand_cm",
    "contact_cm",
    "gap_cm",
    "gap_at_contact_cm",
    "timing_ms",
    "reach_ms",
    "bone_mm",
    "jerk_m_s3",
];

/// Nine joints of somebody who faces x and reaches for a point `[m]`, seen from their own feet.
fn pose(reach: Point) -> Vec<Point> {
    let spine = [1.7, 1.5, 1.2].map(|z| Point::new(0.0, 0.0, z));
    let arm = |side: f64, target: Point| {
        let shoulder = Point::new(0.0, 0.2 * side, 1.45);
        let arm = two_bone(shoulder, target, 0.3, 0.35, Vector::new(0.0, side, -1.0));
        [shoulder, arm.middle, arm.end]
    };
    let left = arm(1.0, Point::new(0.1, 0.25, 0.9));
    spine.into_iter().chain(left).chain(arm(-1.0, reach)).collect()
}

/// A short handover; every `number` has its own place, reach and height.
fn clip(number: u32) -> Recording {
    let number = f64::from(number);
    let names = ["head", "neck", "torso", "left_shoulder", "left_elbow", "left_hand"];
    let names = names.into_iter().chain(["right_shoulder", "right_elbow", "right_hand"]);
    let skeleton =
        Arc::new(Skeleton::from_names(names.map(str::to_owned).collect::<Vec<_>>()).unwrap());
    let rest = Point::new(0.15, -0.25, 0.95);
    let reach = Point::new(0.42 + 0.02 * number, -0.05, 1.1 + 0.03 * number);
    let person = |name: &str, turn: f64, place: f64| {
        let world_from_person = yaw_isometry(turn, Vector::new(place, 0.05 * number, 0.0));
        let frames = (0..FRAMES).map(|k| {
            // Out in the first half, back in the second.
            let part = 1.0 - (2.0 * k as f64 / (FRAMES - 1) as f64 - 1.0).abs();
            let pose = pose(rest + (reach - rest) * minimum_jerk(1.2 * part));
            let positions = pose.into_iter().map(|p| world_from_person * p).collect();
            Frame { stamp: Stamp(k * 33_333_333), positions }
        });
        let motion = Sequence::new(skeleton.clone(), frames.collect()).unwrap();
        Person { name: name.to_owned(), motion }
    };
    let people = [
        person("giver", 0.0, -0.5 - 0.01 * number),
        person("receiver", std::f64::consts::PI, 0.5 + 0.01 * number),
    ];
    let pair = if number < 2.0 { "first" } else { "second" };
    let metadata = BTreeMap::from([("pair".to_owned(), pair.to_owned())]);
    Recording::new(format!("clip_{number}"), people, None, metadata).unwrap()
}

/// `clips/0.csv` and so on.
pub(crate) fn clips(count: u32) -> TempDir {
    let folder = folder(&[("clips/.keep", "")]);
    for number in 0..count {
        let path = folder.path().join(format!("clips/{number}.csv"));
        fs::write(path, csv::write(&clip(number)).unwrap()).unwrap();
    }
    folder
}

/// The keys of an object, in order.
pub(crate) fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}
