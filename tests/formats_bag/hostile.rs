//! Damaged bags: whatever the bytes, what is whole is read, what is lost named, nothing panics.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use handover_mesh::Stamp;
use handover_mesh::formats::bag::{self, File, Loss};
use handover_mesh::formats::{ReadError, UpAxis};
use handover_mesh::messages::{MultiDofJointState, decode};
use proptest::prelude::*;

use super::scenes::{Sent, bag_of, read, recording};

/// What is known of the clip.
fn known() -> BTreeMap<String, String> {
    [("class", "handover"), ("pair", "s01s02")].map(|(a, b)| (a.to_owned(), b.to_owned())).into()
}

/// Half a minute: several chunks.
fn whole() -> &'static [u8] {
    static WHOLE: OnceLock<Vec<u8>> = OnceLock::new();
    WHOLE.get_or_init(|| bag::write(&recording(900, known()), "clip_0.mcap").unwrap().mcap)
}

fn small() -> Vec<u8> {
    bag::write(&recording(6, BTreeMap::new()), "clip_0.mcap").unwrap().mcap
}

#[test]
fn a_bag_cut_anywhere_gives_what_is_whole() {
    let bytes = whole();
    let (mut least, mut none, mut lost) = (0, 0, 0);
    for cut in (0..bytes.len()).step_by(997) {
        match read(&bytes[..cut]) {
            Ok(found) => {
                let frames = found.recording.len();
                assert!(frames >= least, "{cut}: more bytes, fewer frames");
                least = frames;
                match &found.losses[..] {
                    [Loss::Cut { .. }] => lost += 1,
                    // Only what is said twice is missing.
                    [] => assert_eq!(frames, 900, "{cut}"),
                    other => panic!("{cut}: {other:?}"),
                }
                assert_eq!(found.recording.metadata(), &known(), "{cut}");
                let at = frames - 1;
                let place = found.recording.people()[1].motion.frames()[at].positions[14];
                assert_eq!(place, super::scenes::place(1, at as i64, 14));
            }
            Err(error) => {
                assert_eq!(least, 0, "{cut}: {error}");
                none += 1;
            }
        }
    }
    assert!(least == 900 && lost > 50 && none > 0, "{least} {lost} {none}");
}

#[test]
fn a_small_bag_cut_at_every_byte_never_panics() {
    let bytes = small();
    for cut in 0..bytes.len() {
        if let Ok(found) = read(&bytes[..cut]) {
            assert!(found.recording.len() <= 6);
        }
    }
}

#[test]
fn a_chunk_that_is_damaged_is_named_and_the_rest_read() {
    let mut bytes = whole().to_vec();
    // In the middle of the second chunk.
    let second = chunks(&bytes)[1];
    bytes[second.0 + second.1 / 2] ^= 0x55;
    let found = read(&bytes).unwrap();
    let [Loss::Chunk { number: 2, at, .. }] = &found.losses[..] else {
        panic!("{:?}", found.losses)
    };
    assert_eq!(*at, second.0 as u64);
    let frames = found.recording.len();
    assert!((300..900).contains(&frames), "{frames}");
    // The first chunk has what says what the channels are; the end of the file has it too.
    let mut bytes = whole().to_vec();
    let first = chunks(&bytes)[0];
    bytes[first.0 + first.1 / 2] ^= 0x55;
    let found = read(&bytes).unwrap();
    assert!(matches!(found.losses[..], [Loss::Chunk { number: 1, .. }]), "{:?}", found.losses);
    assert!(found.recording.len() > 300 && found.recording.stamps().next() > Some(Stamp(0)));
}

#[test]
fn without_a_checksum_what_is_behind_a_damaged_length_is_lost_and_said() {
    let options = mcap::WriteOptions::new().compression(None).calculate_chunk_crcs(false);
    let bytes = remade(options);
    let found = read(&bytes).unwrap();
    assert_eq!((found.recording.len(), found.losses.len()), (6, 0));
    // The messages in the one chunk; of the tenth the length is changed.
    let [(at, length)] = chunks(&bytes)[..] else { panic!("one chunk") };
    let checksum = at + 9 + 24;
    assert_eq!(bytes[checksum..checksum + 4], [0; 4]);
    // Its name is empty: 4 bytes of length, then 8 of the records'.
    let mut record = checksum + 4 + 4 + 8;
    let mut starts = Vec::new();
    while record < at + length {
        if bytes[record] == 5 {
            starts.push(record);
        }
        record +=
            9 + u64::from_le_bytes(bytes[record + 1..record + 9].try_into().unwrap()) as usize;
    }
    assert_eq!((starts.len(), record), (18, at + length));
    for claim in [u64::MAX, 1 << 40, length as u64] {
        let mut bytes = bytes.clone();
        bytes[starts[9] + 1..starts[9] + 9].copy_from_slice(&claim.to_le_bytes());
        let found = read(&bytes).unwrap();
        let left = (at + length - starts[9]) as u64;
        let rest = Loss::Rest {
            file: "clip.mcap".to_owned(),
            number: 1,
            at: at as u64,
            left,
            messages: 9,
        };
        assert_eq!(found.losses, [rest], "{claim}");
        assert_eq!(found.recording.len(), 3);
    }
    // A length that leaves no room for the next record's head.
    let mut bytes = bytes.clone();
    let last = starts[17];
    let claim = (at + length - last - 9 - 4) as u64;
    bytes[last + 1..last + 9].copy_from_slice(&claim.to_le_bytes());
    let raw = File { name: "clip.mcap", bytes: Some(&bytes) };
    let losses = bag::messages(&[raw], |_| {}).unwrap();
    assert!(matches!(losses[..], [Loss::Rest { left: 4, messages: 18, .. }]), "{losses:?}");
}

/// Where chunks begin, and how long they are.
fn chunks(bytes: &[u8]) -> Vec<(usize, usize)> {
    let (mut found, mut at) = (Vec::new(), 8);
    while let Some(head) = bytes.get(at..at + 9) {
        let length = u64::from_le_bytes(head[1..].try_into().unwrap()) as usize + 9;
        if head[0] == 6 {
            found.push((at, length));
        }
        at += length;
    }
    found
}

#[test]
fn claimed_sizes_fill_no_memory_of_bags() {
    let bytes = small();
    let chunk = (8..).find(|at| bytes[*at] == 6).unwrap();
    // Of the record, of what comes out of the chunk, and of what is in it.
    for at in [chunk + 1, chunk + 9 + 16, chunk + 9 + 36] {
        for claim in [u64::MAX, u64::MAX / 2, 1 << 40, 1 << 33, 1 << 27, 0] {
            let mut bytes = bytes.clone();
            bytes[at..at + 8].copy_from_slice(&claim.to_le_bytes());
            check_memory(&bytes);
        }
    }
    // What claims to be empty, and is a gigabyte of zeros.
    let zeros = vec![0; 1 << 20];
    let bomb = zstd::encode_all(&zeros[..], 1).unwrap();
    let mut chunk = [0_u64.to_le_bytes(), 0_u64.to_le_bytes(), 100_u64.to_le_bytes()].concat();
    chunk.extend([0, 0, 0, 0, 4, 0, 0, 0]);
    chunk.extend(b"zstd");
    chunk.extend((1024 * bomb.len() as u64).to_le_bytes());
    (0..1024).for_each(|_| chunk.extend(&bomb));
    let mut bytes = b"\x89MCAP0\r\n\x06".to_vec();
    bytes.extend((chunk.len() as u64).to_le_bytes());
    bytes.extend(chunk);
    check_memory(&bytes);
}

/// Reads, and takes no more memory at a time than a small multiple of the bytes and some blocks.
#[track_caller]
fn check_memory(bytes: &[u8]) {
    let used = allocation_counter::measure(|| drop(read(bytes)));
    let most = 64 * bytes.len() as u64 + (8 << 20);
    assert!(used.bytes_max <= most, "{} bytes for {}", used.bytes_max, bytes.len());
}

#[test]
fn big_endian_messages_are_read_too() {
    let bytes = small();
    let mut messages: Vec<Sent> = Vec::new();
    let file = File { name: "clip", bytes: Some(&bytes) };
    bag::messages(&[file], |raw| {
        let data = match decode::<MultiDofJointState>(raw.data) {
            Ok(message) if raw.topic.ends_with("skeleton") => big_endian(&message),
            _ => raw.data.to_vec(),
        };
        messages.push((raw.topic.to_owned(), raw.type_name.to_owned(), raw.time, data));
    })
    .unwrap();
    assert!(messages.iter().filter(|message| message.3[1] == 0).count() == 12);
    let found = read(&bag_of(&messages)).unwrap();
    assert_eq!(found.recording.people(), recording(6, BTreeMap::new()).people());
}

/// By hand: `00 00`, then every number with its highest byte first.
fn big_endian(message: &MultiDofJointState) -> Vec<u8> {
    let mut out = vec![0, 0, 0, 0];
    let align = |out: &mut Vec<u8>, to: usize| {
        while !(out.len() - 4).is_multiple_of(to) {
            out.push(0);
        }
    };
    let number = |out: &mut Vec<u8>, value: u32| {
        align(out, 4);
        out.extend(value.to_be_bytes());
    };
    let text = |out: &mut Vec<u8>, text: &str| {
        number(out, text.len() as u32 + 1);
        out.extend(text.bytes().chain([0]));
    };
    let stamp = message.header.stamp;
    number(&mut out, stamp.sec as u32);
    number(&mut out, stamp.nanosec);
    text(&mut out, &message.header.frame_id);
    number(&mut out, message.joint_names.len() as u32);
    message.joint_names.iter().for_each(|name| text(&mut out, name));
    number(&mut out, message.transforms.len() as u32);
    for transform in &message.transforms {
        let (t, q) = (transform.translation, transform.rotation);
        align(&mut out, 8);
        for value in [t.x, t.y, t.z, q.x, q.y, q.z, q.w] {
            out.extend(value.to_be_bytes());
        }
    }
    number(&mut out, 0);
    number(&mut out, 0);
    out
}

/// The small bag without chunks, so that no checksum stands before the records.
fn bare() -> Vec<u8> {
    remade(mcap::WriteOptions::new().use_chunks(false))
}

/// The small bag written by somebody else.
fn remade(options: mcap::WriteOptions) -> Vec<u8> {
    let small = small();
    let mut out = options.profile("ros2").create(std::io::Cursor::new(Vec::new())).unwrap();
    let file = File { name: "clip", bytes: Some(&small) };
    bag::messages(&[file], |raw| {
        let schema = out.add_schema(raw.type_name, "ros2msg", b"float64 x").unwrap();
        let metadata = [("a".to_owned(), "b".to_owned())].into();
        let channel = out.add_channel(schema, raw.topic, "cdr", &metadata).unwrap();
        let header = mcap::records::MessageHeader {
            channel_id: channel,
            sequence: 0,
            log_time: raw.time.0 as u64,
            publish_time: 0,
        };
        out.write_to_known_channel(&header, raw.data).unwrap();
    })
    .unwrap();
    let metadata = [("serialized_metadata".to_owned(), "custom_data: {a: b}".to_owned())].into();
    out.write_metadata(&mcap::records::Metadata { name: "rosbag2".to_owned(), metadata }).unwrap();
    out.finish().unwrap();
    out.into_inner().into_inner()
}

#[test]
fn a_bag_without_chunks_is_read() {
    let found = read(&bare()).unwrap();
    assert_eq!(found.recording.people(), recording(6, BTreeMap::new()).people());
    assert_eq!(found.recording.metadata()["a"], "b");
}

#[test]
fn lengths_inside_records_fill_no_memory() {
    let bytes = bare();
    // Wherever a length may stand, up to the first messages.
    for at in 8..1500 {
        let mut bytes = bytes.clone();
        bytes[at..at + 4].copy_from_slice(&[0xff; 4]);
        check_memory(&bytes);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn flipped_bytes_of_bags_without_chunks_never_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        static BARE: OnceLock<Vec<u8>> = OnceLock::new();
        let mut bytes = BARE.get_or_init(bare).clone();
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        check_memory(&bytes);
    }

    #[test]
    fn flipped_bytes_of_bags_never_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        static SMALL: OnceLock<Vec<u8>> = OnceLock::new();
        let mut bytes = SMALL.get_or_init(small).clone();
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Err(error) = read(&bytes) {
            prop_assert!(!error.violations().is_empty());
            prop_assert!(error.violations().len() <= ReadError::MOST);
        }
    }

    #[test]
    fn any_bytes_of_bags_never_panic(
        magic in 0..4_usize,
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        metadata in ".{0,60}",
    ) {
        let magic: &[u8] = match magic {
            0 => b"",
            1 => b"\x89MCAP0\r\n",
            2 => b"SQLite format 3\0",
            _ => b"\x28\xb5\x2f\xfd",
        };
        let bytes = [magic, &bytes].concat();
        let file = File { name: "clip", bytes: Some(&bytes) };
        let _ = bag::read(&[file, File { name: "gone", bytes: None }], Some(&metadata), "clip", UpAxis::Y);
        let _ = bag::file_names(&metadata);
    }
}
