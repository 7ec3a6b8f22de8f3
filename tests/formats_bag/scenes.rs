//! Made-up recordings, and bags of any messages.

use std::collections::BTreeMap;
use std::sync::Arc;

use handover_mesh::formats::bag::{self, File, Read, Writer};
use handover_mesh::formats::{ReadError, UpAxis};
use handover_mesh::{Frame, ObjectTrack, Person, Point, Recording, Sequence, Skeleton, Stamp};

/// Between frames `[ns]`.
pub(crate) const STEP: i64 = 33_333_333;

const EIGHT: &str =
    "head torso left_shoulder left_elbow left_hand right_shoulder right_elbow right_hand";
const THIRTEEN: &str =
    "head neck chest ab hip LShoulder LUArm LFArm LHand RShoulder RUArm RFArm RHand";

pub(crate) fn skeleton(which: usize) -> Arc<Skeleton> {
    let names = |text: &str| text.split(' ').map(String::from).collect();
    match which {
        0 => Skeleton::nite(),
        1 => Arc::new(Skeleton::from_names(names(EIGHT)).unwrap()),
        _ => Arc::new(Skeleton::from_names(names(THIRTEEN)).unwrap()),
    }
}

/// Where a joint of somebody is at a frame.
pub(crate) fn place(person: usize, frame: i64, joint: usize) -> Point {
    let (person, frame, joint) = (person as f64, frame as f64, joint as f64);
    Point::new(person + 0.01 * frame, (0.1 * frame + joint).sin(), 0.1 * joint)
}

/// Two people who move.
pub(crate) fn people(frames: i64, names: [&str; 2]) -> [Person; 2] {
    let skeleton = Skeleton::nite();
    [0, 1].map(|person| {
        let frames = (0..frames).map(|frame| {
            let positions = (0..15).map(|joint| place(person, frame, joint)).collect();
            Frame { stamp: Stamp(frame * STEP), positions }
        });
        let motion = Sequence::new(skeleton.clone(), frames.collect()).unwrap();
        Person { name: names[person].to_owned(), motion }
    })
}

/// The same with an object.
pub(crate) fn recording(frames: i64, metadata: BTreeMap<String, String>) -> Recording {
    let places = (0..frames).map(|frame| (Stamp(frame * STEP), place(2, frame, 0))).collect();
    let object = ObjectTrack::of_point("cup", places);
    Recording::new("clip", people(frames, ["giver", "receiver"]), Some(object), metadata).unwrap()
}

/// Two people of one skeleton, a step `[ns]` between frames, places taken from `coordinates`.
pub(crate) fn any_recording(
    skeleton: &Arc<Skeleton>,
    steps: &[i64],
    coordinates: &[f64],
    object: &[bool],
    metadata: BTreeMap<String, String>,
) -> Recording {
    let mut coordinates = coordinates.iter().copied().cycle();
    let mut point = || {
        let mut next = || coordinates.next().unwrap();
        Point::new(next(), next(), next())
    };
    let mut stamps = vec![Stamp(-70_000_001)];
    for step in steps {
        stamps.push(Stamp(stamps[stamps.len() - 1].0 + step));
    }
    let mut person = |name: &str| {
        let mut frames = Vec::new();
        for stamp in &stamps {
            let positions = (0..skeleton.len()).map(|_| point()).collect();
            frames.push(Frame { stamp: *stamp, positions });
        }
        Person { name: name.into(), motion: Sequence::new(skeleton.clone(), frames).unwrap() }
    };
    let people = [person("giver"), person("B")];
    let known = stamps.iter().zip(object).filter(|(_, known)| **known);
    let places: Vec<_> = known.map(|(stamp, _)| (*stamp, point())).collect();
    let object = (!places.is_empty()).then(|| ObjectTrack::of_point("baton", places));
    Recording::new("clip", people, object, metadata).unwrap()
}

/// Topic, type, time and bytes of a message.
pub(crate) type Sent = (String, String, Stamp, Vec<u8>);

/// The bytes of a bag of these messages, topics as they come.
pub(crate) fn bag_of(messages: &[Sent]) -> Vec<u8> {
    let mut bag = Writer::new("made.mcap", BTreeMap::new()).unwrap();
    let mut topics = BTreeMap::new();
    for (name, type_name, time, data) in messages {
        let known = topics.get(name).copied();
        let topic = known.unwrap_or_else(|| bag.topic(name, type_name, false).unwrap());
        topics.insert(name, topic);
        bag.message(topic, *time, data).unwrap();
    }
    bag.finish().unwrap().mcap
}

/// Reads a bare file.
pub(crate) fn read(bytes: &[u8]) -> Result<Read, ReadError> {
    bag::read(&[File { name: "clip.mcap", bytes: Some(bytes) }], None, "clip", UpAxis::Z)
}
