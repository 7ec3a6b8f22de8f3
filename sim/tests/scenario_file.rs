//! Scenario files: docs/scenario.md has every key with its true default and range, every figure and
//! every reason to hold, and an example that runs.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use handover_mesh::Config;
use handover_mesh::safety::HoldReason;
use handover_sim::closed_loop::{Learnt, Outcome};
use handover_sim::scenario::{Figure, Scenario};
use serde_json::{Map, Value, json};

const DOC: &str = include_str!("../../docs/scenario.md");

/// The rows of the table whose head begins with `head`, as trimmed cells.
fn rows(head: &str) -> Vec<Vec<&'static str>> {
    let lines = DOC.lines().skip_while(|line| !line.starts_with(&format!("| {head} |")));
    let rows = lines.skip(2).take_while(|line| line.starts_with('|'));
    rows.map(|row| row.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

/// What stands in the first cell of each row.
fn named(head: &str) -> Vec<&'static str> {
    rows(head).iter().map(|row| row[0].trim_matches('`')).collect()
}

/// Both hold the same names, none twice.
#[track_caller]
fn check_names(written: &[&str], there: impl IntoIterator<Item = String>) {
    let names: BTreeSet<String> = written.iter().map(|name| (*name).to_owned()).collect();
    assert_eq!(names, there.into_iter().collect());
    assert_eq!(names.len(), written.len());
}

#[test]
fn every_key_figure_and_reason_has_its_line() {
    let bounds = Figure::ALL
        .iter()
        .flat_map(|figure| ["most", "least"].map(|end| format!("bounds.{}_{end}", figure.key())));
    let bounds: BTreeSet<String> = bounds.collect();
    let keys = Scenario::keys();
    assert!(bounds.iter().all(|bound| keys.contains(bound)));
    let keys = keys.into_iter().filter(|key| !bounds.contains(key));
    let patterns = ["bounds.FIGURE_most", "bounds.FIGURE_least"].map(str::to_owned);
    check_names(&named("key"), keys.chain(patterns));
    check_names(&named("figure"), Figure::ALL.iter().map(|figure| figure.key().to_owned()));
    check_names(&named("reason"), HoldReason::ALL.iter().map(|reason| reason.name().to_owned()));
}

/// A scenario with one key given, and what else its section needs.
fn with(key: &str, value: Option<Value>) -> Value {
    let mut file = json!({"about": "x", "bounds": {"held_share_most": 1}});
    let mut set = |key: &str, value: Value| {
        let (sections, name) = key.rsplit_once('.').unwrap_or(("", key));
        let sections = sections.split('.').filter(|section| !section.is_empty());
        let section = sections.fold(&mut file, |map, section| {
            let map = map.as_object_mut().unwrap();
            map.entry(section).or_insert_with(|| Value::Object(Map::new()))
        });
        section[name] = value;
    };
    let section = key.rsplit_once('.').map_or("", |(section, _)| section);
    match section {
        "scene.step_in" if key.ends_with("stay") => set("scene.step_in.distance", json!(0.4)),
        "scene.step_in" => set("scene.step_in.stay", json!(1)),
        "events.hesitation" => set("events.hesitation.pause_s", json!(1)),
        "events.withdrawal" => set("events.withdrawal.reach", json!(0.5)),
        section if section.starts_with("events.") => set(&format!("{section}.seconds"), json!(1)),
        _ => {}
    }
    if let Some(value) = value {
        set(key, value);
    }
    file
}

fn read(file: &Value) -> Result<Scenario, String> {
    Scenario::from_yaml("x.yaml", "x", &file.to_string()).map_err(|error| error.to_string())
}

/// `-0.5`, `π`, `2π`.
fn number(text: &str) -> Option<f64> {
    match text {
        "2π" => Some(2.0 * PI),
        "π" => Some(PI),
        "-π" => Some(-PI),
        text => text.parse().ok(),
    }
}

#[test]
fn ranges_and_defaults_are_as_written() {
    let (mut ranges, mut defaults) = (0, 0);
    for row in rows("key") {
        let [key, default, range] = [0, 1, 2].map(|at| row[at].trim_matches('`'));
        if key.contains("FIGURE") {
            continue;
        }
        if let Some((low, high)) = range.split_once(" to ") {
            ranges += 1;
            let [low, high] = [low, high].map(|bound| number(bound).unwrap());
            for (value, is_in) in
                [(low, true), (high, true), (low - 0.01, false), (high + 0.01, false)]
            {
                let problem = read(&with(key, Some(json!(value)))).err().unwrap_or_default();
                let blamed = format!("x.yaml: {key} is ");
                assert_eq!(!problem.contains(&blamed), is_in, "{key}: {value}: {problem}");
            }
        }
        let default = default.trim_end_matches("\\*");
        let is_choice = range.split(", ").any(|choice| choice == default);
        let value = match number(default) {
            Some(number) => json!(number),
            None if is_choice => json!(default),
            None => continue,
        };
        // Rates are whole numbers.
        let value = if key == "tick_hz" { json!(30) } else { value };
        defaults += 1;
        let [given, left_out] = [Some(value), None].map(|value| read(&with(key, value)).unwrap());
        assert_eq!(given, left_out, "{key}");
    }
    assert!(ranges > 50 && defaults > 50, "{ranges} ranges, {defaults} defaults");
}

#[test]
fn the_example_is_complete_and_runs() {
    let from = DOC.find("```yaml\n").unwrap() + "```yaml\n".len();
    let text = &DOC[from..][..DOC[from..].find("```").unwrap()];
    let scenario = Scenario::from_yaml("example.yaml", "example", text).unwrap();
    let learnt = Learnt::new(Learnt::DEMONSTRATIONS, &Config::default()).unwrap();
    let outcome = Outcome::run(&scenario, &learnt).unwrap();
    assert!(outcome.is_held(), "{:#?}", outcome.verdicts);
}

fn command(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_handover_sim")).args(arguments).output().unwrap()
}

#[test]
fn the_help_names_the_doc() {
    let help = command(&["run", "--help"]);
    assert!(String::from_utf8_lossy(&help.stdout).contains("docs/scenario.md"));
}

/// What is wrong with a scenario beside a bound and what it is about, a line each.
#[track_caller]
fn check_problems(text: &str, expected: &[&str]) {
    let text = format!("about: x\nbounds: {{held_share_most: 1}}\n{text}");
    check_all_problems(&text, expected);
}

#[track_caller]
fn check_all_problems(text: &str, expected: &[&str]) {
    let error = Scenario::from_yaml("x.yaml", "x", text).unwrap_err().to_string();
    let lines: Vec<&str> = error.lines().collect();
    let expected: Vec<String> = expected.iter().map(|line| format!("x.yaml: {line}")).collect();
    assert_eq!(lines, expected);
}

#[test]
fn what_is_unknown_is_named_once_with_what_there_is_beside_it() {
    check_problems(
        "events: {oclusion: {reach: 0.2, seconds: 1}}",
        &[
            "events.oclusion is unknown: there is only hesitation, withdrawal, occlusion, exchange, \
           silence",
        ],
    );
    let occlusion = "events: {occlusion: {seconds: 1, rech: 0.2}}";
    check_problems(occlusion, &["events.occlusion.rech is unknown: there is only seconds, reach"]);
    let top =
        "is unknown: there is only about, scene, robot, sensor, events, tick_hz, after_s, bounds";
    let lines = ["event", "tick"].map(|key| format!("{key} {top}"));
    check_problems(
        "event: {occlusion: {reach: 1}}\ntick: 3",
        &lines.each_ref().map(|l| l.as_str()),
    );
}

#[test]
fn a_wrong_type_is_told_once_with_what_it_must_be() {
    check_problems(
        "scene: {meeting_shift: 0.1}",
        &["scene.meeting_shift is 0.1, must be a map of x, y, z"],
    );
    check_problems(
        "scene: 7",
        &["scene is 7, must be a map of seed, giver, receiver, distance, gap, suit_receiver, \
         meeting_shift, timing, step_in, heading"],
    );
    check_problems(
        "events: {occlusion: {}, silence: }",
        &[
            "events.occlusion is {}, must be a map of seconds, reach",
            "events.silence is null, must be a map of seconds, reach",
        ],
    );
    check_problems(
        "tick_hz: {a: 1, b: 2}",
        &["tick_hz is {\"a\":1,\"b\":2}, must be one of 30, 100, 1000"],
    );
    check_problems(
        "robot: {stature: [1, 2]}",
        &["robot.stature is [1,2], must be a number from 1.2 to 2.2"],
    );
    check_all_problems(
        "about: 5\nbounds: {gap_cm_most: high, gap_cm_best: 3}",
        &[
            "about is 5, must be text",
            "bounds.gap_cm_most is \"high\", must be a number from -1000000 to 1000000",
            &format!("bounds.gap_cm_best is unknown: there is only {}", bounds().join(", ")),
        ],
    );
    check_all_problems(
        "about: {a: b}\nbounds: 7",
        &[
            "about is {\"a\":\"b\"}, must be text",
            &format!("bounds is 7, must be a map of {}", bounds().join(", ")),
        ],
    );
    check_all_problems("about: x", &["bounds are missing: a trial that cannot fail shows nothing"]);
    for text in ["", "# nothing\n", "{}"] {
        check_all_problems(text, &["is empty: about and bounds are needed"]);
    }
    for text in ["7", "[about, bounds]"] {
        check_all_problems(text, &["must be a map of keys and values, such as about: and bounds:"]);
    }
}

/// All names below `bounds`.
fn bounds() -> Vec<String> {
    let keys = Scenario::keys().into_iter();
    keys.filter_map(|key| key.strip_prefix("bounds.").map(str::to_owned)).collect()
}

#[test]
fn an_event_has_to_say_how_long_it_lasts() {
    let events = "events: {hesitation: {reach: 0.3}, occlusion: {reach: 0.3}, silence: {reach: 0.3},\n\
                  \x20 exchange: {aside_m: 2}}";
    let needed = "is missing, must be a number from 0 to";
    check_problems(
        events,
        &[
            &format!("events.hesitation.pause_s {needed} 10"),
            &format!("events.occlusion.seconds {needed} 100, or for_good"),
            &format!("events.exchange.seconds {needed} 100, or for_good"),
            &format!("events.silence.seconds {needed} 100, or for_good"),
        ],
    );
    check_problems(
        "events: {occlusion: {seconds: long}}",
        &["events.occlusion.seconds is \"long\", must be a number from 0 to 100, or for_good"],
    );
    let mut file = with("events.silence.reach", None);
    file["events"]["silence"]["seconds"] = json!("for_good");
    assert_eq!(read(&file).unwrap().events.silence.unwrap().seconds, f64::INFINITY);
}

#[test]
fn what_yaml_allows_and_a_scenario_does_not_is_told_with_its_line_or_key() {
    check_all_problems("about: x\nscene: {seed: 5}\nabout: y\n", &["line 3: about is given twice"]);
    check_all_problems(
        "about: x\nscene:\n  gap: 0.1\n  seed: 5\n  gap: 0.2\n",
        &["line 5: gap is given twice"],
    );
    check_all_problems(
        "about: x\n---\nabout: y\n",
        &["line 3: a second document begins; a file holds one scenario"],
    );
    check_problems(
        "scene: {gap: .nan}\nafter_s: .inf\nrobot: {lag_s: 1e999}",
        &[
            "scene.gap is \".nan\", must be a number",
            "robot.lag_s is \".inf\", must be a number from 0 to 1",
            "after_s is \".inf\", must be a number from 0 to 10",
        ],
    );
}

#[test]
fn the_table_has_a_head_and_marks_every_bound() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("marks.yaml");
    let text = "about: Two bounds.\nbounds: {held_share_most: 1, speed_m_s_most: 0}\n";
    fs::write(&path, text).unwrap();
    let run = command(&["run", path.to_str().unwrap(), "--demonstrations=2"]);
    let table = String::from_utf8_lossy(&run.stdout).into_owned();
    let rows: Vec<Vec<&str>> = table.lines().map(|row| row.split_whitespace().collect()).collect();
    assert_eq!(rows[0].join(" "), "marks: Two bounds.");
    assert_eq!(rows[1], ["figure", "value", "bound"]);
    let marks = [2, 3].map(|row: usize| [rows[row][0], rows[row][2], rows[row][3]]);
    assert_eq!(marks, [["held_share_most", "1.000", "ok"], ["speed_m_s_most", "0.000", "MISSED"]]);
    // What is not bounded has a value alone.
    assert!(rows.len() > 10 && rows[4..].iter().all(|row| row.len() == 2), "{table}");
    assert_eq!(String::from_utf8_lossy(&run.stderr), "1 scenario, 1 bound missed\n");
}
