//! The real process and folders for it: what the tests of the command line share.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

fn handover(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_handover"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Runs, and checks the exit code and that stdout and stderr hold these words.
#[track_caller]
pub(crate) fn check(folder: &TempDir, arguments: &[&str], code: i32, words: &[&str]) -> Output {
    let output = handover(arguments, folder.path());
    let said = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    for word in words {
        assert!(said.contains(word), "no '{word}' in: {said}");
    }
    output
}

/// Runs, checks the exit code, and reads stdout as one JSON value.
#[track_caller]
pub(crate) fn check_json(folder: &TempDir, arguments: &[&str], code: i32) -> Value {
    let output = check(folder, arguments, code, &[]);
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A folder of files, each `path` with `text`.
pub(crate) fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (path, text) in files {
        let path = folder.path().join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    folder
}
