//! Python, with nothing of ours, reads a model file to the bit and writes one that we read.

use std::fs;

use handover_mesh::model::Model;
use serde_json::{Value, json};

use super::check_same;
use super::common::folder;
use super::common_python::run;
use super::parts::parts;

/// Prints every tensor and the metadata; floats as Python writes them, which is to the bit.
const DUMP: &str = r#"
import json
from safetensors import safe_open

with safe_open("model.safetensors", framework="np") as file:
    tensors = {name: file.get_tensor(name) for name in file.keys()}
    tensors = {
        name: {"dtype": str(t.dtype), "shape": t.shape, "numbers": t.ravel().tolist()}
        for name, t in tensors.items()
    }
    print(json.dumps({"metadata": file.metadata(), "tensors": tensors}))
"#;

/// Writes the same model anew, in whatever order the package likes.
const COPY: &str = r#"
from safetensors import safe_open
from safetensors.numpy import save_file

with safe_open("model.safetensors", framework="np") as file:
    tensors = {name: file.get_tensor(name) for name in reversed(list(file.keys()))}
    save_file(tensors, "copy.safetensors", metadata=file.metadata())
"#;

/// Who reads and writes model files.
fn python() -> Option<String> {
    super::common_python::python("numpy, safetensors", "model files")
}

#[test]
fn python_reads_the_same_numbers() {
    let Some(python) = python() else { return };
    let (here, model) = (folder(&[]), parts().model().unwrap());
    fs::write(here.path().join("model.safetensors"), model.to_bytes()).unwrap();
    let found: Value = serde_json::from_str(&run(&python, DUMP, here.path())).unwrap();
    let tensors = &found["tensors"];
    let check = |name: &str, dtype: &str, shape: Value, numbers: Value| {
        let tensor = &tensors[name];
        assert_eq!((&tensor["dtype"], &tensor["shape"]), (&json!(dtype), &shape), "{name}");
        assert_eq!(tensor["numbers"], numbers, "{name}");
    };
    for (n, demonstration) in model.demonstrations().iter().enumerate() {
        let recording = demonstration.recording();
        let metres: Vec<f64> =
            model.pair().positions(recording).iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        let name = format!("demonstration.{n}.positions");
        check(&name, "float64", json!([3, 30, 3]), json!(metres));
        let stamps: Vec<i64> = recording.stamps().map(|stamp| stamp.0).collect();
        check(&format!("demonstration.{n}.stamps"), "int64", json!([3]), json!(stamps));
    }
    check("edges", "int64", json!([2, 2]), json!([0, 23, 8, 23]));
    check("weights", "float64", json!([2, 3]), json!([0.5, 1.5, 2.5, 0.5, 1.5, 2.5]));
    assert_eq!(tensors.as_object().unwrap().len(), 6);
    assert_eq!(found["metadata"]["format"], "handover_mesh model");
    assert_eq!(found["metadata"]["units"], "m, ns");
}

#[test]
fn what_python_writes_is_the_same_model() {
    let Some(python) = python() else { return };
    let (here, mut parts) = (folder(&[]), parts());
    for edges in [parts.edges.clone(), super::LearnedEdges::none(parts.edges.hands())] {
        parts.edges = edges;
        let model = parts.model().unwrap();
        fs::write(here.path().join("model.safetensors"), model.to_bytes()).unwrap();
        run(&python, COPY, here.path());
        let copy = fs::read(here.path().join("copy.safetensors")).unwrap();
        check_same(&Model::from_bytes(&copy).unwrap(), &model);
    }
}

#[test]
fn the_readmes_snippet_runs() {
    let Some(python) = python() else { return };
    let readme = include_str!("../../README.md");
    let (_, rest) = readme.split_once("```python\n").unwrap();
    let (snippet, _) = rest.split_once("```").unwrap();
    let here = folder(&[]);
    fs::write(here.path().join("model.safetensors"), parts().model().unwrap().to_bytes()).unwrap();
    let said = run(&python, snippet, here.path());
    assert_eq!(
        said,
        "first (3, 30, 3)\nsecond (3, 30, 3)\n\
         giver/head - receiver/right_hand [0.5 1.5 2.5]\n\
         giver/right_hand - receiver/right_hand [0.5 1.5 2.5]\n"
    );
}
