//! `handover check` of model files: the real process, its exit code and its words.

use std::fs;

use serde_json::json;

use super::common::{check, check_json, folder};
use super::parts::{hash, parts};

#[test]
fn check_says_what_a_model_holds() {
    let models = folder(&[]);
    fs::write(models.path().join("m.safetensors"), parts().model().unwrap().to_bytes()).unwrap();
    let words = [
        "m.safetensors: model, the robot is giver, base torso; format 1, written by handover_mesh",
        "\n  receiver: 15 joints: head neck torso ",
        "\n  second: 3 frames, 0.07 s, sha256 0123456789ab\n",
        "\n  2 edges between the people, factors of 3 phases, named for the robot's right and the \
         partner's right hand\n",
        "\n    giver/right_hand - receiver/right_hand: 0.500 1.500 2.500\n",
        "\n  kernel 30 * (0.1 m / max(distance, 0.05 m))^4\n",
        "\n  learned by grow: 2 steps, 451 evaluations, distance 0.1000 m -> 0.0333 m, held out \
         0.0500 m\n",
        "\n  evaluate.folds is 7, by default 10\n",
    ];
    check(&models, &["check", "m.safetensors"], 0, &words);
    let found = &check_json(&models, &["check", "--json", "m.safetensors"], 0)["files"][0];
    assert_eq!((&found["good"], &found["format"]), (&json!(true), &json!("model")));
    assert_eq!(found["demonstrations"][1]["sha256"], hash());
    assert_eq!(found["edges"][1]["edge"], json!(["giver/right_hand", "receiver/right_hand"]));
    assert_eq!(found["edges"][1]["factors"], json!([0.5, 1.5, 2.5]));
    assert_eq!(found["training"]["final_distance_m"], json!(1.0 / 30.0));
    assert_eq!(found["changes"][0]["key"], "evaluate.folds");
    assert_eq!(found["config"]["mesh.scale"], json!(30.0));
}

#[test]
fn check_names_what_is_wrong_with_a_model() {
    let csv = "frame,time_s,person,joint,x,y,z\n\
        0,0,giver,head,0,0,1\n0,0,giver,torso,0,0,0\n\
        0,0,receiver,head,1,0,1\n0,0,receiver,torso,1,0,0\n";
    let models = folder(&[("a.safetensors", csv), ("b.csv", csv)]);
    let bytes = parts().model().unwrap().to_bytes();
    fs::write(models.path().join("cut.safetensors"), &bytes[..bytes.len() - 8]).unwrap();
    let words = ["a.safetensors: BAD\n  no safetensors file: 8 bytes of length"];
    check(&models, &["check", "a.safetensors"], 1, &words);
    let words = ["cut.safetensors: BAD\n  the tensors take", "(is the file cut short?)"];
    check(&models, &["check", "cut.safetensors"], 1, &words);
    check(&models, &["check", "a.safetensors", "b.csv"], 3, &["1 of 2 files are bad"]);
    check(&models, &["check", "no.safetensors"], 1, &["no.safetensors: no such file or folder"]);
    let found = check_json(&models, &["check", "--json", "cut.safetensors"], 1);
    assert_eq!(found["files"][0]["good"], json!(false));
    assert!(found["files"][0]["errors"][0]["reason"].as_str().unwrap().contains("cut short"));
}

/// A recording's hash is that of its bytes, as `sha256sum` has it.
#[test]
fn check_tells_the_hash_of_a_recording() {
    let text = "frame,time_s,person,joint,x,y,z\n\
        0,0,a,head,0,0,1\n0,0,a,torso,0,0,0\n0,0,b,head,1,0,1\n0,0,b,torso,1,0,0\n";
    let clips = folder(&[("a.csv", text)]);
    let found = check_json(&clips, &["check", "--json", "a.csv"], 0);
    assert_eq!(
        found["files"][0]["sha256"],
        "f12fc858820a897d1647900d07b243ca322949ddec0e7b0df3de407017ad1fd8"
    );
}
