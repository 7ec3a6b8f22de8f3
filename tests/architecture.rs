//! The map of `ARCHITECTURE.md` and the code are the same: layers, absences, invariants,
//! dependencies.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Who may import whom: a module, its layer, and the neighbours in its own layer it builds on.
/// Whatever stands in a lower layer is allowed.
const LAYERS: [(&str, u32, &[&str]); 32] = [
    ("geometry", 0, &[]),
    ("time", 0, &[]),
    ("settings", 0, &[]),
    ("statistics", 0, &[]),
    ("linear", 0, &[]),
    ("delaunay", 0, &["geometry"]),
    ("rotations", 0, &["geometry"]),
    ("align", 0, &[]),
    ("parameters", 0, &[]),
    ("lifecycle", 0, &[]),
    ("skeleton", 1, &[]),
    ("kinematics", 1, &[]),
    ("motion", 1, &[]),
    ("messages", 1, &[]),
    ("blend", 1, &[]),
    ("frames", 2, &[]),
    ("bodies", 2, &["frames"]),
    ("formats", 2, &["bodies", "frames"]),
    ("mesh", 2, &[]),
    ("retarget", 2, &["mesh"]),
    ("demonstration", 2, &[]),
    ("forecast", 2, &[]),
    ("filter", 2, &[]),
    ("safety", 2, &[]),
    ("predict", 3, &[]),
    ("track", 3, &[]),
    ("learn", 4, &[]),
    ("online", 4, &[]),
    // Evaluation does not read parameters: that is for the shells.
    ("config", 5, &[]),
    ("evaluate", 5, &[]),
    ("model", 6, &[]),
    ("live", 6, &[]),
];

/// What no layer of the library does: text, and why.
const ABSENT: [(&str, &str); 13] = [
    ("std::fs", "bytes come from the caller"),
    ("std::net", "bytes come from the caller"),
    ("std::process", "the library starts and ends nothing"),
    ("std::env", "parameters come from the caller"),
    ("Instant::now", "time comes with the data"),
    ("SystemTime", "time comes with the data"),
    ("println!", "printing is the shells'"),
    ("print!", "printing is the shells'"),
    ("dbg!", "printing is the shells'"),
    ("anyhow", "errors of the library are types"),
    ("unsafe", "nowhere"),
    ("async", "nothing here waits"),
    ("thread::spawn", "rayon's pools belong to the caller"),
];

/// No file is longer: a longer one has more than one subject.
const MOST_LINES: usize = 600;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Every Rust file below some folders, by its path from the root.
fn sources(folders: &[&str]) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut open: Vec<_> = folders.iter().map(|folder| root().join(folder)).collect();
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path()));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let name = path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
            found.insert(name, fs::read_to_string(&path).unwrap());
        }
    }
    found
}

/// Code without comments and, line for line, without what strings hold.
fn code(text: &str) -> String {
    text.lines().map(|line| without_strings(line) + "\n").collect()
}

fn without_strings(line: &str) -> String {
    let (mut kept, mut in_string, mut escaped) = (String::new(), false, false);
    let mut rest = line.char_indices().peekable();
    while let Some((at, letter)) = rest.next() {
        match letter {
            _ if escaped => escaped = false,
            '\\' if in_string => escaped = true,
            // A quote as a character is no string.
            '"' if in_string || !line[..at].ends_with('\'') => in_string = !in_string,
            '/' if !in_string && rest.peek().is_some_and(|(_, next)| *next == '/') => break,
            letter if !in_string => kept.push(letter),
            _ => {}
        }
    }
    kept
}

/// The module that a file of `src/` belongs to; none of `lib.rs` and the shells.
fn module(path: &str) -> Option<&str> {
    let below = path.strip_prefix("src/")?;
    let first = below.split('/').next()?;
    let name = first.strip_suffix(".rs").unwrap_or(first);
    (!matches!(name, "lib" | "bin" | "ros")).then_some(name)
}

/// Modules named after `crate::`, also inside braces.
fn imports(code: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (at, start) in code.match_indices("crate::") {
        // `$crate::` and `my_crate::` name something else.
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let rest = &code[at + start.len()..];
        let names = match rest.strip_prefix('{') {
            Some(list) => first_names(list),
            None => vec![leading_name(rest)],
        };
        found.extend(names.into_iter().map(str::to_owned));
    }
    found
}

fn leading_name(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    &text[..end]
}

/// The first name of each path of a list `a::b, c::{d, e}}`.
fn first_names(list: &str) -> Vec<&str> {
    let (mut names, mut depth, mut start) = (Vec::new(), 1, 0);
    for (at, letter) in list.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 1 => {}
            _ => continue,
        }
        if depth == 0 || (letter == ',' && depth == 1) {
            names.push(leading_name(list[start..at].trim_start()));
            start = at + 1;
        }
        if depth == 0 {
            break;
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

/// Whether `super::super::…` leads out of the module to the crate's root, and so past the layers.
fn climbs_out(path: &str, code: &str) -> bool {
    let below = path.trim_start_matches("src/");
    let folders = below.matches('/').count();
    let depth = folders + usize::from(!below.ends_with("/mod.rs"));
    // Tests inside a file are a module deeper.
    let (product, tests) = code.split_once("#[cfg(test)]\nmod ").unwrap_or((code, ""));
    product.contains(&"super::".repeat(depth)) || tests.contains(&"super::".repeat(depth + 1))
}

/// The crate root's own names, and the module each stands for (`Point` → `geometry`).
fn reexports(library: &str) -> BTreeMap<String, String> {
    let code = code(library);
    let uses = code.split(';').filter_map(|item| item.trim().strip_prefix("pub use "));
    uses.flat_map(|item| {
        let (module, names) = item.split_once("::").unwrap();
        let names = names.trim_matches(['{', '}']).split(',').map(str::trim);
        names.filter(|name| !name.is_empty()).map(|name| (name.to_owned(), module.to_owned()))
    })
    .collect()
}

/// What is wrong with one file of the library.
fn faults(path: &str, text: &str, reexports: &BTreeMap<String, String>) -> Vec<String> {
    let mut faults = Vec::new();
    let lines = text.lines().count();
    if lines > MOST_LINES {
        faults.push(format!("{path}: {lines} lines, more than {MOST_LINES}"));
    }
    let code = code(text);
    if path.starts_with("src/ros/") || path.starts_with("src/bin/") {
        return faults;
    }
    for (absent, why) in ABSENT {
        let whole = |at: usize| {
            let name = |c: char| c.is_alphanumeric() || c == '_';
            !code[..at].ends_with(name) && !code[at + absent.len()..].starts_with(name)
        };
        if code.match_indices(absent).any(|(at, _)| whole(at)) {
            faults.push(format!("{path}: {absent}: {why}"));
        }
    }
    if code.contains("r2r") {
        faults.push(format!("{path}: r2r outside src/ros/"));
    }
    let Some(module) = module(path) else { return faults };
    let layer = |name: &str| LAYERS.iter().find(|(known, ..)| *known == name);
    let Some((_, own, neighbours)) = layer(module) else {
        faults.push(format!("{path}: '{module}' is in no layer"));
        return faults;
    };
    if climbs_out(path, &code) {
        faults.push(format!("{path}: reaches the crate's root by super::"));
    }
    for import in imports(&code) {
        let import = reexports.get(&import).unwrap_or(&import);
        let allowed = import == module
            || neighbours.contains(&import.as_str())
            || layer(import).is_some_and(|(_, other, _)| other < own);
        if !allowed {
            faults.push(format!("{path}: {module} may not import {import}"));
        }
    }
    faults
}

#[track_caller]
fn check_faults(path: &str, text: &str, expected: &[&str]) {
    let names = reexports("pub use geometry::{Point, Vector};\npub use config::Config;\n");
    assert_eq!(faults(path, text, &names), expected);
}

#[test]
fn the_library_keeps_its_layers_and_absences() {
    let reexports = reexports(&read("src/lib.rs"));
    let sources = sources(&["src"]);
    assert!(sources.len() > 60, "only {} files found", sources.len());
    let modules: BTreeSet<&str> = sources.keys().filter_map(|path| module(path)).collect();
    let listed: BTreeSet<&str> = LAYERS.iter().map(|(name, ..)| *name).collect();
    assert_eq!(modules, listed, "modules there are and modules in the table");
    let faults: Vec<String> =
        sources.iter().flat_map(|(path, text)| faults(path, text, &reexports)).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn no_file_of_tests_or_simulator_is_too_long() {
    for (path, text) in sources(&["sim", "tests", "benches"]) {
        let lines = text.lines().count();
        assert!(lines <= MOST_LINES, "{path}: {lines} lines");
    }
}

/// The checker itself: what it must find, and what it must let pass.
#[test]
fn a_bad_snippet_is_found() {
    let upwards = "src/mesh/x.rs: mesh may not import predict";
    check_faults("src/mesh/x.rs", "use crate::predict::Method;", &[upwards]);
    check_faults("src/mesh/x.rs", "use crate::{\n    predict::Method,\n};", &[upwards]);
    check_faults("src/mesh/x.rs", "fn f(m: crate::predict::Method) {}", &[upwards]);
    check_faults(
        "src/mesh/x.rs",
        "use crate::{geometry::{Point, Vector}, skeleton, retarget::A};",
        &["src/mesh/x.rs: mesh may not import retarget"],
    );
    let climbs = "src/mesh/x.rs: reaches the crate's root by super::";
    check_faults("src/mesh/x.rs", "use super::super::predict::Method;", &[climbs]);
    let by_root = "src/predict/x.rs: predict may not import config";
    check_faults("src/predict/x.rs", "use crate::Config;", &[by_root]);
    check_faults("src/secret.rs", "", &["src/secret.rs: 'secret' is in no layer"]);
    let clock = "src/time.rs: Instant::now: time comes with the data";
    check_faults("src/time.rs", "let t = std::time::Instant::now();", &[clock]);
    let file = "src/lib.rs: std::fs: bytes come from the caller";
    check_faults("src/lib.rs", "use std::fs;", &[file]);
    let ros = "src/align.rs: r2r outside src/ros/";
    check_faults("src/align.rs", "use r2r::Node;", &[ros]);
    let long = "\n".repeat(601);
    check_faults("src/bin/x.rs", &long, &["src/bin/x.rs: 601 lines, more than 600"]);
}

#[test]
fn a_good_snippet_is_let_pass() {
    check_faults("src/mesh/x.rs", "use crate::skeleton::Role;\nuse crate::mesh::Edge;", &[]);
    check_faults("src/mesh/x.rs", "use crate::Point;\n/// Not [`crate::predict::Method`].", &[]);
    check_faults("src/retarget/x.rs", "use crate::mesh::Topology;", &[]);
    let tests = "use super::Edge;\n#[cfg(test)]\nmod tests {\n    use super::super::Edge;\n}";
    check_faults("src/mesh/x.rs", tests, &[]);
    check_faults("src/bin/x/main.rs", "use std::fs;\nuse crate::args;", &[]);
    check_faults("src/ros/node.rs", "use r2r::Node;", &[]);
    let words = "// println! of anyhow\nlet s = \"std::fs \\\" unsafe\"; let c = '\"'; f();";
    check_faults("src/time.rs", words, &[]);
}

/// Rows `| a | b |` of the table below a heading, without its head.
fn table(document: &str, heading: &str) -> Vec<Vec<String>> {
    let section = document.split("\n## ").find(|section| section.starts_with(heading));
    let section = section.unwrap_or_else(|| panic!("no section '{heading}'"));
    let rows = section.lines().filter(|line| line.starts_with('|')).skip(2);
    let cells = |row: &str| row.trim_matches('|').split('|').map(|c| c.trim().to_owned()).collect();
    rows.map(cells).collect()
}

/// Words in backquotes.
fn quoted(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

#[test]
fn the_documented_layers_are_the_checked_ones() {
    let document = read("ARCHITECTURE.md");
    let mut documented = BTreeMap::new();
    for row in table(&document, "Layers") {
        if let Ok(layer) = row[0].parse::<u32>() {
            documented.extend(quoted(&row[1]).into_iter().map(|name| (name.to_owned(), layer)));
        }
    }
    let checked = LAYERS.iter().map(|(name, layer, _)| ((*name).to_owned(), *layer)).collect();
    assert_eq!(documented, checked);
}

/// Whether some file holds `fn name` under a `#[test]`, as `proptest!` has it too.
fn is_test(sources: &BTreeMap<String, String>, name: &str) -> bool {
    let declaration = format!("fn {name}(");
    sources.values().any(|text| {
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        lines.windows(2).any(|pair| pair[0] == "#[test]" && pair[1].starts_with(&declaration))
    })
}

#[test]
fn every_invariant_names_a_test_that_exists() {
    let document = read("ARCHITECTURE.md");
    let sources = sources(&["src", "tests", "sim"]);
    assert!(is_test(&sources, "every_invariant_names_a_test_that_exists"));
    assert!(!is_test(&sources, "is_test"), "a function that is no test");
    let rows = table(&document, "Invariants");
    for (at, row) in rows.iter().enumerate() {
        assert_eq!(row[0], format!("I{}", at + 1), "invariants are counted");
        let tests = quoted(&row[2]);
        assert!(!tests.is_empty(), "{}: held by no test", row[0]);
        for test in tests {
            assert!(is_test(&sources, test), "{}: no test '{test}'", row[0]);
        }
    }
    assert!(rows.len() >= 10, "{rows:?}");
}

/// The dependencies of a manifest, all kinds.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let mut inside = false;
    let mut found = BTreeSet::new();
    for line in manifest.lines() {
        if line.starts_with('[') {
            inside = matches!(line, "[dependencies]" | "[dev-dependencies]");
        } else if let Some((name, _)) = line.split_once('=').filter(|_| inside) {
            found.insert(name.trim().trim_end_matches(".workspace").to_owned());
        }
    }
    found
}

#[test]
fn every_dependency_has_its_reason() {
    let document = read("ARCHITECTURE.md");
    let mut needed = dependencies(&read("Cargo.toml"));
    for member in ["sim", "benches"] {
        needed.extend(dependencies(&read(&format!("{member}/Cargo.toml"))));
    }
    needed.remove("handover_mesh");
    let rows = table(&document, "Dependencies");
    let reasoned: BTreeSet<String> =
        rows.iter().flat_map(|row| quoted(&row[0])).map(str::to_owned).collect();
    assert_eq!(needed, reasoned);
    assert!(rows.iter().all(|row| row[1].len() > 20), "each needs a reason");
}
