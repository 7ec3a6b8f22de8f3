//! The closed loop: every scenario holds its bounds, who does not listen misses them, equal runs are
//! equal to the byte, and bad scenarios are refused with all that is wrong.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use handover_mesh::demonstration::{Demonstration, Hands};
use handover_mesh::evaluate::{self, Figure as Evaluated};
use handover_mesh::filter::Sighting;
use handover_mesh::safety::HoldReason;
use handover_mesh::{Config, Frame, Point, Role, Sequence, Side, Skeleton, Span, Stamp};
use handover_sim::closed_loop::{
    Controller, Learnt, Outcome, Reply, Stage, TimeWarp, gap_error, play,
};
use handover_sim::scenario::{Figure, Scenario};
use handover_sim::scene::{Scene, draw};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Learned once for all tests of this file.
fn learnt() -> &'static Learnt {
    static LEARNT: OnceLock<Learnt> = OnceLock::new();
    LEARNT.get_or_init(|| Learnt::new(Learnt::DEMONSTRATIONS, &Config::default()).unwrap())
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios")
}

fn files() -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> =
        fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

fn scenario(file: &Path) -> Scenario {
    let name = file.file_stem().unwrap().to_str().unwrap();
    let text = fs::read_to_string(file).unwrap();
    Scenario::from_yaml(name, name, &text).unwrap_or_else(|error| panic!("{error}"))
}

fn named(name: &str) -> Scenario {
    scenario(&folder().join(format!("{name}.yaml")))
}

/// All bounds that were missed, with what was found.
fn missed(outcome: &Outcome) -> Vec<String> {
    let missed = outcome.verdicts.iter().filter(|verdict| !verdict.is_held);
    missed
        .map(|v| format!("{}: {} is {}, bound {}", outcome.name, v.key, v.value, v.bound))
        .collect()
}

#[test]
fn every_scenario_holds_its_bounds() {
    assert!(files().len() >= 12, "{:?}", files());
    let outcomes =
        files().into_iter().map(|file| Outcome::run(&scenario(&file), learnt()).unwrap());
    let missed: Vec<String> = outcomes.flat_map(|outcome| missed(&outcome)).collect();
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

#[test]
fn ticks_of_a_millisecond_are_held_to_what_those_of_a_frame_are() {
    let nominal = named("nominal");
    let fast = named("every_millisecond");
    let (name, about) = (fast.name.clone(), fast.about.clone());
    assert_eq!(fast, Scenario { name, about, tick_rate: 1000, ..nominal });
}

/// Stays where it is.
struct Still(Vec<Point>);

impl Controller for Still {
    fn tick(&mut self, _: Stamp, _: Option<Sighting<'_>>, robot: &[Point]) -> Reply<'_> {
        if self.0.is_empty() {
            self.0 = robot.to_vec();
        }
        Reply { target: Some(&self.0), reason: None }
    }
}

/// Does what the scenario's human giver would do at the start and pace of an ordinary handover,
/// whatever the partner does.
struct Blind {
    scene: Scene,
    start: Option<Stamp>,
    now: Vec<Point>,
}

impl Blind {
    /// In the robot's own body and where it stands, so that what it misses it misses by its motion.
    fn new(scenario: &Scenario) -> Self {
        let mut scene = scenario.scene.clone();
        // As demonstrations are drawn, before the scenario makes it another.
        let usual = draw(&mut ChaCha8Rng::seed_from_u64(scenario.seed)).timing;
        (scene.timing.lead_in, scene.timing.tempo) = (usual.lead_in, usual.tempo);
        scene.giver.stature = scenario.robot.stature;
        Self { scene: Scene::new(scene).unwrap(), start: None, now: Vec::new() }
    }
}

impl Controller for Blind {
    fn tick(&mut self, now: Stamp, _: Option<Sighting<'_>>, _: &[Point]) -> Reply<'_> {
        let elapsed = now - *self.start.get_or_insert(now);
        self.now = self.scene.pose(Role::First, elapsed.seconds()).positions.to_vec();
        Reply { target: Some(&self.now), reason: None }
    }
}

/// The missed bounds of some figures.
fn missed_of(outcome: &Outcome, figures: &[Figure]) -> Vec<String> {
    let missed = missed(outcome).into_iter();
    let is_of = |missed: &String, figure: &Figure| {
        missed.starts_with(&format!("{}: {}_", outcome.name, figure.key()))
    };
    missed.filter(|missed| figures.iter().any(|figure| is_of(missed, figure))).collect()
}

/// Of the hands' meeting.
const MEETING: [Figure; 3] = [Figure::Gap, Figure::GapAtContact, Figure::ContactAfter];

/// Of what the robot makes of the partner, or of not seeing them; not of its limits, its body, or the
/// reasons it gives.
const LOOKING: [Figure; 8] = [
    Figure::Gap,
    Figure::GapAtContact,
    Figure::ContactAfter,
    Figure::Reach,
    Figure::Early,
    Figure::Crept,
    Figure::Disturbed,
    Figure::StandsAfter,
];

/// In these the partner does as in demonstrations, at their pace: what a human does then is right.
const AS_DEMONSTRATED: [&str; 5] =
    ["another_number", "every_millisecond", "nominal", "occlusion", "person_swap"];

#[test]
fn who_stands_or_does_not_look_misses_what_a_scenario_asks_for() {
    for file in files() {
        let scenario = scenario(&file);
        let stage = Stage::new(&scenario).unwrap();
        let still = Outcome::with(&scenario, learnt(), &stage, &mut Still(Vec::new()));
        let found = missed_of(&still, &LOOKING);
        assert!(!found.is_empty(), "{}: who stands still", still.name);
        let blind = Outcome::with(&scenario, learnt(), &stage, &mut Blind::new(&scenario));
        assert!(blind.figures[&Figure::Bone].unwrap() < 1e-6, "{}: its bones", blind.name);
        let found = missed_of(&blind, &LOOKING);
        println!("{}: {}", blind.name, found.join("; "));
        if AS_DEMONSTRATED.contains(&blind.name.as_str()) {
            let missed = missed_of(&blind, &MEETING);
            assert!(missed.is_empty(), "{}: the human is met: {missed:?}", blind.name);
        } else {
            assert!(!found.is_empty(), "{}: who does not look", blind.name);
        }
    }
}

/// The gate alone keeps the robot away from whoever steps in.
#[test]
fn without_separation_whoever_steps_in_is_crept_up_on() {
    let mut config = Config::default();
    config.online.safety.separation = 0.0;
    let unguarded = Learnt::new(Learnt::DEMONSTRATIONS, &config).unwrap();
    let scenario = named("steps_in");
    let stage = Stage::new(&scenario).unwrap();
    let mut pipeline = unguarded.pipeline(&stage).unwrap();
    // Measured against the distance that is to be kept.
    let outcome = Outcome::with(&scenario, learnt(), &stage, &mut pipeline);
    let missed = missed(&outcome).join("\n");
    println!("{missed}");
    for key in ["crept_m_most", "held_apart_s_least"] {
        assert!(missed.contains(key), "{key} not among\n{missed}");
    }
    let guarded = Outcome::run(&scenario, learnt()).unwrap();
    let crept = [&outcome, &guarded].map(|outcome| outcome.figures[&Figure::Crept].unwrap());
    assert!(crept[0] > 0.05 && crept[1] < 0.1 * crept[0], "{crept:?}");
}

#[test]
fn who_does_as_the_human_does_has_the_humans_figures() {
    let scenario = named("hesitation");
    let stage = Stage::new(&scenario).unwrap();
    /// The human giver of the stage, who waits with the partner.
    struct Human<'a>(&'a Stage, Option<Stamp>, Vec<Point>);
    impl Controller for Human<'_> {
        fn tick(&mut self, now: Stamp, _: Option<Sighting<'_>>, _: &[Point]) -> Reply<'_> {
            let elapsed = now - *self.1.get_or_insert(now);
            self.2 = self.0.giver(elapsed.seconds()).positions.to_vec();
            Reply { target: Some(&self.2), reason: None }
        }
    }
    let mut prompt = scenario.clone();
    prompt.robot.lag = 0.0;
    prompt.robot.speed = 10.0;
    let outcome = Outcome::with(&prompt, learnt(), &stage, &mut Human(&stage, None, Vec::new()));
    let figure = |figure: Figure| outcome.figures[&figure].unwrap();
    // The robot is where it was told to be a tick ago.
    assert!(figure(Figure::Lag).abs() < 40.0, "{}", figure(Figure::Lag));
    assert!((figure(Figure::Reach) - 1.0).abs() < 0.05, "{}", figure(Figure::Reach));
    assert!(figure(Figure::Gap) < 10.0 && figure(Figure::Bone) < 1e-6);
    assert!(figure(Figure::Rest) < 0.03 && figure(Figure::Held) == 0.0);
    assert_eq!(outcome.figures[&Figure::StandsAfter], None);
}

/// The gap error is that of the library's evaluation.
#[test]
fn the_gap_error_is_the_evaluations() {
    let scenario = named("nominal");
    let stage = Stage::new(&scenario).unwrap();
    let hands = Hands { robot: Side::Right, partner: Side::Right };
    let mean_gap = learnt().mean_gap(hands);
    let stamps: Vec<Stamp> = (0..150).map(|k| Stamp(0) + Span(k * 33_333_333)).collect();
    let truth = stage.scene().record("clip", &stamps).unwrap().truth;
    let demonstration = Demonstration::new(truth.into(), "giver", "torso").unwrap();
    let evaluated = evaluate::Scene::new(&demonstration, hands, mean_gap).unwrap();
    let giver = demonstration.robot().frames().iter();
    let predicted: Vec<Point> = giver.flat_map(|frame| frame.positions.to_vec()).collect();
    let expected = evaluated.figures(&predicted).get(Evaluated::GapAtContact).unwrap();
    let hand = stage.hand(Role::Second);
    let frame: &Frame = &demonstration.partner().frames()[evaluated.contact()];
    let robot = demonstration.robot().position(evaluated.contact(), stage.hand(Role::First));
    let found = gap_error(&Skeleton::nite(), &frame.positions, hand, robot, mean_gap);
    assert!((100.0 * found - expected).abs() < 1e-9, "{found}, {expected}");
    let sequence: &Sequence = demonstration.partner();
    assert_eq!(sequence.len(), 150);
}

/// Events happen when and where they should, and leave everything else alone.
#[test]
fn events_change_what_they_say_and_nothing_else() {
    let nominal = Stage::new(&named("nominal")).unwrap();
    let messages = |stage: &Stage| -> Vec<(Stamp, Vec<Point>)> {
        let mut feed = stage.feed();
        let ticks = (0..8000).map(|k| Stamp(0) + Span(k * 1_000_000));
        let messages = ticks.filter_map(|now| feed.receive(now));
        messages.map(|message| (message.stamp, message.positions.clone())).collect()
    };
    let usual = messages(&nominal);
    let [start, end] = nominal.scene().moments().reach[1];
    let hand = nominal.hand(Role::Second).index();

    let occluded = messages(&Stage::new(&named("occlusion")).unwrap());
    assert_eq!(occluded.len(), usual.len());
    for ((stamp, seen), (_, plain)) in occluded.iter().zip(&usual) {
        let since = stamp.seconds() - (start + 0.3 * (end - start));
        let is_hidden = (0.0..0.5).contains(&since);
        for (joint, (seen, plain)) in seen.iter().zip(plain).enumerate() {
            let lost = is_hidden && joint == hand;
            assert_eq!((seen == plain, seen.x.is_nan()), (!lost, lost), "{stamp} {joint}");
        }
    }
    let dying = Stage::new(&named("sensor_dying")).unwrap();
    let heard = messages(&dying);
    let last = heard.last().unwrap().0.seconds();
    let dies = start + 0.5 * (end - start);
    assert!(last < dies && last > dies - 0.1, "{last}, {dies}");
    assert_eq!(heard[..], usual[..heard.len()]);
    // Somebody else has a number of their own only where the sensor tells them apart.
    let bodies = |name: &str| -> Vec<u32> {
        let stage = Stage::new(&named(name)).unwrap();
        let mut feed = stage.feed();
        let ticks = (0..8000).map(|k| Stamp(0) + Span(k * 1_000_000));
        ticks.filter_map(|now| feed.receive(now)).map(|message| message.body).collect()
    };
    let others = |name: &str| bodies(name).iter().filter(|body| **body != 1).count();
    assert_eq!(others("person_swap"), 0);
    assert!((13..=15).contains(&others("another_number")), "{}", others("another_number"));
    // Who withdraws comes half-way and is back at rest in the end.
    let withdrawing = named("withdrawal");
    let stage = Stage::new(&withdrawing).unwrap();
    let hand_at = |seconds: f64| stage.partner(seconds).positions[hand];
    let planned = |seconds: f64| stage.scene().pose(Role::Second, seconds).positions[hand];
    let [start, _] = stage.scene().moments().reach[1];
    let way = (planned(stage.scene().moments().contact) - planned(start)).norm();
    let farthest = (0..800)
        .map(|k| (hand_at(f64::from(k) * 0.01) - planned(start)).norm())
        .fold(0.0, f64::max);
    assert!((farthest / way - 0.5).abs() < 0.15, "{}", farthest / way);
    assert!((hand_at(stage.end()) - planned(0.0)).norm() < 0.05);
    assert_eq!(stage.contact(), None);
    // Who hesitates arrives as much later as they stood.
    let hesitating = Stage::new(&named("hesitation")).unwrap();
    let late = hesitating.contact().unwrap() - nominal.contact().unwrap();
    assert!((late - 1.0 - TimeWarp::BLEND).abs() < 1e-6, "{late}");
}

#[test]
fn equal_runs_are_equal_to_the_byte() {
    let scenario = named("person_swap");
    let run = |learnt: &Learnt| Outcome::run(&scenario, learnt).unwrap().to_json().to_string();
    let again = Learnt::new(Learnt::DEMONSTRATIONS, &Config::default()).unwrap();
    assert_eq!(run(learnt()), run(&again));
    let stage = Stage::new(&scenario).unwrap();
    let trace = || play(&scenario, &stage, &mut learnt().pipeline(&stage).unwrap());
    let trace = [trace(), trace()];
    assert_eq!(trace[0], trace[1]);
    assert!(trace[0].holds().contains_key(&HoldReason::Jump));
}

fn command(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_handover_sim")).arg("run").args(arguments).output().unwrap()
}

fn written(name: &str, text: &str) -> String {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn the_command_says_what_was_missed_by_table_and_exit_code() {
    let path = folder().join("nominal.yaml");
    let nominal = path.to_str().unwrap();
    let runs =
        [1, 2].map(|jobs| command(&[nominal, "--json", "--quiet", &format!("--jobs={jobs}")]));
    assert_eq!(runs[0].status.code(), Some(0), "{}", String::from_utf8_lossy(&runs[0].stdout));
    assert_eq!(runs[0].stdout, runs[1].stdout);
    assert!(runs[0].stderr.is_empty());
    let json: serde_json::Value = serde_json::from_slice(&runs[0].stdout).unwrap();
    assert_eq!(json["scenarios"][0]["name"], "nominal");
    assert!(json["scenarios"][0]["figures"]["gap_cm"].as_f64().unwrap() > 0.0);
    let strict = written("strict.yaml", "about: Too much to ask.\nbounds: {gap_cm_most: 0}\n");
    let output = command(&[&strict]);
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(1), "{table}");
    assert!(table.contains("gap_cm_most") && table.contains("MISSED"), "{table}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("1 scenario, 1 bound missed"));
}

#[test]
fn bad_scenarios_are_refused_with_all_that_is_wrong() {
    let text = "scene: {seed: 5, gap: 3, colour: red, giver: {stature: tall},\n\
                \x20 step_in: {distance: 3}}\n\
                sensor: {kind: radar, rate: 1000}\n\
                events: {withdrawal: {reach: 9}, silence: {}, exchange: {number: none, seconds: 1}}\n\
                tick_hz: 50\n\
                robot: {lag_s: -1}\n\
                bounds: {gap_cm_most: 5, holds_expected: [bored]}\n";
    let error = Scenario::from_yaml("bad.yaml", "bad", text).unwrap_err().to_string();
    let expected = [
        "bad.yaml: about is missing",
        "scene.gap is 3, must be in [0.02, 0.4] m",
        "scene.giver.stature is \"tall\", must be a number",
        "scene.colour is unknown: there is only seed, giver",
        "scene.step_in.distance is 3, must be in [0.05, 0.8] m",
        "events.exchange.number is \"none\", must be one of same, other",
        "sensor.kind is \"radar\", must be one of ideal, kinect",
        "sensor.rate is 1000, must be in [5, 120] Hz",
        "events.withdrawal.reach is 9, must be a number from -2 to 4",
        "events.silence is {}, must be a map of seconds, reach",
        "tick_hz is 50, must be one of 30, 100, 1000",
        "robot.lag_s is -1, must be a number from 0 to 1",
        "bounds.gap_cm_most cannot hold: who withdraws makes no contact",
        "bounds.holds_expected is [\"bored\"], must be a list, each one of no_robot",
    ];
    for line in expected {
        assert!(error.contains(line), "{line}\n\nin\n{error}");
    }
    assert_eq!(error.lines().count(), expected.len(), "{error}");
    let both = "about: x\nevents: {withdrawal: {reach: 0.5}, hesitation: {pause_s: 1}}\n";
    let error = Scenario::from_yaml("both.yaml", "both", both).unwrap_err().to_string();
    assert!(error.contains("cannot be together") && error.contains("cannot fail"), "{error}");
    assert!(Scenario::from_yaml("no.yaml", "no", "a: [").is_err());

    let (bad, worse) = (written("bad.yaml", text), written("worse.yaml", both));
    let output = command(&[&bad, &worse]);
    assert_eq!(output.status.code(), Some(2));
    let talk = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(talk.contains("bad.yaml: tick_hz") && talk.contains("worse.yaml: bounds"), "{talk}");
    assert!(output.stdout.is_empty());
    assert_eq!(command(&["nowhere.yaml"]).status.code(), Some(2));
    assert_eq!(command(&[]).status.code(), Some(2));
}
