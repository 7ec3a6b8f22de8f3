//! Python as a peer that has nothing of ours; included by path.
//!
//! Needs `python3` (or what `HANDOVER_PYTHON` names) with the packages of `requirements.txt`, as
//! `.ci/run` makes it. Without them the tests say so and pass, unless `CI` is `true`.

use std::path::Path;
use std::process::Command;

/// An interpreter that has the packages; none, loudly, where there is none.
///
/// - `packages`: as `import` takes them.
/// - `what`: is skipped without them.
pub(crate) fn python(packages: &str, what: &str) -> Option<String> {
    let named = std::env::var("HANDOVER_PYTHON").ok().filter(|name| !name.is_empty());
    let mut python = named.unwrap_or_else(|| "python3".to_owned());
    // The scripts run elsewhere. A link stays one: that is how Python knows its packages.
    if python.contains('/') {
        python = std::path::absolute(python).unwrap().to_str().unwrap().to_owned();
    }
    let found = Command::new(&python).args(["-c", &format!("import {packages}")]).output();
    if found.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    let missing = format!(
        "no Python with {packages} ({python}); .ci/run makes one, HANDOVER_PYTHON names another"
    );
    let in_ci = std::env::var("CI").is_ok_and(|value| value == "true");
    assert!(!in_ci, "{missing}");
    say(&format!("SKIPPED: {what} in Python: {missing}"));
    None
}

/// On the real stderr: what a passing test prints is otherwise kept from the reader.
fn say(text: &str) {
    use std::io::Write as _;
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Runs a script in a folder; what it prints.
#[track_caller]
pub(crate) fn run(python: &str, script: &str, folder: &Path) -> String {
    let output = Command::new(python).args(["-c", script]).current_dir(folder).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    String::from_utf8(output.stdout).unwrap()
}
