//! SQLite3 bags, as rosbag2 lays them out; included by path.

use std::collections::BTreeMap;
use std::path::Path;

use handover_mesh::formats::bag::{self, File};
use rusqlite::Connection;

/// Writes what is in an MCAP bag anew as SQLite3, with the metadata inside.
pub(crate) fn sqlite_of(mcap: &[u8], metadata: &str, path: &Path) {
    let database = Connection::open(path).unwrap();
    let tables = "
        CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
        CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL,
            metadata TEXT NOT NULL);
        CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
            serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,
            timestamp INTEGER NOT NULL, data BLOB NOT NULL);
        CREATE INDEX timestamp_idx ON messages (timestamp ASC);
        BEGIN;";
    database.execute_batch(tables).unwrap();
    let mut topics = BTreeMap::new();
    let file = File { name: "bag", bytes: Some(mcap) };
    bag::messages(&[file], |raw| {
        let next = topics.len() as i64 + 1;
        let id = *topics.entry(raw.topic.to_owned()).or_insert(next);
        if id == next {
            let insert = "INSERT INTO topics VALUES (?1, ?2, ?3, 'cdr', '')";
            database.execute(insert, (id, raw.topic, raw.type_name)).unwrap();
        }
        let insert = "INSERT INTO messages (topic_id, timestamp, data) VALUES (?1, ?2, ?3)";
        database.execute(insert, (id, raw.time.0, raw.data)).unwrap();
    })
    .unwrap();
    database.execute("INSERT INTO metadata VALUES (1, 8, ?1)", [metadata]).unwrap();
    database.execute_batch("COMMIT").unwrap();
}
