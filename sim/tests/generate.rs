//! The real process: equal seeds give equal bytes, folders are respected, exit codes hold.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic as tests do")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use handover_mesh::formats::{UpAxis, csv};
use handover_mesh::{Recording, Role};
use handover_sim::generate;
use handover_sim::sensor::{Sensor, SensorConfig};

/// A folder of this test's own, empty, under the build folder.
fn scratch(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&path);
    path
}

fn run(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_handover_sim"))
        .arg("generate")
        .args(arguments.split_whitespace())
        .arg("-o")
        .arg(folder)
        .output()
        .unwrap()
}

#[track_caller]
fn check(folder: &Path, arguments: &str, code: i32) -> Output {
    let output = run(folder, arguments);
    let talk = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments}: {talk}");
    output
}

/// All files under a folder by relative path.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder_now) = open.pop() {
        for entry in fs::read_dir(folder_now).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_owned();
                found.insert(name, fs::read(path).unwrap());
            }
        }
    }
    found
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let [one, two, other] = ["same_one", "same_two", "same_other"].map(scratch);
    check(&one, "--count 6 --seed 3 --jobs 1 --quiet", 0);
    check(&two, "--count 6 --seed 3 --jobs 4 --quiet", 0);
    check(&other, "--count 6 --seed 4 --jobs 2 --quiet", 0);
    assert_eq!(files(&one).len(), 13);
    assert!(files(&one) == files(&two), "two runs differ");
    assert!(files(&one) != files(&other), "the seed says nothing");
}

#[test]
fn truth_and_measurement_lie_side_by_side() {
    let folder = scratch("pair");
    let output = check(&folder, "--count 3 --seed 1 --noise none --rate 15 --json", 0);
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["count"], 3);
    let files = files(&folder);
    for (index, stem) in ["handover_000", "handover_001", "handover_002"].into_iter().enumerate() {
        let [measured, truth] =
            ["measured", "truth"].map(|part| &files[&PathBuf::from(format!("{part}/{stem}.csv"))]);
        assert_eq!(measured, truth);
        let text = std::str::from_utf8(truth).unwrap();
        // Both name their scene: neither may be learnt from the other.
        let head =
            format!("# class=handover\n# scene=1/{index}\nframe,time_s,person,joint,x,y,z\n");
        let rows: Vec<&str> = text.strip_prefix(&head).unwrap().lines().collect();
        assert_eq!(rows.len() % 31, 0);
        assert!(rows[0].starts_with("0,0,giver,head,"));
        assert!(rows[15].starts_with("0,0,receiver,head,"));
        assert!(rows[30].starts_with("0,0,object,object,"));
        assert!(rows[31].starts_with("1,0.066666667,giver,head,"));
    }
    let manifest: serde_json::Value =
        serde_json::from_slice(&files[Path::new("manifest.json")]).unwrap();
    let clip = &manifest["clips"][1];
    assert_eq!(clip["name"], "handover_001");
    let gap = clip["contact_gap"].as_f64().unwrap();
    assert!((0.1..0.15).contains(&gap));
    assert_eq!(manifest["noise"], "none");
}

#[test]
fn with_noise_the_measurement_has_fewer_frames_at_the_same_stamps() {
    let folder = scratch("noisy");
    let output = check(&folder, "--count 5 --seed 2 --json --quiet", 0);
    assert!(output.stderr.is_empty());
    let files = files(&folder);
    let stamps = |part: &str, stem: &str| -> BTreeSet<String> {
        let text = String::from_utf8(files[&PathBuf::from(format!("{part}/{stem}.csv"))].clone());
        let stamp = |line: &str| line.split(',').nth(1).unwrap().to_owned();
        text.unwrap().lines().skip(2).map(stamp).collect()
    };
    let mut lost = 0;
    for index in 0..5 {
        let stem = format!("handover_{index:03}");
        let [measured, truth] = ["measured", "truth"].map(|part| stamps(part, &stem));
        assert!(measured.is_subset(&truth));
        lost += truth.len() - measured.len();
    }
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["lost_frames"], lost);
    assert!(lost > 0);
}

#[test]
fn folders_of_others_are_respected() {
    let folder = scratch("others");
    fs::create_dir_all(folder.join("truth")).unwrap();
    fs::write(folder.join("truth/handover_notes.csv"), "mine").unwrap();
    let refused = check(&folder, "--count 2", 1);
    assert!(String::from_utf8_lossy(&refused.stderr).contains("hint: --force"));
    check(&folder, "--count 4 --force --quiet", 0);
    check(&folder, "--count 2 --force --quiet", 0);
    let names: Vec<String> = files(&folder).keys().map(|p| p.display().to_string()).collect();
    let clips = ["handover_000.csv", "handover_001.csv"];
    let mut expected: Vec<String> = ["measured", "truth"]
        .iter()
        .flat_map(|part| clips.map(|clip| format!("{part}/{clip}")))
        .chain(["manifest.json".into(), "truth/handover_notes.csv".into()])
        .collect();
    expected.sort();
    assert_eq!(names.iter().collect::<BTreeSet<_>>(), expected.iter().collect());
    let file = scratch("a_file");
    fs::write(&file, "no folder").unwrap();
    check(&file, "--count 1 --force", 1);
}

#[test]
fn bad_arguments_are_usage_errors() {
    let folder = scratch("usage");
    for arguments in [
        "",
        "--count 0",
        "--count x",
        "--count 1 --rate 1000",
        "--count 1 --noise lidar",
        "--count 1 --seed -1",
        "--count 1 --jobs 0",
        "--count 1 --jobs 1025",
    ] {
        check(&folder, arguments, 2);
    }
    assert!(!folder.exists());
}

#[test]
fn every_recording_passes_the_checked_constructors() {
    for config in [SensorConfig::kinect(30.0), SensorConfig::kinect(15.0)] {
        let sensor = Sensor::new(config).unwrap();
        let mut right = 0;
        for index in 0..150 {
            let clip = generate(9, index, "clip", &sensor).unwrap();
            for recording in [&clip.truth, &clip.view.measured] {
                let again = Recording::new(
                    "again",
                    recording.people().clone(),
                    recording.object().cloned(),
                    recording.metadata().clone(),
                );
                assert!(again.is_ok(), "{index}: {again:?}");
                let text = csv::write_rounded(recording).unwrap();
                let read = csv::read(text.as_bytes(), "again", UpAxis::Z).unwrap();
                assert_eq!(csv::write(&read).unwrap(), text, "rounded once, rounded for good");
            }
            let config = clip.scene.config();
            let [giver, receiver] = [Role::First, Role::Second].map(|role| config.person(role));
            right += usize::from(giver.hand == receiver.hand);
            assert!([giver, receiver].iter().all(|p| (1.5..=1.95).contains(&p.stature)));
            assert!((0.9..=1.3).contains(&config.distance));
        }
        assert!(right > 110, "{right} of 150 with hands of the same side");
    }
}
