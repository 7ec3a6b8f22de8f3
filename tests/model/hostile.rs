//! What is no model is refused by name, with place, value and bound.

use handover_mesh::config::ConfigError;
use handover_mesh::model::{Model, ModelError};
use serde_json::{Value, json};

use super::files::{File, put_together};
use super::parts::parts;

fn good() -> File {
    File::of(&parts().model().unwrap().to_bytes())
}

#[track_caller]
fn check(bytes: &[u8], expected: &str) {
    match Model::from_bytes(bytes) {
        Ok(_) => panic!("good, not: {expected}"),
        Err(error) => {
            let text = error.to_string();
            assert!(text.contains(expected), "{text}\nlacks: {expected}");
        }
    }
}

/// A good file with something changed.
#[track_caller]
fn check_file(change: impl FnOnce(&mut File), expected: &str) {
    let mut file = good();
    change(&mut file);
    check(&file.bytes(), expected);
}

/// A good file with something of its text changed: the value at `pointer`.
#[track_caller]
fn check_text(pointer: &str, value: Value, expected: &str) {
    let change = |model: &mut Value| match model.pointer_mut(pointer) {
        Some(place) => *place = value,
        None => {
            let (object, key) = pointer.rsplit_once('/').unwrap();
            model.pointer_mut(object).unwrap()[key] = value;
        }
    };
    check_file(|file| file.change_model(change), expected);
}

#[test]
fn the_file_taken_apart_and_put_together_is_good() {
    assert!(Model::from_bytes(&good().bytes()).is_ok());
}

#[test]
fn other_files_are_no_safetensors() {
    let csv = b"frame,time_s,person,joint,x,y,z\n0,0,giver,head,0,0,0\n";
    let text = "no safetensors file: 8 bytes of length and then '{' expected, it starts with 'frame,time_s";
    check(csv, text);
    check(b"PK\x03\x04\x14\0\0\0\x08\0", "starts with 'PK\\u{3}\\u{4}\\u{14}");
    check(b"", "starts with ''");
    check(&[255; 100], "no safetensors file");
    check(b"{\"format\": 1}", "no safetensors file");
}

#[test]
fn headers_are_bounded_and_json() {
    let claim = |length: u64, rest: &[u8]| [&length.to_le_bytes()[..], rest].concat();
    let text = "the header has 9000000 bytes, at most 8388608 are read";
    check(&claim(9_000_000, b"{}"), text);
    check(&claim(u64::MAX, b"{}"), "the header has 18446744073709551615 bytes");
    let text = "the header takes 100 bytes, only 2 follow (is the file cut short?)";
    check(&claim(100, b"{}"), text);
    check(&claim(2, b"{:"), "the header is no JSON: key must be a string at line 1 column 2");
    check(&claim(1, b"{}"), "the header is no JSON: EOF");
    check(&put_together(b"{\"\xff\":0}", &[]), "the header is no JSON");
    let deep = format!("{{\"a\":{}", "[".repeat(100_000));
    check(&put_together(deep.as_bytes(), &[]), "the header is no JSON: recursion limit");
}

#[test]
fn headers_describe_their_bytes() {
    let one = |dtype: &str, shape: &str, offsets: &str| {
        let entry = format!(
            "{{\"a\":{{\"dtype\":\"{dtype}\",\"shape\":{shape},\"data_offsets\":{offsets}}}}}"
        );
        put_together(entry.as_bytes(), &[0; 16])
    };
    check(&one("F65", "[2]", "[0,16]"), "describes no tensors: unknown variant `F65`");
    check(&one("F64", "[3]", "[0,16]"), "describes no tensors: invalid shape");
    check(&one("F64", "[2]", "[8,24]"), "describes no tensors: invalid offset for tensor `a`");
    check(&one("F64", "[2]", "[16,0]"), "describes no tensors: invalid offset");
    check(&one("F64", "[-2]", "[0,16]"), "describes no tensors: invalid value");
    check(&one("F64", "[4294967296,4294967296]", "[0,16]"), "describes no tensors: overflow");
    check(&one("F64", "[1]", "[0,8]"), "the tensors take 8 bytes, 16 follow the header");
    let text = "the tensors take 24 bytes, 16 follow the header (is the file cut short?)";
    check(&one("F64", "[3]", "[0,24]"), text);
}

#[test]
fn other_formats_versions_and_units_are_refused() {
    let set = |key: &'static str, value: &'static str| {
        move |file: &mut File| file.header["__metadata__"][key] = json!(value)
    };
    let drop = |key: &'static str| {
        move |file: &mut File| {
            file.header["__metadata__"].as_object_mut().unwrap().remove(key);
        }
    };
    let format = "the metadata 'format' is 'pt', must be 'handover_mesh model'";
    check_file(set("format", "pt"), format);
    check_file(drop("format"), "the metadata 'format' is missing");
    let nothing = put_together(b"{}", &[]);
    check(&nothing, "not a model of handover_mesh: the metadata 'format' is missing");
    let newer = "format_version is 3 (written by handover_mesh 9.8.7), this is ";
    let both = |file: &mut File| {
        set("format_version", "3")(file);
        set("program_version", "9.8.7")(file);
        // Whatever else has changed since: the version is what is told.
        set("model", "{}")(file);
    };
    check_file(both, newer);
    check_file(both, "and reads up to 2 (hint: use a newer handover_mesh)");
    for version in ["0", "-1", "one", "1.0", ""] {
        let text = format!("format_version is '{version}', must be a whole number from 1 to 2");
        check_file(|file| file.header["__metadata__"]["format_version"] = json!(version), &text);
    }
    check_file(set("units", "mm, s"), "units are 'mm, s', must be 'm, ns'");
    for key in ["format_version", "units", "model", "program_version"] {
        check_file(drop(key), &format!("the metadata '{key}' is missing"));
    }
}

#[test]
fn the_text_beside_the_tensors_is_checked() {
    let broken = |file: &mut File| file.header["__metadata__"]["model"] = json!("{\"role\":");
    check_file(broken, "the metadata 'model': EOF while parsing a value at line 1 column 8");
    check_text("/colour", json!(1), "the metadata 'model': unknown field `colour`");
    let lacks = |model: &mut Value| drop(model.as_object_mut().unwrap().remove("people"));
    check_file(|file| file.change_model(lacks), "the metadata 'model': missing field `people`");
    check_text("/people", json!([]), "the metadata 'model': invalid length 0");
    check_text("/hands/robot", json!("third"), "unknown variant `third`");
    check_text("/edges", json!(-1), "invalid value: integer `-1`");
    check_text("/role", json!("guest"), "demonstration 0: first: no person 'guest'");
    let text = "both people are called 'giver'";
    check_text("/people/1/name", json!("giver"), text);
    check_text("/people/1/name", json!("a\u{1b}[2J"), "person 'a\\u{1b}[2J' must");
    check_text("/demonstrations/0/name", json!(""), "demonstration '' must have 1");
    let hash = "demonstration 1: sha256 is 'abc', must be 64 digits 0-9 and a-f";
    check_text("/demonstrations/1/sha256", json!("abc"), hash);
    let distance = "initial_distance is -0.5 m, must be finite and >= 0";
    check_text("/training/initial_distance", json!(-0.5), distance);
}

#[test]
fn names_that_make_no_skeleton_are_refused() {
    let text = "person 'giver': joint 'torso' appears twice";
    check_text("/people/0/joints/0", json!("torso"), text);
    let text = "person 'receiver': bones must join all joints in one tree";
    check_text("/people/1/bones/0", json!([3, 99]), text);
    check_text("/people/1/bones", json!([]), text);
    check_text("/people/0/joints", json!([]), "a skeleton has 2 to 64 joints, got 0");
}

#[test]
fn parameters_are_checked_together() {
    let mut file = good();
    file.change_model(|model| {
        model["config"]["mesh.scale"] = json!("wide");
        model["config"]["retarget.steps"] = json!(0);
        model["config"]["mesh.colour"] = json!(1);
    });
    let Err(ModelError::Config(ConfigError::Violations(all))) = Model::from_bytes(&file.bytes())
    else {
        panic!("no violations")
    };
    let keys: Vec<&str> = all.iter().map(|violation| violation.key.as_str()).collect();
    assert_eq!(keys, ["mesh.scale", "retarget.steps", "mesh.colour"]);
    check(&file.bytes(), "parameters: mesh.scale is \"wide\", must be a number from 0 to 1000000");
    check_text("/config", json!([]), "config: invalid type: sequence");
    let long = json!("x".repeat(70_000));
    check_text("/config/robot.base_joint", long, "bytes, at most 65536 are read");
}

#[test]
fn tensors_are_checked_together() {
    let mut file = good();
    let header = file.header.as_object_mut().unwrap();
    let stamps = header.remove("demonstration.1.stamps").unwrap();
    header.insert("times".into(), stamps);
    header["edges"]["dtype"] = json!("U64");
    header["demonstration.0.positions"]["shape"] = json!([3, 3, 30]);
    let expected = "tensor 'demonstration.0.positions' has shape [3, 3, 30], the model's text says [3, 30, 3]\n\
        tensor 'demonstration.1.stamps' is missing\n\
        tensor 'edges' has U64 numbers, must have I64\n\
        tensor 'times' is none of the model's";
    let error = Model::from_bytes(&file.bytes()).unwrap_err();
    assert_eq!(error.to_string(), expected);
    // A thousand of them are not all named.
    let header = file.header.as_object_mut().unwrap();
    for at in 0..1000 {
        let empty = json!({ "dtype": "U8", "shape": [0], "data_offsets": [0, 0] });
        header.insert(format!("x{at}"), empty);
    }
    check(&file.bytes(), "\n... and 984 more");
}

#[test]
fn counts_that_disagree_are_told() {
    let text = "tensor 'demonstration.1.positions' has shape [3, 30, 3], the model's text says [4, 30, 3]\n\
        tensor 'demonstration.1.stamps' has shape [3], the model's text says [4]";
    check_text("/demonstrations/1/frames", json!(4), text);
    let text = "tensor 'edges' has shape [2, 2], the model's text says [3, 2]\n\
        tensor 'weights' has shape [2, 3], the model's text says [3, 3]";
    check_text("/edges", json!(3), text);
    check_text("/phases", json!(2), "'weights' has shape [2, 3], the model's text says [2, 2]");
    let fewer = |model: &mut Value| drop(model["demonstrations"].as_array_mut().unwrap().pop());
    let text = "tensor 'demonstration.1.positions' is none of the model's\n\
        tensor 'demonstration.1.stamps' is none of the model's";
    check_file(|file| file.change_model(fewer), text);
    let huge = json!(u64::MAX);
    check_text("/demonstrations/0/frames", huge, "says [18446744073709551615, 30, 3]");
}

#[test]
fn numbers_are_checked() {
    let (positions, stamps) = ("demonstration.1.positions", "demonstration.0.stamps");
    // Frame 1, the second person's joint 2, y.
    let at = 3 * (30 + 15 + 2) + 1;
    let text = "demonstration 1, person 'receiver': frame 1, joint 'torso': position is not finite";
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        check_file(|file| file.set(positions, at, value.to_le_bytes()), text);
    }
    let text = "demonstration 1, frame 1, 'torso' of 'receiver': -1e300 m is farther than 1000 m";
    let far = (-1e300f64).to_le_bytes();
    check_file(|file| file.set(positions, at, far), text);
    let text = "demonstration 0, person 'giver': frame 2 at 0.0333 s is not after the one before it at 0.0333 s";
    check_file(|file| file.set(stamps, 2, 33_333_333i64.to_le_bytes()), text);
    let text = "demonstration 0, person 'giver': frame 1 at";
    check_file(|file| file.set(stamps, 1, i64::MIN.to_le_bytes()), text);
}

#[test]
fn edges_and_factors_are_checked() {
    // The edges are 0-23 and 8-23.
    let end =
        |n: usize, joint: i64| move |file: &mut File| file.set("edges", n, joint.to_le_bytes());
    let text = "edge 1 ends at joint 30; the people have 30 joints, counted from 0";
    check_file(end(3, 30), text);
    check_file(end(0, -1), "edge 0 ends at joint -1");
    check_file(end(0, i64::MIN), "edge 0 ends at joint -9223372036854775808");
    check_file(end(1, 5), "edge 0-5 does not join the two people, who have 30 joints together");
    check_file(end(0, 23), "edge 23-23 does not join the two people");
    check_file(end(0, 8), "edge 8-23 is there twice");
    let reversed = |file: &mut File| {
        end(0, 23)(file);
        end(1, 8)(file);
    };
    check_file(reversed, "edge 8-23 is there twice");
    let factor = |value: f64| move |file: &mut File| file.set("weights", 4, value.to_le_bytes());
    check_file(factor(-0.5), "edge 8-23, phase 1: factor -0.5 must be from 0 to 1000000000000");
    check_file(factor(f64::NAN), "edge 8-23, phase 1: factor NaN must be from 0 to 1000000000000");
    check_file(
        factor(f64::INFINITY),
        "edge 8-23, phase 1: factor inf must be from 0 to 1000000000000",
    );
}

/// A file without a single number: all shapes are consistent, and there is nothing in it.
#[test]
fn models_without_frames_demonstrations_or_phases_are_refused() {
    let mut file = good();
    let range = |file: &File, name: &str| file.range(name);
    let weights = range(&file, "weights");
    file.data.drain(weights.clone());
    file.header["weights"] =
        json!({ "dtype": "F64", "shape": [2, 0], "data_offsets": [weights.start, weights.start] });
    file.change_model(|model| model["phases"] = json!(0));
    check(&file.bytes(), "0 phases, must be 1 to 1048576");

    let empty = |shape: Value, dtype: &str| json!({ "dtype": dtype, "shape": shape, "data_offsets": [0, 0] });
    let mut file = good();
    file.data.clear();
    let metadata = file.header["__metadata__"].clone();
    file.header = json!({
        "__metadata__": metadata,
        "edges": empty(json!([0, 2]), "I64"),
        "weights": empty(json!([0, 1]), "F64"),
    });
    file.change_model(|model| {
        model["demonstrations"] = json!([]);
        model["edges"] = json!(0);
        model["phases"] = json!(1);
    });
    check(&file.bytes(), "no demonstrations; a model has at least one");
    file.change_model(|model| {
        model["demonstrations"] =
            json!([{ "name": "x", "frames": 0, "metadata": {}, "sha256": "0".repeat(64) }]);
    });
    file.header["demonstration.0.positions"] = empty(json!([0, 30, 3]), "F64");
    file.header["demonstration.0.stamps"] = empty(json!([0]), "I64");
    check(&file.bytes(), "demonstration 0, person 'giver': no frames");
    file.change_model(|model| model["edges"] = json!(226));
    file.header["edges"] = json!({ "dtype": "I64", "shape": [226, 2], "data_offsets": [0, 3616] });
    file.header["weights"]["shape"] = json!([226, 0]);
    file.header["weights"]["data_offsets"] = json!([3616, 3616]);
    file.change_model(|model| model["phases"] = json!(0));
    file.data = vec![0; 3616];
    check(&file.bytes(), "226 edges between the people, who can have 225 at most");
}
