//! What is broadcast and how: parameters with their ranges → settings.

use handover_mesh::Span;
use handover_mesh::formats::UpAxis;
use handover_mesh::parameters::{Parameter, ParameterTable, ParameterValue};

use super::Topic;
use crate::sensor::SensorConfig;

/// Frames a second of what is made up, where no rate is asked for `[Hz]`.
const OWN_RATE: f64 = 30.0;
/// How a sensor is made up that is like none of the known kinds.
const CUSTOM: &str = "custom";
/// What goes wrong at a sensor of some kind; where it stands is nothing that its kind says.
const NOT_OF_A_KIND: [&str; 5] = ["rate", "position.x", "position.y", "position.z", "yaw"];

/// Everything that a [`Player`](super::Player) and the node around it need to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The file to play; none: a made-up scene.
    pub recording: Option<String>,
    /// What all random choices follow from.
    pub seed: u64,
    /// The file's axis that points up.
    pub up: UpAxis,
    /// Whom the robot stands in for, by name; none: the first person.
    pub role: Option<String>,
    /// `[-]`, 1 as recorded.
    pub speed: f64,
    /// Frames a second `[Hz]`; none: the recording's own.
    pub rate: Option<f64>,
    /// Whether nothing moves, for now.
    pub is_paused: bool,
    /// Whether it begins again at the end.
    pub is_looped: bool,
    /// Between the end and the next beginning.
    pub pause: Span,
    /// Before the first beginning.
    pub start_delay: Span,
    /// How many have to listen to one of the partner's topics before that delay begins.
    pub listeners: usize,
    /// Whether time is ours: stamps are simulated, and `/clock` tells others.
    pub has_clock: bool,
    /// When simulated time starts; none: at the recording's first stamp.
    pub clock_start: Option<Span>,
    /// Whether the partner is sent as a skeleton.
    pub sends_skeleton: bool,
    /// Whether the partner is sent as transforms.
    pub sends_transforms: bool,
    /// Whether the partner is sent as markers.
    pub sends_markers: bool,
    /// Whether the robot's joints are sent.
    pub sends_robot: bool,
    /// Whether the object is sent, where there is one.
    pub sends_object: bool,
    /// The partner's number in transforms and markers.
    pub body: u32,
    /// The frame that places are in.
    pub world_frame: String,
    /// Whether the node ends when all has been played.
    pub exits_at_end: bool,
    /// What the sensor gets wrong.
    pub sensor: SensorConfig,
}

/// The parameters of the node, those of the sensor as its kind has them.
///
/// - `kind`: `ideal` or `kinect`; anything else is as `ideal`.
pub fn parameters(kind: &str) -> Vec<Parameter> {
    let at_start = |parameter: Parameter| parameter.read_only("it is taken when the node starts");
    let text = |name, value: &str, about| Parameter::new(name, value, about);
    let switch = |name, value: bool, about| Parameter::new(name, value, about);
    let number =
        |name, value: f64, low, high, about| Parameter::new(name, value, about).numbers(low, high);
    let mut parameters = vec![
        at_start(text("recording", "", "The file to play; empty: a made-up handover")),
        at_start(
            Parameter::new("seed", 0, "What all random choices follow from").whole(0, i64::MAX),
        ),
        at_start(text("up", "z", "The file's axis that points up").one_of(["z", "y"])),
        at_start(text(
            "role",
            "",
            "Whom the robot stands in for, by name; empty: robot, else the first person",
        )),
        number("speed", 1.0, 0.01, 100.0, "How fast, 1 is as recorded [-]"),
        at_start(number("rate", 0.0, 0.0, 240.0, "Frames a second, 0: the recording's own [Hz]")),
        switch("paused", false, "Whether playing stands still"),
        switch("loop", false, "Whether it begins again at the end"),
        at_start(number("pause", 1.0, 0.0, 3600.0, "Between the end and the next beginning [s]")),
        at_start(number("start_delay", 1.0, 0.0, 3600.0, "Before the first beginning [s]")),
        at_start(
            Parameter::new(
                "listeners",
                0,
                "How many have to listen to one of the partner's topics before start_delay begins [-]",
            )
            .whole(0, 100),
        ),
        at_start(switch("clock", false, "Whether stamps are simulated and /clock tells the time")),
        at_start(number(
            "clock_start",
            0.0,
            0.0,
            2e9,
            "When simulated time starts, 0: at the recording's first stamp [s]",
        )),
        at_start(switch("skeleton", true, "Whether the partner is sent as a skeleton")),
        at_start(switch("tf", true, "Whether the partner is sent as transforms")),
        at_start(switch("markers", false, "Whether the partner is sent as markers")),
        at_start(switch("robot_skeleton", true, "Whether the robot's joints are sent")),
        at_start(switch("object_pose", true, "Whether the object is sent, where there is one")),
        at_start(
            Parameter::new("body", 1, "The partner's number in transforms and markers [-]")
                .whole(0, 99_999),
        ),
        at_start(text("world_frame", "world", "The frame that places are in").filled()),
        at_start(switch("exit_at_end", false, "Whether the node ends when all has been played")),
    ];
    let known = known_kind(kind);
    let kind = if known.is_some() { kind } else { "ideal" };
    parameters.push(
        text(
            "sensor.kind",
            kind,
            "What the sensor gets wrong: nothing, what a Kinect with NiTE does, or as set below",
        )
        .one_of(["ideal", "kinect", CUSTOM]),
    );
    let mut sensor = known.unwrap_or_else(|| SensorConfig::ideal(OWN_RATE));
    for figure in sensor.figures().into_iter().filter(|figure| figure.key != "rate") {
        let unit = if figure.unit.is_empty() { "-" } else { figure.unit };
        let about = format!("{} [{unit}]", figure.about);
        let name = format!("sensor.{}", figure.key);
        parameters
            .push(Parameter::new(name, *figure.value, about).numbers(figure.low, figure.high));
    }
    parameters
}

fn known_kind(kind: &str) -> Option<SensorConfig> {
    match kind {
        "ideal" => Some(SensorConfig::ideal(OWN_RATE)),
        "kinect" => Some(SensorConfig::kinect(OWN_RATE)),
        _ => None,
    }
}

/// What has to change along with some changes: another kind of sensor has other figures, and one
/// with other figures is `custom`.
///
/// - `table`: of the [`parameters`], the changes taken.
/// - `changes`: what was set; a figure that was set together with a kind stays as set.
pub fn follow_ups(
    table: &ParameterTable,
    changes: &[(String, ParameterValue)],
) -> Vec<(String, ParameterValue)> {
    let is_set = |name: &str| changes.iter().any(|(changed, _)| changed == name);
    let kind = table.text("sensor.kind");
    let Some(mut of_kind) = known_kind(kind) else { return Vec::new() };
    let figures = of_kind.figures().into_iter();
    let figures = figures.filter(|figure| !NOT_OF_A_KIND.contains(&figure.key));
    let differing = figures
        .map(|figure| (format!("sensor.{}", figure.key), *figure.value))
        .filter(|(name, value)| table.number(name) != *value);
    let differing: Vec<(String, ParameterValue)> =
        differing.map(|(name, value)| (name, value.into())).collect();
    let custom = ("sensor.kind".to_owned(), CUSTOM.into());
    if differing.is_empty() {
        Vec::new()
    } else if !is_set("sensor.kind") {
        vec![custom]
    } else {
        let all = differing.len();
        let mut follow: Vec<_> = differing.into_iter().filter(|(name, _)| !is_set(name)).collect();
        if follow.len() < all {
            follow.push(custom);
        }
        follow
    }
}

impl Settings {
    /// Frames a second of what is made up `[Hz]`.
    pub fn rate_or_own(&self) -> f64 {
        self.rate.unwrap_or(OWN_RATE)
    }

    /// Whether there is anything on a topic.
    pub fn sends(&self, topic: Topic) -> bool {
        match topic {
            Topic::Clock => self.has_clock,
            Topic::Skeleton => self.sends_skeleton,
            Topic::Transforms => self.sends_transforms,
            Topic::Markers => self.sends_markers,
            Topic::RobotSkeleton => self.sends_robot,
            Topic::ObjectPose => self.sends_object,
            Topic::Finished => true,
        }
    }

    /// What a table of the [`parameters`] says.
    ///
    /// # Panics
    /// If it is a table of others.
    pub fn of(table: &ParameterTable) -> Self {
        let filled = |name| Some(table.text(name).to_owned()).filter(|text| !text.is_empty());
        let positive = |name| Some(table.number(name)).filter(|number| *number > 0.0);
        let span = |seconds| Span::from_seconds(seconds).unwrap_or_default();
        let mut sensor = SensorConfig::ideal(OWN_RATE);
        for figure in sensor.figures().into_iter().filter(|figure| figure.key != "rate") {
            *figure.value = table.number(&format!("sensor.{}", figure.key));
        }
        Self {
            recording: filled("recording"),
            seed: u64::try_from(table.whole("seed")).unwrap_or_default(),
            up: if table.text("up") == "y" { UpAxis::Y } else { UpAxis::Z },
            role: filled("role"),
            speed: table.number("speed"),
            rate: positive("rate"),
            is_paused: table.is_true("paused"),
            is_looped: table.is_true("loop"),
            pause: span(table.number("pause")),
            start_delay: span(table.number("start_delay")),
            listeners: usize::try_from(table.whole("listeners")).unwrap_or_default(),
            has_clock: table.is_true("clock"),
            clock_start: positive("clock_start").map(span),
            sends_skeleton: table.is_true("skeleton"),
            sends_transforms: table.is_true("tf"),
            sends_markers: table.is_true("markers"),
            sends_robot: table.is_true("robot_skeleton"),
            sends_object: table.is_true("object_pose"),
            body: u32::try_from(table.whole("body")).unwrap_or_default(),
            world_frame: table.text("world_frame").to_owned(),
            exits_at_end: table.is_true("exit_at_end"),
            sensor,
        }
    }
}

impl Default for Settings {
    /// A made-up handover, once, as it is.
    fn default() -> Self {
        Self::of(&ParameterTable::new(parameters("ideal")))
    }
}
