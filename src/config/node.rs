//! Parameters of the ROS 2 node alone: models and replays do not know them.

use serde_json::{Value, json};

use super::Kind;
use super::fields::Fields;
use crate::geometry::{Isometry, Vector};
use crate::settings::real;

/// How the node knows where the robot is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RobotState {
    /// It says so on `robot_skeleton`; before that nothing is published.
    Reported,
    /// It stands where `world_from_base` says, as the demonstrations begin; from then on its last
    /// target counts.
    Demonstrated,
}

/// Which messages the partner is seen in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// `skeleton`.
    Skeleton,
    /// `/tf`, a frame for each joint.
    Transforms,
    /// `skeleton_markers`.
    Markers,
}

/// What the ROS 2 node is told besides what the tick is.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeSettings {
    /// The model's file; empty: none yet.
    pub model: String,
    /// The role that the model's robot has to have; empty: whichever it has.
    pub role: String,
    /// Whether the edges between the people count (`mesh`), or the demonstrations alone (`none`).
    pub edges: bool,
    /// Ticks a second at least `[Hz]`; a new skeleton is answered at once, up to four times as often.
    pub rate: f64,
    /// Whether the node makes itself active.
    pub autostart: bool,
    /// Where the partner is seen.
    pub source: Source,
    /// The frame that everything is in.
    pub world_frame: String,
    /// The frame of messages that [`Self::world_from_sensor`] is for; empty: none.
    pub sensor_frame: String,
    /// Where the sensor is.
    pub world_from_sensor: Isometry,
    /// How the node knows where the robot is.
    pub robot_state: RobotState,
    /// Where the robot's base joint is at the start, and which way it faces (along x), if
    /// [`RobotState::Demonstrated`]; in [`Self::base_frame`].
    pub world_from_base: Isometry,
    /// The frame that [`Self::world_from_base`] is in; empty: the world.
    pub base_frame: String,
    /// The number of the body that is the partner; none: whoever is nearest in the start zone.
    pub partner: Option<u32>,
    /// How far from the robot's base, along the floor, a partner is taken up `[m]`.
    pub start_zone: f64,
    /// How soon before hands are to meet it counts as an approach `[s]`.
    pub approach: f64,
    /// How near the gap between the hands is to the demonstrated one at contact `[m]`.
    pub contact_distance: f64,
    /// How often a second markers are published at most `[Hz]`; 0: never.
    pub markers_rate: f64,
    /// How often a second diagnostics are published `[Hz]`, besides when the reason to hold changes.
    pub diagnostics_rate: f64,
}

impl Default for NodeSettings {
    fn default() -> Self {
        Self {
            model: String::new(),
            role: String::new(),
            edges: true,
            rate: 100.0,
            autostart: false,
            source: Source::Skeleton,
            world_frame: "world".to_owned(),
            sensor_frame: String::new(),
            world_from_sensor: Isometry::identity(),
            robot_state: RobotState::Reported,
            world_from_base: Isometry::translation(0.0, 0.0, 1.0),
            base_frame: String::new(),
            partner: None,
            start_zone: 4.0,
            approach: 1.5,
            contact_distance: 0.08,
            markers_rate: 20.0,
            diagnostics_rate: 10.0,
        }
    }
}

/// Every key of the node, with its bounds.
pub(super) fn take(fields: &mut Fields, node: &mut NodeSettings) {
    fields.free_text("node.model", &mut node.model);
    fields.free_text("node.role", &mut node.role);
    fields.choice("node.method", &mut node.edges, &[("mesh", true), ("none", false)]);
    fields.numbers([real("node.rate", &mut node.rate, 1.0, 1000.0)]);
    fields.flag("node.autostart", &mut node.autostart);
    let sources =
        [("skeleton", Source::Skeleton), ("tf", Source::Transforms), ("markers", Source::Markers)];
    fields.choice("node.source", &mut node.source, &sources);
    fields.text("node.world_frame", &mut node.world_frame);
    fields.free_text("node.sensor_frame", &mut node.sensor_frame);
    pose(fields, "node.world_from_sensor", &mut node.world_from_sensor);
    let states = [("reported", RobotState::Reported), ("demonstrated", RobotState::Demonstrated)];
    fields.choice("node.robot_state", &mut node.robot_state, &states);
    pose(fields, "node.world_from_base", &mut node.world_from_base);
    fields.free_text("node.base_frame", &mut node.base_frame);
    fields.take(
        "node.partner",
        Kind::Whole { low: -1, high: i64::from(i32::MAX) },
        &mut node.partner,
        |value| match value.as_i64()? {
            -1 => Some(None),
            number => i32::try_from(number).ok().and_then(|n| u32::try_from(n).ok()).map(Some),
        },
        |partner| partner.map_or(json!(-1), |number| json!(number)),
        || format!("a whole number from -1 to {}", i32::MAX),
    );
    fields.numbers([
        real("node.start_zone", &mut node.start_zone, 0.3, 20.0),
        real("node.approach", &mut node.approach, 0.1, 60.0),
        real("node.contact_distance", &mut node.contact_distance, 0.01, 1.0),
    ]);
    fields.numbers([
        real("node.markers_rate", &mut node.markers_rate, 0.0, 1000.0),
        real("node.diagnostics_rate", &mut node.diagnostics_rate, 0.1, 1000.0),
    ]);
}

/// `[x, y, z, roll, pitch, yaw]`, metres and radians; the turns are about the fixed x, y and z.
fn pose(fields: &mut Fields, key: &'static str, pose: &mut Isometry) {
    let parse = |value: &Value| {
        let numbers: Option<Vec<f64>> = value.as_array()?.iter().map(Value::as_f64).collect();
        let numbers: [f64; 6] = numbers?.try_into().ok()?;
        let [x, y, z, roll, pitch, yaw] = numbers;
        let fits = numbers[..3].iter().all(|metres| metres.abs() <= 1e3)
            && numbers[3..].iter().all(|angle| angle.abs() <= 7.0);
        let turn = nalgebra::UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        fits.then(|| Isometry::from_parts(Vector::new(x, y, z).into(), turn))
    };
    let show = |pose: &Isometry| {
        let (roll, pitch, yaw) = pose.rotation.euler_angles();
        let shift = pose.translation.vector;
        json!([shift.x, shift.y, shift.z, roll, pitch, yaw])
    };
    let bound = || "six numbers: x, y, z in metres, then roll, pitch, yaw in radians".to_owned();
    fields.take(key, Kind::Reals, pose, parse, show, bound);
}
