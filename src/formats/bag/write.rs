//! Messages and recordings → the bytes of a bag, the same for the same input.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions};

use super::folder::{self, TopicEntry};
use super::{definitions, people, records};
use crate::bodies::{Body, to_joint_state};
use crate::messages::{Header, Message, Pose, PoseStamped, Time, encode};
use crate::skeleton::{Part, PointTrack, Recording};
use crate::time::Stamp;

/// The frame that recordings are in.
const WORLD: &str = "world";
/// How much is lost with a chunk that is damaged `[bytes]`, before compression.
const CHUNK: u64 = 1 << 18;

/// Why a bag cannot be written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WriteError {
    /// No part of a topic's name.
    #[error("'{name}' cannot be part of a topic's name (letters, digits and '_', no digit first)")]
    Name {
        /// Of the person or the object.
        name: String,
    },
    /// A joint that no reader knows, so its bones would be lost.
    #[error("'{person}' has a joint '{joint}' that a bag cannot hold: its name is not known")]
    UnknownJoint {
        /// Whose joint.
        person: String,
        /// Its name.
        joint: String,
    },
    /// A pose says where one point is.
    #[error(
        "the object has {points} points, and a bag has one pose for it (hint: a CSV holds all)"
    )]
    ObjectPoints {
        /// How many it has.
        points: usize,
    },
    /// Beyond what a message's stamp can say.
    #[error("stamp {stamp} is beyond ±68 years")]
    Stamp {
        /// The stamp.
        stamp: Stamp,
    },
    /// A word about the clip under a name that means something else.
    #[error("metadata '{key}' is a name that bags use themselves")]
    Metadata {
        /// The name.
        key: String,
    },
    /// A type that nobody defines.
    #[error("type '{type_name}' is not known")]
    Type {
        /// The type.
        type_name: String,
    },
    /// More topics than a bag has, or memory than there is.
    #[error("cannot be written: {reason}")]
    Mcap {
        /// What the writer says.
        reason: String,
    },
}

impl From<mcap::McapError> for WriteError {
    fn from(error: mcap::McapError) -> Self {
        Self::Mcap { reason: error.to_string() }
    }
}

/// A bag as files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// The MCAP file, a bag by itself.
    pub mcap: Vec<u8>,
    /// The text of `metadata.yaml` beside it in a folder.
    pub metadata: String,
}

/// Messages on their way into a bag.
///
/// ```
/// use handover_mesh::Stamp;
/// use handover_mesh::formats::bag::{File, Writer, messages};
/// use handover_mesh::messages::{Message, Text, encode};
/// let mut bag = Writer::new("talk_0.mcap", Default::default())?;
/// let topic = bag.topic("/state", Text::TYPE, true)?;
/// bag.message(topic, Stamp(7), &encode(&Text { data: "approach".to_owned() }))?;
/// let written = bag.finish()?;
/// let file = File { name: "talk_0.mcap", bytes: Some(&written.mcap) };
/// let mut found = Vec::new();
/// messages(&[file], |message| found.push((message.topic.to_owned(), message.time)))?;
/// assert_eq!(found, [("/state".to_owned(), Stamp(7))]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Writer {
    file: String,
    mcap: mcap::Writer<Cursor<Vec<u8>>>,
    custom_data: BTreeMap<String, String>,
    topics: Vec<Topic>,
    between: Option<[Stamp; 2]>,
}

struct Topic {
    name: String,
    type_name: String,
    latched: bool,
    channel: u16,
    messages: u64,
}

/// A topic of a [`Writer`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TopicId(usize);

impl Writer {
    /// An empty bag.
    ///
    /// - `file`: the name that the metadata give the MCAP file.
    /// - `custom_data`: what is to be known of it; it stands at both ends, so that a bag that is cut
    ///   off keeps it.
    ///
    /// # Errors
    /// [`WriteError::Mcap`], if there is no memory.
    pub fn new(file: &str, custom_data: BTreeMap<String, String>) -> Result<Self, WriteError> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library("handover_mesh")
            .chunk_size(Some(CHUNK))
            .compression(Some(Compression::Zstd))
            // More would make bytes depend on the machine.
            .compression_threads(0);
        let mut mcap = options.create(Cursor::new(Vec::new()))?;
        if !custom_data.is_empty() {
            let (name, metadata) = (records::CUSTOM_DATA.to_owned(), custom_data.clone());
            mcap.write_metadata(&Metadata { name, metadata })?;
        }
        let file = file.to_owned();
        Ok(Self { file, mcap, custom_data, topics: Vec::new(), between: None })
    }

    /// Adds a topic.
    ///
    /// - `type_name`: of a type of [`crate::messages`].
    /// - `latched`: whoever subscribes when it is played hears the last message at once.
    ///
    /// # Errors
    /// [`WriteError::Type`] of a type that is not ours; [`WriteError::Mcap`].
    pub fn topic(
        &mut self,
        name: &str,
        type_name: &str,
        latched: bool,
    ) -> Result<TopicId, WriteError> {
        let known = definitions::definition(type_name).zip(definitions::hash(type_name));
        let Some((definition, hash)) = known else {
            return Err(WriteError::Type { type_name: type_name.to_owned() });
        };
        let schema = self.mcap.add_schema(type_name, "ros2msg", definition.as_bytes())?;
        let metadata = [
            ("offered_qos_profiles".to_owned(), folder::qos(latched)),
            ("topic_type_hash".to_owned(), hash.to_owned()),
        ];
        let channel = self.mcap.add_channel(schema, name, "cdr", &metadata.into())?;
        let (name, type_name) = (name.to_owned(), type_name.to_owned());
        self.topics.push(Topic { name, type_name, latched, channel, messages: 0 });
        Ok(TopicId(self.topics.len() - 1))
    }

    /// Adds a message; those of all topics in the order of their times.
    ///
    /// - `time`: when it was received; before the epoch counts as at it.
    /// - `data`: as [`encode`] makes it.
    ///
    /// # Errors
    /// [`WriteError::Mcap`].
    ///
    /// # Panics
    /// If the topic is another writer's.
    pub fn message(&mut self, topic: TopicId, time: Stamp, data: &[u8]) -> Result<(), WriteError> {
        let topic = &mut self.topics[topic.0];
        let time = Stamp(time.0.max(0));
        let header = MessageHeader {
            channel_id: topic.channel,
            // Counts up to four thousand million messages of a topic.
            sequence: topic.messages as u32,
            log_time: time.0 as u64,
            publish_time: time.0 as u64,
        };
        self.mcap.write_to_known_channel(&header, data)?;
        topic.messages += 1;
        let [start, end] = self.between.unwrap_or([time; 2]);
        self.between = Some([start.min(time), end.max(time)]);
        Ok(())
    }

    /// The bag's bytes.
    ///
    /// # Errors
    /// [`WriteError::Mcap`].
    pub fn finish(mut self) -> Result<Written, WriteError> {
        let topics = self.topics.iter().map(|topic| TopicEntry {
            name: &topic.name,
            type_name: &topic.type_name,
            hash: definitions::hash(&topic.type_name).unwrap_or_default(),
            latched: topic.latched,
            messages: topic.messages,
        });
        let topics: Vec<TopicEntry<'_>> = topics.collect();
        let between = self.between.unwrap_or_default();
        let metadata = folder::text(&self.file, &topics, between, &self.custom_data);
        self.mcap.write_metadata(&Metadata {
            name: records::ROSBAG.to_owned(),
            metadata: [(records::ROSBAG_TEXT.to_owned(), metadata.clone())].into(),
        })?;
        self.mcap.finish()?;
        let mcap = self.mcap.into_inner().into_inner();
        Ok(Written { mcap, metadata: folder::as_file(&metadata) })
    }
}

/// Writes a recording: `/{person}/skeleton` for each, perhaps `/{object}/object_pose`.
///
/// [`read`](super::read) gives the same recording back, names, stamps and coordinates to the bit, if
/// its joints are in canonical order as every reader leaves them, within 1000 m, and its object is
/// at frames' stamps. What rides on a joint is left out: it says no more than the joint and the
/// object do.
///
/// - `file`: the name that the metadata give the MCAP file.
///
/// # Errors
/// [`WriteError`] if the recording holds what a bag cannot.
pub fn write(recording: &Recording, file: &str) -> Result<Written, WriteError> {
    check(recording)?;
    let mut custom_data = recording.metadata().clone();
    let names = recording.people().each_ref().map(|person| person.name.clone());
    let names = serde_json::Value::from(names.to_vec()).to_string();
    custom_data.insert(people::PEOPLE.to_owned(), names);
    let mut bag = Writer::new(file, custom_data)?;
    let mut skeletons = Vec::new();
    for person in recording.people() {
        let name = format!("/{}/skeleton", person.name);
        skeletons.push(bag.topic(&name, crate::messages::MultiDofJointState::TYPE, false)?);
    }
    let mut object = match point(recording)? {
        Some(object) => {
            let name = format!("/{}/object_pose", object.name);
            let topic = bag.topic(&name, PoseStamped::TYPE, false)?;
            Some((topic, object.places.iter().peekable()))
        }
        None => None,
    };
    for (number, stamp) in recording.stamps().enumerate() {
        while let Some((topic, places)) = &mut object
            && let Some((time, place)) = places.next_if(|(time, _)| *time < stamp)
        {
            bag.message(*topic, *time, &encode(&pose(*time, *place)))?;
        }
        for (person, topic) in recording.people().iter().zip(&skeletons) {
            let skeleton = person.motion.skeleton();
            let names = skeleton.names().iter().cloned();
            let places = person.motion.frames()[number].positions.iter().copied();
            let joints = names.zip(places).take(skeleton.own()).collect();
            let body = Body { stamp, frame: WORLD.to_owned(), id: None, joints };
            bag.message(*topic, stamp, &encode(&to_joint_state(&body)))?;
        }
    }
    if let Some((topic, places)) = object {
        for (time, place) in places {
            bag.message(topic, *time, &encode(&pose(*time, *place)))?;
        }
    }
    bag.finish()
}

/// The only point of the object.
fn point(recording: &Recording) -> Result<Option<&PointTrack>, WriteError> {
    match recording.object().map(|object| &object.points[..]) {
        None | Some([]) => Ok(None),
        Some([point]) => Ok(Some(point)),
        Some(points) => Err(WriteError::ObjectPoints { points: points.len() }),
    }
}

fn pose(stamp: Stamp, place: crate::geometry::Point) -> PoseStamped {
    let header = Header { stamp: Time::of(stamp), frame_id: WORLD.to_owned() };
    PoseStamped { header, pose: Pose { position: place.into(), ..Pose::default() } }
}

fn check(recording: &Recording) -> Result<(), WriteError> {
    let names = recording.people().iter().map(|person| &person.name);
    let object = point(recording)?;
    for name in names.chain(object.map(|point| &point.name)) {
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            || !name.chars().all(is_part)
        {
            return Err(WriteError::Name { name: name.clone() });
        }
    }
    for person in recording.people() {
        let skeleton = person.motion.skeleton();
        for joint in &skeleton.names()[..skeleton.own()] {
            if Part::from_name(joint).is_none() {
                let (person, joint) = (person.name.clone(), joint.clone());
                return Err(WriteError::UnknownJoint { person, joint });
            }
        }
    }
    let places = object.into_iter().flat_map(|point| &point.places);
    let stamps = recording.stamps().chain(places.map(|(stamp, _)| *stamp));
    if let Some(stamp) = stamps.into_iter().find(|stamp| Time::of(*stamp).stamp() != *stamp) {
        return Err(WriteError::Stamp { stamp });
    }
    match recording.metadata().get_key_value(people::PEOPLE) {
        Some((key, _)) => Err(WriteError::Metadata { key: key.clone() }),
        None => Ok(()),
    }
}
