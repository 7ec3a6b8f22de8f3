//! Messages of a bag → who was where, by topic; what is of no use to us is counted and forgotten.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::super::error::{Place, Reason, Violations};
use super::{Event, folder, shortened};
use crate::bodies::{Body, TransformAssembler, from_joint_state, from_markers, from_trajectory};
use crate::frames::FrameTree;
use crate::geometry::Point;
use crate::messages::{
    MarkerArray, Message, MessageError, MultiDofJointState, MultiDofTrajectory, PoseStamped,
    TransformTree, decode,
};
use crate::time::Stamp;

/// What the bodies of a track are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// Somebody's skeleton.
    Skeleton,
    /// Where a robot's joints are.
    Robot,
    /// Where a robot's joints are to be.
    Targets,
    Markers,
    Transforms,
    /// One joint, the object.
    Object,
}

/// Bodies of one kind and number on one topic.
#[derive(Debug)]
pub(super) struct Track {
    pub(super) topic: String,
    pub(super) id: Option<u32>,
    pub(super) seen: Vec<Seen>,
}

/// One of them; what is mostly the same is shared, so that it takes less memory than its message.
#[derive(Debug, Clone)]
pub(super) struct Seen {
    /// Of its message, counted from 1.
    pub(super) number: u64,
    pub(super) stamp: Stamp,
    pub(super) frame: Arc<str>,
    /// Of the joints that are tracked.
    pub(super) names: Arc<[String]>,
    /// One for each name.
    pub(super) places: Box<[Point]>,
}

impl Track {
    fn add(&mut self, number: u64, body: Body) {
        let (names, places): (Vec<String>, Vec<Point>) = body.joints.into_iter().unzip();
        let last = self.seen.last();
        let same = last.map(|last| last.names.clone()).filter(|last| **last == *names);
        let frame = last.map(|last| last.frame.clone()).filter(|last| **last == *body.frame);
        self.seen.push(Seen {
            number,
            stamp: body.stamp,
            frame: frame.unwrap_or_else(|| body.frame.into()),
            names: same.unwrap_or_else(|| names.into()),
            places: places.into(),
        });
    }
}

impl Seen {
    /// Whether another message said the same.
    pub(super) fn same(&self, other: &Self) -> bool {
        self.stamp == other.stamp
            && self.frame == other.frame
            && self.names == other.names
            && self.places == other.places
    }
}

/// What is known of a topic.
#[derive(Debug, Clone)]
struct Topic {
    order: usize,
    type_name: String,
    messages: u64,
}

/// All that is of use.
#[derive(Default)]
pub(super) struct Collected {
    /// In the order in which they were declared.
    order: Vec<String>,
    topics: BTreeMap<String, Topic>,
    tracks: BTreeMap<(Kind, usize, Option<u32>), Track>,
    assemblers: BTreeMap<String, TransformAssembler>,
    pub(super) frames: FrameTree,
    pub(super) custom_data: BTreeMap<String, String>,
    pub(super) violations: Violations,
}

/// How many topics a message tells.
const MOST_TOPICS: usize = 30;

impl Collected {
    pub(super) fn take(&mut self, event: Event<'_>) {
        match event {
            Event::Topic { name, type_name } => {
                self.topic(name, type_name);
            }
            Event::Message { topic, type_name, encoding, data, .. } => {
                let known = self.topic(topic, type_name);
                known.messages += 1;
                let (order, number) = (known.order, known.messages);
                if let Some(kind) = kind(topic, type_name) {
                    if encoding != "cdr" {
                        let reason = format!("encoding '{}', not cdr", shortened(encoding));
                        self.bad(topic, number, Reason::NoBag { reason });
                    } else if let Err(error) = self.message(kind, topic, order, number, data) {
                        self.bad(topic, number, error);
                    }
                }
            }
            Event::Metadata(text) => {
                // The first is the folder's own; files repeat it.
                if self.custom_data.is_empty() {
                    self.custom_data = folder::custom_data(text);
                }
            }
            Event::CustomData(words) => {
                if self.custom_data.is_empty() {
                    let owned = |(key, word): (&&str, &&str)| ((*key).into(), (*word).into());
                    self.custom_data = words.iter().map(owned).collect();
                }
            }
        }
    }

    fn topic(&mut self, name: &str, type_name: &str) -> &mut Topic {
        if !self.topics.contains_key(name) {
            self.order.push(name.to_owned());
        }
        let order = self.order.len().saturating_sub(1);
        let new = || Topic { order, type_name: type_name.to_owned(), messages: 0 };
        self.topics.entry(name.to_owned()).or_insert_with(new)
    }

    fn bad(&mut self, topic: &str, number: u64, reason: Reason) {
        self.violations.add(Place::Message { topic: topic.to_owned(), number }, reason);
    }

    fn message(
        &mut self,
        kind: Use,
        topic: &str,
        order: usize,
        number: u64,
        data: &[u8],
    ) -> Result<(), Reason> {
        let mut add = |kind: Kind, body: Body| {
            let id = body.id;
            let track = self.tracks.entry((kind, order, id));
            let empty = || Track { topic: topic.to_owned(), id, seen: Vec::new() };
            track.or_insert_with(empty).add(number, body);
        };
        match kind {
            Use::Skeleton => add(Kind::Skeleton, from_joint_state(&read(data)?)?),
            Use::Robot => add(Kind::Robot, from_joint_state(&read(data)?)?),
            Use::Targets => add(Kind::Targets, from_trajectory(&read(data)?)?),
            Use::Markers => {
                from_markers(&read(data)?).into_iter().for_each(|body| add(Kind::Markers, body));
            }
            Use::Transforms => {
                let assembler = self.assemblers.entry(topic.to_owned()).or_default();
                let tree = read(data)?;
                self.frames.record(&tree);
                let bodies = assembler.take(&tree);
                bodies.into_iter().for_each(|body| add(Kind::Transforms, body));
            }
            Use::Statics => self.frames.fix(&read(data)?),
            Use::Object => {
                let pose: PoseStamped = read(data)?;
                let place = pose.pose.position.into();
                let body = Body {
                    stamp: pose.header.stamp.stamp(),
                    frame: pose.header.frame_id.trim_start_matches('/').to_owned(),
                    id: None,
                    joints: vec![("object".to_owned(), place)],
                };
                add(Kind::Object, body);
            }
        }
        Ok(())
    }

    /// No message follows: what was not whole is now.
    pub(super) fn finish(&mut self) {
        self.frames.sort();
        for (topic, mut assembler) in std::mem::take(&mut self.assemblers) {
            let known = self.topic(&topic, TransformTree::TYPE);
            let (order, number) = (known.order, known.messages);
            for body in assembler.finish() {
                let id = body.id;
                let track = self.tracks.entry((Kind::Transforms, order, id));
                let empty = || Track { topic: topic.clone(), id, seen: Vec::new() };
                track.or_insert_with(empty).add(number, body);
            }
        }
        for ((kind, ..), track) in &mut self.tracks {
            if *kind == Kind::Transforms {
                // A body that turned out to have more joints was handed out again.
                track.seen.reverse();
                track.seen.dedup_by_key(|seen| seen.stamp);
                track.seen.reverse();
            }
        }
        // One joint alone is somebody else's frame that happens to be called so.
        self.tracks.retain(|(kind, ..), track| {
            *kind != Kind::Transforms || track.seen.iter().any(|seen| seen.names.len() > 1)
        });
    }

    /// Takes out the tracks of a kind, in the order of their topics and numbers.
    pub(super) fn tracks(&mut self, kind: Kind) -> Vec<Track> {
        let keys: Vec<_> = self.tracks.keys().filter(|key| key.0 == kind).copied().collect();
        keys.iter().filter_map(|key| self.tracks.remove(key)).collect()
    }

    /// `/a (type, 3 messages), …`
    pub(super) fn listed(&self) -> String {
        let shown = self.order.iter().take(MOST_TOPICS).filter_map(|name| {
            let Topic { type_name, messages, .. } = self.topics.get(name)?;
            let (name, type_name) = (shortened(name), shortened(type_name));
            Some(format!("{name} ({type_name}, {messages})"))
        });
        let mut text = shown.collect::<Vec<_>>().join(", ");
        if self.order.len() > MOST_TOPICS {
            text += &format!(" and {} more", self.order.len() - MOST_TOPICS);
        }
        text
    }
}

/// What a message is taken for.
#[derive(Clone, Copy)]
enum Use {
    Skeleton,
    Robot,
    Targets,
    Markers,
    Transforms,
    Statics,
    Object,
}

/// By the type and the last part of the topic's name.
fn kind(topic: &str, type_name: &str) -> Option<Use> {
    let last = topic.rsplit('/').next()?;
    match (type_name, last) {
        (MultiDofJointState::TYPE, "skeleton") => Some(Use::Skeleton),
        (MultiDofJointState::TYPE, "robot_skeleton") => Some(Use::Robot),
        (MultiDofTrajectory::TYPE, "joint_targets") => Some(Use::Targets),
        (MarkerArray::TYPE, "skeleton_markers" | "body_tracking_data") => Some(Use::Markers),
        (TransformTree::TYPE, "tf") => Some(Use::Transforms),
        (TransformTree::TYPE, "tf_static") => Some(Use::Statics),
        (PoseStamped::TYPE, "object_pose") => Some(Use::Object),
        _ => None,
    }
}

fn read<M: Message>(data: &[u8]) -> Result<M, MessageError> {
    decode(data)
}
