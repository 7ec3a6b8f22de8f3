//! `metadata.yaml`, which makes a bag of a folder.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Deserialize;

use super::super::error::{Place, ReadError, Reason};
use crate::time::Stamp;

/// The name of the file that makes a folder a bag.
pub const METADATA_FILE: &str = "metadata.yaml";

/// What is asked of it; all else is for rosbag2.
#[derive(Debug, Default, Deserialize)]
struct Outer {
    rosbag2_bagfile_information: Information,
}

#[derive(Debug, Default, Deserialize)]
struct Information {
    #[serde(default)]
    relative_file_paths: Vec<String>,
    #[serde(default)]
    custom_data: Option<BTreeMap<String, String>>,
}

/// The names of a bag's files, in order.
///
/// - `metadata`: the text of `metadata.yaml`.
///
/// # Errors
/// [`Reason::NoBag`] if the text is no such metadata, or a name leads out of the folder.
pub fn file_names(metadata: &str) -> Result<Vec<String>, ReadError> {
    let fault = |reason| ReadError::of(Place::File, Reason::NoBag { reason });
    let information = information(metadata)
        .ok_or_else(|| fault(format!("{METADATA_FILE} has no rosbag2_bagfile_information")))?;
    let names = information.relative_file_paths;
    if names.is_empty() {
        return Err(fault(format!("{METADATA_FILE} names no file")));
    }
    let leads_out = |name: &&String| {
        name.is_empty()
            || name.starts_with(['/', '\\'])
            || name.split(['/', '\\']).any(|p| p == "..")
    };
    match names.iter().find(leads_out) {
        Some(name) => Err(fault(format!(
            "{METADATA_FILE} names '{}', which is not in the folder",
            super::shortened(name)
        ))),
        None => Ok(names),
    }
}

/// What somebody wrote down about the bag, if the text is such metadata.
pub(super) fn custom_data(metadata: &str) -> BTreeMap<String, String> {
    information(metadata).and_then(|found| found.custom_data).unwrap_or_default()
}

fn information(metadata: &str) -> Option<Information> {
    // A file of its own has a key around it, what is inside an MCAP file has none.
    let outer = serde_saphyr::from_str::<Outer>(metadata);
    let inner = || serde_saphyr::from_str::<Information>(metadata).ok();
    outer.ok().map(|outer| outer.rosbag2_bagfile_information).or_else(inner)
}

/// A topic as the metadata tells it.
pub(super) struct TopicEntry<'a> {
    pub(super) name: &'a str,
    pub(super) type_name: &'a str,
    pub(super) hash: &'a str,
    pub(super) latched: bool,
    pub(super) messages: u64,
}

/// Metadata of version 8: the newest in which the quality of a topic is a text, the only form that
/// Humble takes; Jazzy and Kilted, which write version 9, read it by its version.
///
/// - `between`: the first and the last message's time.
pub(super) fn text(
    file: &str,
    topics: &[TopicEntry<'_>],
    between: [Stamp; 2],
    custom_data: &BTreeMap<String, String>,
) -> String {
    let [start, end] = between;
    let (start, duration) = (start.0, (end - start).0);
    let messages: u64 = topics.iter().map(|topic| topic.messages).sum();
    let file = quoted(file);
    let mut text = format!(
        "version: 8\nstorage_identifier: mcap\nduration:\n  nanoseconds: {duration}\n\
         starting_time:\n  nanoseconds_since_epoch: {start}\nmessage_count: {messages}\n\
         topics_with_message_count:\n"
    );
    // Writing to a String cannot fail.
    for topic in topics {
        let _ = write!(
            text,
            "  - topic_metadata:\n      name: {}\n      type: {}\n      \
             serialization_format: cdr\n      offered_qos_profiles: {}\n      \
             type_description_hash: {}\n    message_count: {}\n",
            quoted(topic.name),
            topic.type_name,
            quoted(&qos(topic.latched)),
            topic.hash,
            topic.messages
        );
    }
    let _ = write!(
        text,
        "compression_format: \"\"\ncompression_mode: \"\"\nrelative_file_paths:\n  - {file}\n\
         files:\n  - path: {file}\n    starting_time:\n      nanoseconds_since_epoch: {start}\n    \
         duration:\n      nanoseconds: {duration}\n    message_count: {messages}\n"
    );
    if custom_data.is_empty() {
        text.push_str("custom_data: ~\n");
    } else {
        text.push_str("custom_data:\n");
        for (key, value) in custom_data {
            let _ = writeln!(text, "  {}: {}", quoted(key), quoted(value));
        }
    }
    // Whose version 8 is; which it was makes no difference to who reads it.
    text.push_str("ros_distro: iron\n");
    text
}

/// The text below the key that a file of its own has.
pub(super) fn as_file(text: &str) -> String {
    format!("rosbag2_bagfile_information:\n{}", indented(text, 2))
}

/// Reliable, as recorders of our topics may ask for; latched: whoever comes later hears the last.
///
/// Policies by the numbers that rmw gives them, as all versions before 9 have them.
pub(super) fn qos(latched: bool) -> String {
    const KEEP_LAST: u8 = 1;
    const RELIABLE: u8 = 1;
    const TRANSIENT_LOCAL: u8 = 1;
    const VOLATILE: u8 = 2;
    const AUTOMATIC: u8 = 1;
    let durability = if latched { TRANSIENT_LOCAL } else { VOLATILE };
    let endless = "sec: 9223372036\n    nsec: 854775807";
    format!(
        "- history: {KEEP_LAST}\n  depth: 10\n  reliability: {RELIABLE}\n  durability: {durability}\n  \
         deadline:\n    {endless}\n  lifespan:\n    {endless}\n  liveliness: {AUTOMATIC}\n  \
         liveliness_lease_duration:\n    {endless}\n  avoid_ros_namespace_conventions: false\n"
    )
}

fn indented(text: &str, by: usize) -> String {
    text.lines().map(|line| format!("{}{line}\n", " ".repeat(by))).collect()
}

/// YAML in double quotes; what is not plain ASCII by its number, which no reader takes for anything
/// else.
fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for letter in text.chars() {
        match letter {
            '"' | '\\' => quoted.extend(['\\', letter]),
            '\n' => quoted.push_str("\\n"),
            ' '..='~' => quoted.push(letter),
            // Writing to a String cannot fail.
            _ => drop(write!(quoted, "\\U{:08X}", u32::from(letter))),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metadata_reads_back() {
        let custom: BTreeMap<String, String> = [
            ("class", "07"),
            ("odd: \"key\"", "no\n# \u{7f}\\ 'x' \u{1}\t"),
            ("", "~"),
            ("n", "1"),
        ]
        .map(|(key, value)| (key.to_owned(), value.to_owned()))
        .into();
        let topic = TopicEntry {
            name: "/a b/skeleton",
            type_name: "std_msgs/msg/String",
            hash: "RIHS01_0",
            latched: true,
            messages: 3,
        };
        let inner = text("a \"b\"_0.mcap", &[topic], [Stamp(5), Stamp(9)], &custom);
        for text in [inner.clone(), as_file(&inner)] {
            assert_eq!(custom_data(&text), custom, "{text}");
            assert_eq!(file_names(&text).unwrap(), ["a \"b\"_0.mcap"]);
        }
        assert!(custom_data(&text("a", &[], [Stamp(0); 2], &BTreeMap::new())).is_empty());
    }

    /// What Humble's reader asks of a topic, by type: it converts nothing.
    #[test]
    fn humble_finds_the_types_it_expects() {
        #[derive(Deserialize)]
        struct Bag {
            version: u32,
            topics_with_message_count: Vec<Topic>,
            ros_distro: String,
        }
        #[derive(Deserialize)]
        struct Topic {
            topic_metadata: Metadata,
        }
        #[derive(Deserialize)]
        struct Metadata {
            offered_qos_profiles: String,
            type_description_hash: String,
        }
        #[derive(Deserialize, Debug, PartialEq)]
        struct Quality {
            history: i32,
            depth: i32,
            reliability: i32,
            durability: i32,
            deadline: BTreeMap<String, u64>,
            liveliness: i32,
            avoid_ros_namespace_conventions: bool,
        }
        let of = |name, latched| TopicEntry {
            name,
            type_name: "std_msgs/msg/String",
            hash: "RIHS01_0",
            latched,
            messages: 3,
        };
        let topics = [of("/a", true), of("/b", false)];
        let text = text("a_0.mcap", &topics, [Stamp(5), Stamp(9)], &BTreeMap::new());
        let bag: Bag = serde_saphyr::from_str(&text).unwrap();
        assert_eq!((bag.version, bag.ros_distro.as_str()), (8, "iron"));
        for (topic, durability) in bag.topics_with_message_count.iter().zip([1, 2]) {
            let Metadata { offered_qos_profiles, type_description_hash } = &topic.topic_metadata;
            assert_eq!(type_description_hash, "RIHS01_0");
            let found: Vec<Quality> = serde_saphyr::from_str(offered_qos_profiles).unwrap();
            let endless = [("sec", 9_223_372_036), ("nsec", 854_775_807)];
            let expected = Quality {
                history: 1,
                depth: 10,
                reliability: 1,
                durability,
                deadline: endless.map(|(key, value)| (key.to_owned(), value)).into(),
                liveliness: 1,
                avoid_ros_namespace_conventions: false,
            };
            assert_eq!(found, [expected], "{text}");
        }
    }

    #[test]
    fn names_that_lead_out_are_refused() {
        for name in ["../a.mcap", "/etc/passwd", "a/../../b", ""] {
            let text = format!("rosbag2_bagfile_information:\n  relative_file_paths: ['{name}']\n");
            assert!(file_names(&text).is_err(), "{name}");
        }
        assert!(file_names("a: 1").is_err());
        assert!(file_names("\u{0}").is_err());
    }
}
