//! Python's `rosbags`, with nothing of ours, reads every message that we write, and we read what it
//! writes: MCAP and SQLite3, compressed and not.

use std::collections::BTreeMap;
use std::fs;

use handover_mesh::Stamp;
use handover_mesh::formats::bag::{self, File, Writer};
use handover_mesh::formats::{Format, UpAxis};
use handover_mesh::messages::{
    Clock, Diagnostic, DiagnosticArray, Duration, Header, JointState, KeyValue, Marker,
    MarkerArray, Message, MultiDofJointState, MultiDofPoint, MultiDofTrajectory, Point3,
    PoseStamped, Text, Time, Transform, TransformStamped, TransformTree, Twist, Vector3, encode,
};
use serde_json::{Value, json};

use super::common_python::run;
use super::scenes::{Sent, recording};

/// Prints every message of the bag `made`, and what the bag says of its topics.
const DUMP: &str = r#"
import dataclasses, json
import numpy
from pathlib import Path
from rosbags.rosbag2 import Reader
from ruamel.yaml import YAML
from rosbags.typesys import Stores, get_typestore, get_types_from_msg

store = get_typestore(Stores.ROS2_JAZZY)

def plain(value):
    if dataclasses.is_dataclass(value):
        # Constants are in capitals.
        names = [f.name for f in dataclasses.fields(value) if f.name[0].islower()]
        return {name: plain(getattr(value, name)) for name in names}
    if isinstance(value, numpy.ndarray):
        return value.tolist()
    return [plain(v) for v in value] if isinstance(value, list) else value

with Reader("made") as bag:
    messages = []
    for connection, time, raw in bag.messages():
        message = store.deserialize_cdr(raw, connection.msgtype)
        again = bytes(store.serialize_cdr(message, connection.msgtype))
        messages.append([connection.topic, connection.msgtype, time, plain(message), again == raw])
    topics = []
    for connection in bag.connections:
        own = get_typestore(Stores.EMPTY)
        own.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
        same = own.hash_rihs01(connection.msgtype) == store.hash_rihs01(connection.msgtype)
        same = same and connection.digest == store.hash_rihs01(connection.msgtype)
        qos = connection.ext.offered_qos_profiles[0]
        topics.append([connection.topic, connection.msgcount, same, qos.durability.name])
    text = Path("made/metadata.yaml").read_text("utf8")
    metadata = YAML(typ="safe").load(text)["rosbag2_bagfile_information"]
    # Humble takes nothing but a text here, and nothing but numbers in it.
    kinds = set()
    for topic in metadata["topics_with_message_count"]:
        text = topic["topic_metadata"]["offered_qos_profiles"]
        assert isinstance(text, str), text
        quality, = YAML(typ="safe").load(text)
        kinds |= {type(quality[name]).__name__ for name in
                  ["history", "depth", "reliability", "durability", "liveliness"]}
    assert kinds == {"int"}, kinds
    print(json.dumps({"messages": messages, "topics": topics, "custom": metadata["custom_data"],
                      "version": metadata["version"], "distribution": bag.ros_distro,
                      "count": bag.message_count, "duration": bag.duration}))
"#;

/// Writes the messages of the bag `made` anew in every way there is.
const COPY: &str = r#"
import shutil, struct, sys, zlib
import lz4.frame
from pathlib import Path
from ruamel.yaml import YAML
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

store = get_typestore(Stores.ROS2_JAZZY)
text = Path("made/metadata.yaml").read_text("utf8")
custom = YAML(typ="safe").load(text)["rosbag2_bagfile_information"]["custom_data"]
# Metadata of both versions that there are of qualities: as a text, and as a list.
ways = {
    "mcap": (StoragePlugin.MCAP, None, 9),
    "mcap_8": (StoragePlugin.MCAP, None, 8),
    "mcap_zstd": (StoragePlugin.MCAP, CompressionMode.STORAGE, 9),
    "sqlite": (StoragePlugin.SQLITE3, None, 9),
    "sqlite_8": (StoragePlugin.SQLITE3, None, 8),
    "sqlite_message": (StoragePlugin.SQLITE3, CompressionMode.MESSAGE, 9),
    "sqlite_file": (StoragePlugin.SQLITE3, CompressionMode.FILE, 9),
    "mcap_file": (StoragePlugin.MCAP, CompressionMode.FILE, 9),
}
for name, (plugin, mode, version) in ways.items():
    with Reader("made") as bag:
        out = Writer(Path(name), version=version, storage_plugin=plugin)
        if mode:
            out.set_compression(mode, CompressionFormat.ZSTD)
        for key, value in custom.items():
            out.set_custom_data(key, value)
        with out:
            topics = {c.id: out.add_connection(c.topic, c.msgtype, typestore=store)
                      for c in bag.connections}
            for connection, time, raw in bag.messages():
                out.write(topics[connection.id], time, raw)

# rosbags writes no LZ4: chunks are packed anew, by the specification of MCAP alone.
found = next(Path("mcap").glob("*.mcap")).read_bytes()
out, at, chunks = bytearray(found[:8]), 8, 0
while at < len(found) - 8:
    opcode, length = found[at], struct.unpack_from("<Q", found, at + 1)[0]
    body = found[at + 9:at + 9 + length]
    at += 9 + length
    if opcode == 6:
        start, end, size, crc, name = struct.unpack_from("<QQQII", body)
        assert name == 0, "not compressed"
        records = body[32 + name + 8:]
        packed = lz4.frame.compress(records)
        crc = zlib.crc32(records)
        body = struct.pack("<QQQII", start, end, size, crc, 3) + b"lz4" + struct.pack("<Q", len(packed)) + packed
        chunks += 1
    if opcode in (1, 3, 4, 5, 6, 12, 15):
        out += struct.pack("<BQ", opcode, len(body)) + body
    if opcode == 15:
        break
out += struct.pack("<BQQQI", 2, 20, 0, 0, 0) + found[:8]
Path("lz4.mcap").write_bytes(out)
print(chunks)
"#;

/// Who reads and writes bags.
fn python() -> Option<String> {
    super::common_python::python("numpy, rosbags, lz4", "bags")
}

fn sent<M: Message>(topic: &str, stamp: i64, message: &M) -> (Sent, Value) {
    let sent = (topic.to_owned(), M::TYPE.to_owned(), Stamp(stamp), encode(message));
    (sent, serde_json::to_value(message).unwrap())
}

/// A message of every type that is written.
fn all_types() -> Vec<(Sent, Value)> {
    let stamp = Time { sec: 1_700_000_000, nanosec: 123_456_789 };
    let header = || Header { stamp, frame_id: "world".to_owned() };
    let names = || vec!["head".to_owned(), "left_hand".to_owned()];
    let at = |x: f64| Transform {
        translation: Vector3 { x, y: -0.0, z: 1e-300 },
        ..Transform::default()
    };
    let skeleton = MultiDofJointState {
        header: header(),
        joint_names: names(),
        transforms: vec![at(0.1), at(-7.25)],
        twist: vec![Twist::default()],
        ..Default::default()
    };
    let point = MultiDofPoint {
        transforms: vec![at(0.5), at(0.25)],
        velocities: vec![Twist::default(); 2],
        time_from_start: Duration { sec: 1, nanosec: 5 },
        ..Default::default()
    };
    let targets = MultiDofTrajectory {
        header: header(),
        joint_names: names(),
        points: vec![point.clone(), point],
    };
    let edge = TransformStamped {
        header: header(),
        child_frame_id: "head_1".to_owned(),
        transform: at(3.0),
    };
    let marker = Marker {
        header: header(),
        ns: "body".to_owned(),
        id: 126,
        kind: Marker::LINE_LIST,
        points: vec![Point3 { x: 1.0, y: 2.0, z: 3.0 }],
        text: "ü".to_owned(),
        ..Marker::default()
    };
    let pair = KeyValue { key: "a".to_owned(), value: "b".to_owned() };
    let diagnostic =
        Diagnostic { name: "handover".to_owned(), values: vec![pair], ..Diagnostic::default() };
    let joints = JointState {
        header: header(),
        name: names(),
        position: vec![0.5],
        ..JointState::default()
    };
    let from = 1_700_000_000_000_000_000;
    vec![
        sent("/skeleton", from, &skeleton),
        sent("/handover/joint_targets", from + 1, &targets),
        sent(
            "/handover/hand_target",
            from + 2,
            &PoseStamped { header: header(), ..Default::default() },
        ),
        sent("/tf", from + 3, &TransformTree { transforms: vec![edge] }),
        sent("/handover/markers", from + 4, &MarkerArray { markers: vec![marker] }),
        sent("/handover/handover_state", from + 5, &Text { data: "approach".to_owned() }),
        sent(
            "/diagnostics",
            from + 6,
            &DiagnosticArray { header: header(), status: vec![diagnostic] },
        ),
        sent("/clock", from + 7, &Clock { clock: stamp }),
        sent("/joint_states", from + 8, &joints),
    ]
}

#[test]
fn python_reads_every_type_of_message() {
    let Some(python) = python() else { return };
    let here = tempfile::tempdir().unwrap();
    fs::create_dir(here.path().join("made")).unwrap();
    let words = "\u{85}\u{feff}\u{2028} \"ü\" \\ : #\n\t\u{1f91d}";
    let custom: BTreeMap<String, String> = [("words".to_owned(), words.to_owned())].into();
    let mut bag = Writer::new("made_0.mcap", custom).unwrap();
    let messages = all_types();
    for ((topic, type_name, time, data), _) in &messages {
        let topic = bag.topic(topic, type_name, topic.ends_with("state")).unwrap();
        bag.message(topic, *time, data).unwrap();
    }
    let written = bag.finish().unwrap();
    fs::write(here.path().join("made/made_0.mcap"), written.mcap).unwrap();
    fs::write(here.path().join("made/metadata.yaml"), written.metadata).unwrap();
    let found: Value = serde_json::from_str(&run(&python, DUMP, here.path())).unwrap();
    assert_eq!(found["custom"]["words"], words);
    assert_eq!((&found["version"], &found["distribution"]), (&json!(8), &json!("iron")));
    assert_eq!((&found["count"], &found["duration"]), (&json!(9), &json!(9)));
    for (at, ((topic, type_name, time, _), message)) in messages.iter().enumerate() {
        let [name, kind, stamp, content, again] = &found["messages"][at].as_array().unwrap()[..]
        else {
            panic!("{found}")
        };
        assert_eq!([name, kind, stamp], [&json!(topic), &json!(type_name), &json!(time.0)]);
        assert_eq!(content, message, "{topic}");
        assert_eq!(again, &json!(true), "{topic}: its bytes are Python's");
        let durability = if topic.ends_with("state") { "TRANSIENT_LOCAL" } else { "VOLATILE" };
        assert_eq!(found["topics"][at], json!([topic, 1, true, durability]), "definition and hash");
    }
}

#[test]
fn what_python_writes_is_the_same_recording() {
    let Some(python) = python() else { return };
    let here = tempfile::tempdir().unwrap();
    fs::create_dir(here.path().join("made")).unwrap();
    let before = recording(300, [("class".to_owned(), "07".to_owned())].into());
    let written = bag::write(&before, "made_0.mcap").unwrap();
    fs::write(here.path().join("made/made_0.mcap"), written.mcap).unwrap();
    fs::write(here.path().join("made/metadata.yaml"), written.metadata).unwrap();
    let chunks: usize = run(&python, COPY, here.path()).trim().parse().unwrap();
    assert!(chunks > 0);
    let check = |name: &str, metadata: Option<&str>, bytes: &[u8], format: Format| {
        let file = File { name, bytes: Some(bytes) };
        let found = bag::read(&[file], metadata, "clip", UpAxis::Z).unwrap();
        assert_eq!(found.format, format, "{name}");
        assert!(found.losses.is_empty() && found.notes.is_empty(), "{name}: {found:?}");
        assert_eq!(found.recording.people(), before.people(), "{name}");
        assert_eq!(found.recording.object(), before.object(), "{name}");
        assert_eq!(found.recording.metadata(), before.metadata(), "{name}");
    };
    for (name, format) in [
        ("mcap", Format::Mcap),
        ("mcap_8", Format::Mcap),
        ("mcap_zstd", Format::Mcap),
        ("sqlite", Format::Sqlite),
        ("sqlite_8", Format::Sqlite),
        ("sqlite_message", Format::Sqlite),
        ("sqlite_file", Format::Sqlite),
        ("mcap_file", Format::Mcap),
    ] {
        let metadata = fs::read_to_string(here.path().join(name).join("metadata.yaml")).unwrap();
        let [file] = &bag::file_names(&metadata).unwrap()[..] else { panic!("{metadata}") };
        let bytes = fs::read(here.path().join(name).join(file)).unwrap();
        check(file, Some(&metadata), &bytes, format);
        // Bare files have their metadata inside.
        check(file, None, &bytes, format);
        damaged(&before, &bytes);
    }
    let lz4 = fs::read(here.path().join("lz4.mcap")).unwrap();
    let metadata = fs::read_to_string(here.path().join("mcap/metadata.yaml")).unwrap();
    check("lz4.mcap", Some(&metadata), &lz4, Format::Mcap);
}

/// What Python wrote, cut and changed: what is read is a beginning of it or told.
fn damaged(before: &handover_mesh::Recording, bytes: &[u8]) {
    let read = |bytes: &[u8]| {
        bag::read(&[File { name: "cut", bytes: Some(bytes) }], None, "clip", UpAxis::Z)
    };
    for cut in (1..40).map(|part| bytes.len() * part / 40) {
        if let Ok(found) = read(&bytes[..cut]) {
            let frames = found.recording.len();
            let all = frames == before.len();
            assert!(all || !found.losses.is_empty(), "{cut} of {}: {frames}", bytes.len());
            for (found, before) in found.recording.people().iter().zip(before.people()) {
                assert_eq!(found.motion.frames(), &before.motion.frames()[..frames]);
            }
        }
    }
    for at in (0..200).map(|part| bytes.len() * part / 200) {
        let mut bytes = bytes.to_vec();
        bytes[at] ^= 0xff;
        let _ = read(&bytes);
    }
}
