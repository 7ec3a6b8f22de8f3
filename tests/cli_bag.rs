//! Bags on the command line: the real process imports, checks, learns from and replays them like
//! any recording, and says what a damaged one lacks.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

#[path = "common/clips.rs"]
mod clips;
mod common;
#[path = "common/sqlite.rs"]
mod sqlite;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use clips::{FIGURES, FRAMES, METHODS, clips, keys};
use common::{check, check_json};
use handover_mesh::bodies::{Body, to_joint_state};
use handover_mesh::formats::bag::{self, Writer};
use handover_mesh::formats::{UpAxis, csv};
use handover_mesh::messages::{
    Message, MultiDofJointState, MultiDofPoint, MultiDofTrajectory, encode,
};
use handover_mesh::{Recording, Role, Span};
use tempfile::TempDir;

/// The least that has everything.
const SETTINGS: [&str; 8] = [
    "--set",
    "learn.references=1",
    "--set",
    "learn.tolerance=0",
    "--set",
    "learn.steps=1",
    "--set",
    "track.dimensions=4",
];

fn path(folder: &TempDir, name: &str) -> PathBuf {
    folder.path().join(name)
}

fn bytes(folder: &TempDir, name: &str) -> Vec<u8> {
    fs::read(path(folder, name)).unwrap()
}

fn learn(folder: &TempDir, demonstrations: &str, model: &str) {
    let learn = ["learn", demonstrations, "-o", model, "--method", "none"];
    check(folder, &[&learn[..], &SETTINGS].concat(), 0, &[]);
}

/// One recording in every format, all called `new`.
fn every_format(folder: &TempDir, source: &Path) -> [&'static str; 4] {
    let names = ["csv/new.csv", "mcap/new.mcap", "bag/new.bag", "sqlite/new.db3"];
    for name in names {
        fs::create_dir_all(path(folder, name).parent().unwrap()).unwrap();
    }
    for name in &names[..3] {
        check(folder, &["import", source.to_str().unwrap(), name], 0, &["1 written"]);
    }
    let recording = csv::read(&bytes(folder, names[0]), "new", UpAxis::Z).unwrap();
    let written = bag::write(&recording, "new_0.mcap").unwrap();
    assert_eq!(bytes(folder, "bag/new.bag/new_0.mcap"), written.mcap, "as the library writes it");
    sqlite::sqlite_of(&written.mcap, &written.metadata, &path(folder, names[3]));
    names
}

#[test]
fn a_recording_leaves_the_same_trace_in_every_format() {
    let folder = clips(4);
    fs::rename(path(&folder, "clips/3.csv"), path(&folder, "one.csv")).unwrap();
    learn(&folder, "clips", "m.safetensors");
    let names = every_format(&folder, &path(&folder, "one.csv"));
    check_traces(&folder, "m.safetensors", &names);
}

#[track_caller]
fn check_traces(folder: &TempDir, model: &str, names: &[&str]) {
    let traces = names.iter().enumerate().map(|(at, name)| {
        let trace = format!("{at}.jsonl");
        check(folder, &["replay", model, name, "-o", &trace], 0, &[]);
        bytes(folder, &trace)
    });
    let traces: Vec<Vec<u8>> = traces.collect();
    assert!(traces[0].len() > 10_000);
    for (trace, name) in traces.iter().zip(names) {
        assert!(trace == &traces[0], "{name}: another trace than {}", names[0]);
    }
}

/// Real people, where there are some: `HANDOVER_DATA`, or `../shared/data`.
#[test]
fn real_people_leave_the_same_trace_in_every_format() {
    let named = std::env::var_os("HANDOVER_DATA").map(PathBuf::from);
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let data = named.unwrap_or_else(beside).join("dyn_handover/csv15");
    let Ok(entries) = fs::read_dir(&data) else {
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), "SKIPPED: real people in bags: no {}", data.display());
        return;
    };
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|ending| ending == "csv"));
    files.sort();
    let folder = clips(0);
    fs::create_dir_all(path(&folder, "real")).unwrap();
    for file in &files[1..4] {
        let name = format!("real/{}", file.file_name().unwrap().to_str().unwrap());
        fs::copy(file, path(&folder, &name)).unwrap();
    }
    learn(&folder, "real", "real.safetensors");
    let names = every_format(&folder, &files[0]);
    check_traces(&folder, "real.safetensors", &names);
}

#[test]
fn a_bags_folder_is_one_recording_and_goes_wherever_a_csv_goes() {
    let folder = clips(4);
    fs::create_dir_all(path(&folder, "bags")).unwrap();
    for (number, ending) in ["bag", "mcap", "mcap", "bag"].iter().enumerate() {
        let [from, to] = [format!("clips/{number}.csv"), format!("bags/{number}.{ending}")];
        check(&folder, &["import", &from, &to], 0, &["1 written, 0 left out"]);
    }
    let found = check_json(&folder, &["check", "bags", "--json"], 0);
    let files = found["files"].as_array().unwrap();
    let names: Vec<&str> = files.iter().map(|file| file["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["0", "1", "2", "3"]);
    assert!(files.iter().all(|file| file["format"] == "MCAP bag" && file["frames"] == FRAMES));
    // Metadata come along, and choose.
    assert_eq!(files[0]["metadata"]["pair"], "first");
    let words = ["bags/0.bag: MCAP bag, giver (9 joints) and receiver (9 joints), 24 frames"];
    check(&folder, &["check", "bags/0.bag"], 0, &words);
    // What was learned of bags is what was learned of CSVs, but for the files' hashes.
    let evaluate = |from: &str| {
        let methods = METHODS[..3].join(",");
        let command = ["evaluate", from, "--protocol", "leave_one_out", "--methods", &methods];
        check(&folder, &[&command[..], &["--json", "--group", "pair"]].concat(), 0, &[]).stdout
    };
    assert_eq!(evaluate("bags"), evaluate("clips"));
    learn(&folder, "bags", "m.safetensors");
    let back = ["import", "bags", "back"];
    check(&folder, &back, 0, &["4 written"]);
    for number in 0..4 {
        let [a, b] = [format!("clips/{number}.csv"), format!("back/{number}.csv")];
        assert_eq!(bytes(&folder, &a), bytes(&folder, &b));
    }
}

#[test]
fn no_folder_and_no_file_is_written_over() {
    let folder = clips(1);
    check(&folder, &["import", "clips/0.csv", "a.bag"], 0, &[]);
    let before = bytes(&folder, "a.bag/metadata.yaml");
    check(&folder, &["import", "clips/0.csv", "a.bag"], 2, &["a.bag exists"]);
    check(&folder, &["import", "clips/0.csv", "clips/"], 2, &["clips/ exists"]);
    assert_eq!(bytes(&folder, "a.bag/metadata.yaml"), before);
    check(&folder, &["import", "clips/0.csv", "b/"], 0, &["b/"]);
    assert!(path(&folder, "b/b_0.mcap").is_file());
    let left: Vec<_> =
        fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 3, "{left:?}");
}

#[test]
fn a_damaged_bag_gives_what_is_whole_and_exit_code_3() {
    let folder = clips(2);
    fs::create_dir_all(path(&folder, "bags")).unwrap();
    check(&folder, &["import", "clips/0.csv", "bags/0.mcap"], 0, &[]);
    // Many chunks, of which the last are lost.
    long_bag(&path(&folder, "bags/1.mcap"));
    let whole = bytes(&folder, "bags/1.mcap");
    fs::write(path(&folder, "bags/1.mcap"), &whole[..whole.len() / 2]).unwrap();
    let words = ["lost: bags/1.mcap: 1.mcap is cut off: behind byte "];
    check(&folder, &["check", "bags/1.mcap"], 3, &words);
    check(&folder, &["import", "bags/1.mcap", "1.csv"], 3, &words);
    check(&folder, &["check", "1.csv"], 0, &[]);
    let found = check_json(&folder, &["import", "bags", "out", "--json"], 3);
    assert_eq!(found["written"].as_array().unwrap().len(), 2);
    assert_eq!(found["lost"][0]["file"], "bags/1.mcap");
    let found = check_json(&folder, &["check", "bags", "--json"], 3);
    assert_eq!(found["files"][0]["losses"].as_array().unwrap().len(), 0);
    assert_eq!(found["files"][1]["losses"].as_array().unwrap().len(), 1);
    let command = ["evaluate", "bags", "--protocol", "leave_one_out", "--methods", "hold"];
    check(&folder, &command, 3, &words);
    // Nothing whole is an error, as is garbage.
    fs::write(path(&folder, "none.mcap"), &whole[..60]).unwrap();
    check(&folder, &["check", "none.mcap"], 1, &["none.mcap: BAD\n  no bag: none.mcap is cut off"]);
    fs::remove_file(path(&folder, "bags/0.mcap")).unwrap();
    check(&folder, &["import", "clips/1.csv", "gone.bag"], 0, &[]);
    fs::remove_file(path(&folder, "gone.bag/gone_0.mcap")).unwrap();
    check(&folder, &["check", "gone.bag"], 1, &["no bag: gone_0.mcap: there is no such file"]);
}

/// A minute of a clip, over and over.
fn long_bag(path: &Path) {
    let folder = clips(1);
    let clip = csv::read(&bytes(&folder, "clips/0.csv"), "0", UpAxis::Z).unwrap();
    let people = clip.people().each_ref().map(|person| {
        let frames = (0..1800_usize).map(|k| {
            let mut frame = person.motion.frames()[k % clip.len()].clone();
            frame.stamp = handover_mesh::Stamp(k as i64 * 33_333_333);
            // Nobody stands as still as a repeated clip does: chunks should not shrink to nothing.
            frame.positions.iter_mut().enumerate().for_each(|(joint, p)| {
                p.x += 1e-3 * ((k * 7919 + joint * 104_729) as f64).sin();
            });
            frame
        });
        let skeleton = person.motion.skeleton().clone();
        let motion = handover_mesh::Sequence::new(skeleton, frames.collect()).unwrap();
        handover_mesh::Person { name: person.name.clone(), motion }
    });
    let long = Recording::new("long", people, None, BTreeMap::new()).unwrap();
    fs::write(path, bag::write(&long, "1.mcap").unwrap().mcap).unwrap();
}

/// What a robot would have recorded: the partner's skeleton, and its own targets between the frames.
fn live_bag(clip: &Recording, robot: Role, path: &Path) {
    let mut live = Writer::new("live_0.mcap", BTreeMap::new()).unwrap();
    let skeleton = live.topic("/skeleton", MultiDofJointState::TYPE, false).unwrap();
    let targets = live.topic("/handover/joint_targets", MultiDofTrajectory::TYPE, false).unwrap();
    for number in 0..clip.len() {
        let body = |role: Role| {
            let motion = &clip.person(role).motion;
            let frame = &motion.frames()[number];
            let joints = motion.skeleton().names().iter().cloned();
            let joints = joints.zip(frame.positions.iter().copied()).collect();
            Body { stamp: frame.stamp, frame: "world".to_owned(), id: None, joints }
        };
        let (seen, robot) = (body(robot.partner()), body(robot));
        let stamp = seen.stamp;
        live.message(skeleton, stamp, &encode(&to_joint_state(&seen))).unwrap();
        let mut state = to_joint_state(&robot);
        // Ticks are at other instants than sightings.
        let tick = stamp + Span(if number == 0 { 0 } else { 1_000_000 });
        state.header.stamp = handover_mesh::messages::Time::of(tick);
        let point = MultiDofPoint { transforms: state.transforms, ..Default::default() };
        let target = MultiDofTrajectory {
            header: state.header,
            joint_names: state.joint_names,
            points: vec![point],
        };
        live.message(targets, tick, &encode(&target)).unwrap();
    }
    fs::write(path, live.finish().unwrap().mcap).unwrap();
}

#[test]
fn of_a_live_bag_the_robot_plays_its_role_again() {
    let folder = clips(4);
    let clip = csv::read(&bytes(&folder, "clips/3.csv"), "3", UpAxis::Z).unwrap();
    fs::remove_file(path(&folder, "clips/3.csv")).unwrap();
    live_bag(&clip, Role::First, &path(&folder, "live.mcap"));
    let words = ["partner (9 joints) and robot (9 joints), 24 frames", "interpolated: robot at 23"];
    check(&folder, &["check", "live.mcap"], 0, &words);
    learn(&folder, "clips", "m.safetensors");
    let found = check_json(&folder, &["replay", "m.safetensors", "live.mcap", "--json"], 0);
    assert_eq!((&found["role"], &found["frames"]), (&"giver".into(), &24.into()));
    assert_eq!(keys(&found).len(), FIGURES.len() + 9);
    let words = ["recorded live, the robot is taken for the giver"];
    check(&folder, &["replay", "clips", "live.mcap", "--method", "none"], 0, &words);
    check(&folder, &["replay", "m.safetensors", "live.mcap", "-o", "r.mcap"], 0, &[]);
    check(&folder, &["check", "r.mcap"], 0, &["giver (9 joints) and receiver (9 joints)"]);
}

#[test]
fn violations_of_bags_say_message_and_topic() {
    let folder = clips(1);
    let clip = csv::read(&bytes(&folder, "clips/0.csv"), "0", UpAxis::Z).unwrap();
    let mut bag = Writer::new("a_0.mcap", BTreeMap::new()).unwrap();
    for person in clip.people() {
        let name = format!("/{}/skeleton", person.name);
        let topic = bag.topic(&name, MultiDofJointState::TYPE, false).unwrap();
        for (number, frame) in person.motion.frames().iter().enumerate() {
            let joints = person.motion.skeleton().names().iter().cloned();
            let joints = joints.zip(frame.positions.iter().copied()).collect();
            let (stamp, frame) = (frame.stamp, "world".to_owned());
            let mut data = encode(&to_joint_state(&Body { stamp, frame, id: None, joints }));
            if number == 16 {
                data.truncate(99);
            }
            bag.message(topic, stamp, &data).unwrap();
        }
    }
    fs::write(path(&folder, "a.mcap"), bag.finish().unwrap().mcap).unwrap();
    let words =
        ["a.mcap: BAD\n  message 17 of /giver/skeleton: sensor_msgs/msg/MultiDOFJointState"];
    check(&folder, &["check", "a.mcap"], 1, &words);
    let found = check_json(&folder, &["check", "a.mcap", "--json"], 1);
    let error = &found["files"][0]["errors"][0];
    assert_eq!(error["line"], serde_json::Value::Null);
    assert_eq!((&error["message"], &error["topic"]), (&17.into(), &"/giver/skeleton".into()));
}

#[test]
fn a_folder_with_metadata_of_something_else_is_searched() {
    let folder = clips(1);
    fs::write(path(&folder, "clips/metadata.yaml"), "camera: 3\n").unwrap();
    check(&folder, &["import", "clips/0.csv", "0.mcap"], 0, &[]);
    let whole = bytes(&folder, "0.mcap");
    let packed = path(&folder, "clips/1.mcap.zstd");
    fs::write(packed, zstd::encode_all(&whole[..], 1).unwrap()).unwrap();
    let words = ["clips/0.csv: CSV, giver", "clips/1.mcap.zstd: MCAP bag, giver"];
    check(&folder, &["check", "clips"], 0, &words);
    // What names no file of its folder is no bag.
    let text = "rosbag2_bagfile_information:\n  relative_file_paths: [../0.mcap]\n";
    fs::write(path(&folder, "clips/metadata.yaml"), text).unwrap();
    let words =
        ["clips: BAD\n  no bag: metadata.yaml names '../0.mcap', which is not in the folder"];
    check(&folder, &["check", "clips"], 1, &words);
}
