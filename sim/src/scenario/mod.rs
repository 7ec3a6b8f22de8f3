//! A file → one closed-loop trial: who meets whom, what goes wrong, and what has to hold.
//!
//! ```yaml
//! about: The partner stops half-way for a second, then goes on.
//! scene: {seed: 5, gap: 0.12}
//! sensor: {kind: kinect, rate: 30, latency_s: 0.03}
//! events: {hesitation: {reach: 0.5, pause_s: 1.0}}
//! robot: {lag_s: 0.05, speed_m_s: 2.0}
//! tick_hz: 30
//! bounds: {gap_cm_most: 8, held_share_most: 0.2}
//! ```
//!
//! Every key but `about`, `bounds` and how long an event lasts has a default: docs/scenario.md has all
//! of them. Whatever is wrong is reported together: the file, the key, the value, the bound. Text in,
//! values out: opens no file.

mod bounds;
mod fields;
mod figure;
mod read;

use handover_mesh::config::Violation;

use crate::scene::SceneConfig;
use crate::sensor::SensorConfig;

pub use bounds::{Bounds, Limit, Verdict};
pub use figure::Figure;

/// One trial, checked: see the module.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// What it is called: its file's stem.
    pub name: String,
    /// What happens, in a sentence.
    pub about: String,
    /// What noise follows from; also what of the scene is not given, if `scene.seed` is.
    pub seed: u64,
    /// The two people as planned; the robot takes the giver's place.
    pub scene: SceneConfig,
    /// What sees the partner.
    pub sensor: SensorConfig,
    /// From the capture of a frame to its receipt `[s]`, 0 to 1.
    pub latency: f64,
    /// What does not go as planned.
    pub events: Events,
    /// Ticks a second `[Hz]`: one of [`Self::TICK_RATES`].
    pub tick_rate: u32,
    /// The robot's body and joints.
    pub robot: Robot,
    /// How long the trial goes on after the scene's end `[s]`, 0 to 10.
    pub after: f64,
    /// What has to hold.
    pub bounds: Bounds,
}

impl Scenario {
    /// The ticks' rates there are `[Hz]`.
    pub const TICK_RATES: [u32; 3] = [30, 100, 1000];
}

/// The robot: a body like a person's, and joints that are slower than they are told to be.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    /// How tall `[m]`, 1.2 to 2.2.
    pub stature: f64,
    /// Time constant with which joints follow their targets `[s]`, 0 to 1.
    pub lag: f64,
    /// No joint moves faster `[m/s]`, 0.05 to 10.
    pub speed: f64,
}

/// What does not go as planned. Instants are parts of the partner's reach `[-]`: 0 its start, 1
/// its end, −2 to 4.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Events {
    /// What the partner does with their time.
    pub partner: Change,
    /// The partner's active hand is not tracked for a while.
    pub occlusion: Option<Interval>,
    /// Somebody else is reported as the partner for a while.
    pub exchange: Option<Exchange>,
    /// No message arrives for a while.
    pub silence: Option<Interval>,
}

/// What the partner does with their time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Change {
    /// As planned.
    #[default]
    None,
    /// They stop, stand for `pause` `[s]`, and go on.
    Hesitation {
        /// At which part of their reach.
        reach: f64,
        /// How long `[s]`, 0 to 10.
        pause: f64,
    },
    /// They stop, draw back, and do not come again.
    Withdrawal {
        /// At which part of their reach.
        reach: f64,
    },
}

/// A while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// At which part of the partner's reach it begins.
    pub reach: f64,
    /// How long it lasts `[s]`; infinite: for good.
    pub seconds: f64,
}

/// Somebody else, reported as the partner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exchange {
    /// When.
    pub during: Interval,
    /// How far beside the giver that person stands `[m]`, across the line between the two people.
    pub aside: f64,
    /// Whether the sensor tells them apart: a number of their own, else the partner's.
    pub has_own_number: bool,
}

/// Why a text is no scenario.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ScenarioError {
    /// The text is no YAML.
    #[error("{file}: not YAML: {problem}")]
    Yaml {
        /// Its file.
        file: String,
        /// What the reader says.
        problem: String,
    },
    /// A key is there twice in one map.
    #[error("{file}: line {line}: {key} is given twice")]
    Twice {
        /// Its file.
        file: String,
        /// Where it is the second time, from 1.
        line: u64,
        /// The key, without the sections around it.
        key: String,
    },
    /// A second document begins.
    #[error("{file}: line {line}: a second document begins; a file holds one scenario")]
    Documents {
        /// Its file.
        file: String,
        /// Where, from 1.
        line: u64,
    },
    /// The text holds nothing.
    #[error("{file}: is empty: about and bounds are needed")]
    Empty {
        /// Its file.
        file: String,
    },
    /// The text is YAML, but not a map.
    #[error("{file}: must be a map of keys and values, such as about: and bounds:")]
    NoMap {
        /// Its file.
        file: String,
    },
    /// Keys, types or values, all of them.
    #[error("{}", lines(.file, .violations))]
    Violations {
        /// Its file.
        file: String,
        /// At least one.
        violations: Vec<Violation>,
    },
}

fn lines(file: &str, violations: &[Violation]) -> String {
    let lines = violations.iter().map(|v| format!("{file}: {} {}", v.key, v.problem));
    lines.collect::<Vec<_>>().join("\n")
}
