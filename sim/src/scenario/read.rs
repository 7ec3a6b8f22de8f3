//! YAML → [`Scenario`].

use handover_mesh::{Role, Side};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use serde_saphyr::NonFiniteFloatPolicy;

use super::fields::Fields;
use super::{Bounds, Change, Events, Exchange, Interval, Robot, Scenario, ScenarioError};
use crate::scene::{PersonConfig, SceneConfig, StepIn, draw};
use crate::sensor::SensorConfig;

const SIDES: [(&str, Side); 2] = [("left", Side::Left), ("right", Side::Right)];

impl Scenario {
    /// Reads a scenario's text.
    ///
    /// - `file`: what errors call it.
    /// - `name`: what it is called itself.
    ///
    /// # Errors
    /// [`ScenarioError`] with every unknown key, wrong type and value out of range.
    pub fn from_yaml(file: &str, name: &str, yaml: &str) -> Result<Self, ScenarioError> {
        // As text, .nan is a value like any other, and refused with its key.
        let options = serde_saphyr::options! {
            non_finite_float_policy: NonFiniteFloatPolicy::AsString,
        };
        let parsed: Value = serde_saphyr::from_str_with_options(yaml, options)
            .map_err(|error| unreadable(file, &error))?;
        let is_blank = parsed.as_object().map_or(parsed.is_null(), serde_json::Map::is_empty);
        if is_blank {
            return Err(ScenarioError::Empty { file: file.to_owned() });
        }
        if !parsed.is_object() {
            return Err(ScenarioError::NoMap { file: file.to_owned() });
        }
        let mut fields = Fields::of(&parsed);
        let scenario = Self::from_fields(&mut fields, name);
        match fields.finish() {
            violations if violations.is_empty() => Ok(scenario),
            violations => Err(ScenarioError::Violations { file: file.to_owned(), violations }),
        }
    }

    /// Every key a scenario may have, with dots between sections.
    pub fn keys() -> Vec<String> {
        let mut fields = Fields::of(&Value::Null);
        Self::from_fields(&mut fields, "");
        fields.into_known()
    }

    /// Every key there is, with its bounds: the one place that knows them. It asks for all of them
    /// whatever is given, so that [`Self::keys`] and messages have them all.
    fn from_fields(fields: &mut Fields, name: &str) -> Self {
        if !fields.has("about") {
            fields.blame("about", "is missing: what happens, in a sentence");
        }
        let about = fields.text("about").unwrap_or_default();
        let seed = fields.whole("scene.seed");
        let scene = scene(fields, seed);
        let mut robot = Robot { stature: scene.giver.stature, lag: 0.05, speed: 2.0 };
        fields.float("robot.stature", &mut robot.stature, 1.2, 2.2);
        fields.float("robot.lag_s", &mut robot.lag, 0.0, 1.0);
        fields.float("robot.speed_m_s", &mut robot.speed, 0.05, 10.0);
        let (sensor, latency) = sensor(fields);
        let events = events(fields);
        let mut tick_rate = 30;
        fields.rate("tick_hz", &mut tick_rate, &Self::TICK_RATES);
        let mut after = 0.5;
        fields.float("after_s", &mut after, 0.0, 10.0);
        let bounds = Bounds::from_fields(fields, events.partner);
        let (name, seed) = (name.to_owned(), seed.unwrap_or(0));
        Self { name, about, seed, scene, sensor, latency, events, tick_rate, robot, after, bounds }
    }
}

/// What the reader says, without what it says to programmers where people can do it.
fn unreadable(file: &str, error: &serde_saphyr::Error) -> ScenarioError {
    let file = file.to_owned();
    match error.without_snippet() {
        serde_saphyr::Error::DuplicateMappingKey { key, location } => ScenarioError::Twice {
            file,
            line: location.line(),
            key: key.clone().unwrap_or_else(|| "a key".to_owned()),
        },
        serde_saphyr::Error::MultipleDocuments { location, .. } => {
            ScenarioError::Documents { file, line: location.line() }
        }
        _ => ScenarioError::Yaml { file, problem: error.to_string() },
    }
}

/// The scene that a seed stands for (or the default one), and what is given of it instead.
fn scene(fields: &mut Fields, seed: Option<u64>) -> SceneConfig {
    let mut scene = match seed {
        Some(seed) => draw(&mut ChaCha8Rng::seed_from_u64(seed)),
        // In the camera's sight, where drawn scenes are.
        None => SceneConfig { centre: [0.0, 2.5], ..SceneConfig::default() },
    };
    // The robot's base stands.
    scene.approach = scene.approach.filter(|approach| approach.role == Role::Second);
    person(fields, "giver", &mut scene.giver);
    person(fields, "receiver", &mut scene.receiver);
    fields.number("scene.distance", &mut scene.distance);
    fields.number("scene.gap", &mut scene.gap);
    fields.number("scene.suit_receiver", &mut scene.suit_receiver);
    for (axis, value) in ["x", "y", "z"].iter().zip(scene.meeting_shift.iter_mut()) {
        fields.number(&format!("scene.meeting_shift.{axis}"), value);
    }
    let timing = &mut scene.timing;
    let durations = [
        ("lead_in", &mut timing.lead_in),
        ("giver_reach", &mut timing.giver_reach),
        ("reaction", &mut timing.reaction),
        ("receiver_reach", &mut timing.receiver_reach),
        ("hold", &mut timing.hold),
        ("release", &mut timing.release),
        ("retreat", &mut timing.retreat),
        ("lead_out", &mut timing.lead_out),
        ("tempo", &mut timing.tempo),
    ];
    for (key, target) in durations {
        fields.number(&format!("scene.timing.{key}"), target);
    }
    let steps_in = fields.has("scene.step_in");
    let mut step_in = StepIn { distance: 0.4, reach: 0.0, duration: 0.8, stay: 1.0 };
    fields.number("scene.step_in.distance", &mut step_in.distance);
    fields.number("scene.step_in.reach", &mut step_in.reach);
    fields.number("scene.step_in.duration", &mut step_in.duration);
    fields.number("scene.step_in.stay", &mut step_in.stay);
    scene.step_in = steps_in.then_some(step_in);
    fields.number("scene.heading", &mut scene.heading);
    fields.blame_all("scene.", scene.check());
    scene
}

fn person(fields: &mut Fields, who: &str, person: &mut PersonConfig) {
    let numbers = [
        ("stature", &mut person.stature),
        ("facing", &mut person.facing),
        ("lean", &mut person.lean),
        ("twist", &mut person.twist),
        ("swivel", &mut person.swivel),
        ("carry", &mut person.carry),
        ("arc", &mut person.arc),
        ("sway", &mut person.sway),
        ("swing", &mut person.swing),
        ("phase", &mut person.phase),
    ];
    for (key, target) in numbers {
        fields.number(&format!("scene.{who}.{key}"), target);
    }
    fields.choice(&format!("scene.{who}.hand"), &mut person.hand, &SIDES);
}

fn sensor(fields: &mut Fields) -> (SensorConfig, f64) {
    let mut is_kinect = true;
    fields.choice("sensor.kind", &mut is_kinect, &[("ideal", false), ("kinect", true)]);
    let mut rate = 30.0;
    fields.number("sensor.rate", &mut rate);
    let mut sensor = if is_kinect { SensorConfig::kinect(rate) } else { SensorConfig::ideal(rate) };
    fields.number("sensor.frame_loss", &mut sensor.frame_loss);
    fields.number("sensor.hold_rate", &mut sensor.hold_rate);
    fields.number("sensor.swap_rate", &mut sensor.swap_rate);
    fields.number("sensor.joint_noise", &mut sensor.joint_noise);
    fields.blame_all("", sensor.check());
    let mut latency = 0.03;
    fields.float("sensor.latency_s", &mut latency, 0.0, 1.0);
    (sensor, latency)
}

fn events(fields: &mut Fields) -> Events {
    let [hesitates, withdraws] =
        ["events.hesitation", "events.withdrawal"].map(|section| fields.has(section));
    if hesitates && withdraws {
        fields.blame("events.withdrawal", "cannot be together with events.hesitation");
    }
    // Durations first: they are missing only where something else of their event is still there.
    let pause = fields.duration("events.hesitation.pause_s", 10.0, false).unwrap_or_default();
    let reach_of_pause = reach(fields, "events.hesitation");
    let reach_of_turn = reach(fields, "events.withdrawal");
    let partner = match (hesitates, withdraws) {
        (_, true) => Change::Withdrawal { reach: reach_of_turn },
        (true, false) => Change::Hesitation { reach: reach_of_pause, pause },
        (false, false) => Change::None,
    };
    let occlusion = interval(fields, "events.occlusion");
    let during = interval(fields, "events.exchange");
    let mut aside = 1.0;
    fields.float("events.exchange.aside_m", &mut aside, -5.0, 5.0);
    let mut has_own_number = false;
    let numbers = [("same", false), ("other", true)];
    fields.choice("events.exchange.number", &mut has_own_number, &numbers);
    let exchange = during.map(|during| Exchange { during, aside, has_own_number });
    let silence = interval(fields, "events.silence");
    Events { partner, occlusion, exchange, silence }
}

/// When an event of the sensor is, if its section is given.
fn interval(fields: &mut Fields, section: &str) -> Option<Interval> {
    let happens = fields.has(section);
    let seconds = fields.duration(&format!("{section}.seconds"), 100.0, true).unwrap_or_default();
    let reach = reach(fields, section);
    happens.then_some(Interval { reach, seconds })
}

fn reach(fields: &mut Fields, section: &str) -> f64 {
    let mut reach = 0.5;
    fields.float(&format!("{section}.reach"), &mut reach, -2.0, 4.0);
    reach
}
