//! SQLite3 bags: read as MCAP is, whole, compressed, cut and changed.

use std::collections::BTreeMap;
use std::fs;
use std::sync::OnceLock;

use handover_mesh::formats::bag::{self, Loss};
use handover_mesh::formats::{self, Format, UpAxis};
use proptest::prelude::*;
use rusqlite::Connection;

use super::scenes::{read, recording};
use super::sqlite_bags::sqlite_of;

fn whole() -> &'static [u8] {
    static WHOLE: OnceLock<Vec<u8>> = OnceLock::new();
    WHOLE.get_or_init(|| {
        let here = tempfile::tempdir().unwrap();
        let path = here.path().join("clip.db3");
        let metadata = [("class".to_owned(), "07".to_owned())].into();
        let written = bag::write(&recording(150, metadata), "clip_0.mcap").unwrap();
        sqlite_of(&written.mcap, &written.metadata, &path);
        fs::read(path).unwrap()
    })
}

#[test]
fn sqlite_gives_what_mcap_does() {
    let before = recording(150, [("class".to_owned(), "07".to_owned())].into());
    let found = read(whole()).unwrap();
    assert_eq!((found.recording, found.format), (before.clone(), Format::Sqlite));
    assert!(found.losses.is_empty() && found.notes.is_empty());
    assert_eq!(formats::read(whole(), "clip", UpAxis::Z).unwrap(), before);
    let packed = zstd::encode_all(whole(), 1).unwrap();
    assert_eq!(read(&packed).unwrap().recording, before);
    let found = read(&packed[..packed.len() * 3 / 4]).unwrap();
    assert!(!found.losses.is_empty() && found.recording.len() < 150);
}

#[test]
fn a_database_cut_anywhere_gives_what_is_whole() {
    let bytes = whole();
    let mut read_some = 0;
    for cut in (0..bytes.len()).step_by(4099) {
        let Ok(found) = read(&bytes[..cut]) else { continue };
        let [Loss::Rows { messages, .. }] = &found.losses[..] else {
            panic!("{cut}: {:?}", found.losses)
        };
        let frames = found.recording.len();
        assert!(frames as u64 <= messages / 3 + 1 && frames <= 150);
        read_some += 1;
    }
    assert!(read_some > 10, "{read_some}");
}

#[test]
fn rows_of_topics_that_nobody_defined_are_counted() {
    let here = tempfile::tempdir().unwrap();
    let path = here.path().join("clip.db3");
    fs::write(&path, whole()).unwrap();
    let database = Connection::open(&path).unwrap();
    // The cup is forgotten, and two rows are of somebody who never was.
    let forget = "
        DELETE FROM topics WHERE name = '/cup/object_pose';
        INSERT INTO messages (topic_id, timestamp, data) VALUES (77, 1, x'00'), (77, 2, x'');";
    database.execute_batch(forget).unwrap();
    drop(database);
    let found = read(&fs::read(path).unwrap()).unwrap();
    let losses: Vec<String> = found.losses.iter().map(ToString::to_string).collect();
    assert_eq!(
        losses,
        [
            "clip.mcap: 150 messages are of topic 3, which the file does not define",
            "clip.mcap: 2 messages are of topic 77, which the file does not define",
        ]
    );
    let before = recording(150, BTreeMap::new());
    assert_eq!(found.recording.people(), before.people());
    assert!(found.recording.object().is_none());
}

#[test]
fn what_is_no_plain_table_is_not_asked() {
    let here = tempfile::tempdir().unwrap();
    let path = here.path().join("endless.db3");
    let database = Connection::open(&path).unwrap();
    let endless = "
        CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT,
            serialization_format TEXT);
        CREATE VIEW messages AS
            WITH RECURSIVE n(topic_id) AS (SELECT 1 UNION ALL SELECT 1 FROM n)
            SELECT topic_id, 0 AS timestamp, x'00' AS data FROM n;";
    database.execute_batch(endless).unwrap();
    drop(database);
    let error = read(&fs::read(path).unwrap()).unwrap_err().to_string();
    assert_eq!(
        error,
        "no bag: clip.mcap: 'messages' is no plain table; 0 messages before that are whole"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn flipped_bytes_of_databases_never_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        head in any::<bool>(),
    ) {
        let mut bytes = whole().to_vec();
        // The first pages say where all others are.
        let reach = if head { 8192 } else { bytes.len() };
        for (at, value) in flips {
            let at = at.index(reach);
            bytes[at] = value;
        }
        if let Ok(found) = read(&bytes) {
            prop_assert!(found.recording.len() <= 150);
        }
    }
}

#[test]
fn a_bag_in_several_files_is_one_recording() {
    let before = recording(60, BTreeMap::new());
    let written = bag::write(&before, "clip_0.mcap").unwrap();
    let file = bag::File { name: "clip", bytes: Some(&written.mcap) };
    let mut parts: [Vec<super::scenes::Sent>; 2] = Default::default();
    bag::messages(&[file], |raw| {
        let late = usize::from(raw.time.0 > 30 * super::scenes::STEP);
        let sent = (raw.topic.to_owned(), raw.type_name.to_owned(), raw.time, raw.data.to_vec());
        parts[late].push(sent);
    })
    .unwrap();
    let parts = parts.map(|messages| super::scenes::bag_of(&messages));
    let files = [0, 1].map(|at| bag::File { name: "part", bytes: Some(&parts[at]) });
    let found = bag::read(&files, Some(&written.metadata), "clip", UpAxis::Z).unwrap();
    assert_eq!(found.recording, before);
    let gone = [bag::File { name: "part_0.mcap", bytes: None }, files[1]];
    let found = bag::read(&gone, Some(&written.metadata), "clip", UpAxis::Z).unwrap();
    assert_eq!(found.recording.len(), 29);
    assert_eq!(found.losses[0].to_string(), "part_0.mcap: there is no such file");
}
