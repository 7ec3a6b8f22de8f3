//! MCAP → its topics and messages, one after another, and what of it is lost.
//!
//! Records follow each other: a byte that says what it is, eight that say how long, the rest.
//! Chunks are records that hold records, compressed or not, with a checksum (mcap.dev/spec). The
//! walk is ours, because a damaged file is to give what is whole.

use std::collections::BTreeMap;

use mcap::MAGIC;
use mcap::records::op;

use super::losses::{Loss, Losses};
use super::records::{ChunkHeader, Record, parse};
use super::{Event, packed};
use crate::time::Stamp;

/// No writer makes larger chunks; rosbag2's are of 1 MiB.
pub(super) const LARGEST_CHUNK: u64 = 1 << 27;
/// Of a record before it begins: what it is, and how long.
const HEAD: usize = 9;

/// What is known of a channel.
struct Channel {
    topic: String,
    type_name: String,
    encoding: String,
}

/// A file while it is walked through.
struct Walk<'a, 'b> {
    file: &'a str,
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    /// Channels that messages name and nobody defined.
    unknown: BTreeMap<u16, u64>,
    chunks: u64,
    messages: u64,
    /// How many bytes may still come out of chunks.
    budget: &'b mut u64,
    losses: &'b mut Losses,
    each: &'b mut dyn FnMut(Event<'_>),
}

/// Whether the bytes begin as MCAP does.
pub(super) fn is_mcap(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Walks through the file.
pub(super) fn walk(
    file: &str,
    bytes: &[u8],
    budget: &mut u64,
    losses: &mut Losses,
    each: &mut dyn FnMut(Event<'_>),
) {
    let mut walk = Walk {
        file,
        schemas: BTreeMap::new(),
        channels: BTreeMap::new(),
        unknown: BTreeMap::new(),
        chunks: 0,
        messages: 0,
        budget,
        losses,
        each,
    };
    // Channels that a damaged chunk defined are defined again at the end of a finished file.
    for (opcode, body) in records(summary(bytes)) {
        if matches!(opcode, op::SCHEMA | op::CHANNEL) {
            walk.record(opcode, body);
        }
    }
    walk.file(bytes);
    for (channel, messages) in std::mem::take(&mut walk.unknown) {
        walk.losses.add(Loss::Channel { file: file.to_owned(), channel, messages });
    }
}

/// The records that are whole, one after another.
fn records(bytes: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let mut rest = bytes;
    std::iter::from_fn(move || {
        let (opcode, body) = record(rest)?;
        rest = &rest[HEAD + body.len()..];
        Some((opcode, body))
    })
}

/// The record at the beginning, if it is whole.
fn record(bytes: &[u8]) -> Option<(u8, &[u8])> {
    let (&[opcode, ..], _) = bytes.split_first_chunk::<HEAD>()?;
    let body = bytes.get(HEAD..)?.get(..claimed(bytes)?)?;
    Some((opcode, body))
}

/// How long the record at the beginning says that it is.
fn claimed(bytes: &[u8]) -> Option<usize> {
    let length = bytes.get(1..HEAD)?.try_into().ok()?;
    usize::try_from(u64::from_le_bytes(length)).ok()
}

/// The section behind the data that says it all again; empty where the file has no end.
fn summary(bytes: &[u8]) -> &[u8] {
    // A footer: its head, where the summary starts, where its offsets do, checksum; then the magic.
    const FOOTER: usize = HEAD + 20 + MAGIC.len();
    let Some(at) = bytes.len().checked_sub(FOOTER).filter(|_| bytes.ends_with(MAGIC)) else {
        return &[];
    };
    let start = match record(&bytes[at..]) {
        Some((op::FOOTER, body)) => body.first_chunk().map(|start| u64::from_le_bytes(*start)),
        _ => None,
    };
    let start = start.and_then(|start| usize::try_from(start).ok()).filter(|start| *start > 0);
    start.and_then(|start| bytes.get(start..at)).unwrap_or(&[])
}

impl Walk<'_, '_> {
    fn file(&mut self, bytes: &[u8]) {
        let mut at = MAGIC.len();
        loop {
            let rest = bytes.get(at..).unwrap_or(&[]);
            let Some((opcode, body)) = record(rest) else {
                if rest.first() == Some(&op::CHUNK) && rest.len() > HEAD {
                    self.chunk(&rest[HEAD..], at, true);
                }
                let (file, at) = (self.file.to_owned(), at as u64);
                return self.losses.add(Loss::Cut { file, at, messages: self.messages });
            };
            match opcode {
                // Behind the data everything is said once more.
                op::DATA_END | op::FOOTER => return,
                op::CHUNK => self.chunk(body, at, false),
                _ => self.record(opcode, body),
            }
            at += HEAD + body.len();
        }
    }

    /// - `cut`: the chunk is not all there; what is, is taken as far as it goes.
    fn chunk(&mut self, body: &[u8], at: usize, cut: bool) {
        self.chunks += 1;
        let unpacked = self.unpacked(body, cut);
        match unpacked {
            Ok(bytes) => {
                let (before, mut left) = (self.messages, bytes.len());
                for (opcode, body) in records(&bytes) {
                    self.record(opcode, body);
                    left -= HEAD + body.len();
                }
                // Without a checksum nothing else says that a length is not as it was written.
                if left > 0 && !cut {
                    let messages = self.messages - before;
                    let (file, number) = (self.file.to_owned(), self.chunks);
                    let (at, left) = (at as u64, left as u64);
                    self.losses.add(Loss::Rest { file, number, at, left, messages });
                }
            }
            // That it is cut is told anyway.
            Err(_) if cut => {}
            Err(reason) => {
                let (file, number, at) = (self.file.to_owned(), self.chunks, at as u64);
                self.losses.add(Loss::Chunk { file, number, at, reason });
            }
        }
    }

    fn unpacked(&mut self, body: &[u8], cut: bool) -> Result<Vec<u8>, String> {
        let short = || "too short".to_owned();
        let header = ChunkHeader::read(body).ok_or_else(short)?;
        let end = usize::try_from(header.packed).ok().filter(|end| *end <= header.rest.len());
        let packed = match end {
            Some(end) => &header.rest[..end],
            None if cut => header.rest,
            None => return Err(short()),
        };
        let most = header.unpacked.min(LARGEST_CHUNK).min(*self.budget);
        if most < header.unpacked {
            return Err(format!("{} bytes would come out, more than are read", header.unpacked));
        }
        let unpacked = match header.compression {
            b"" => packed::Unpacked { bytes: packed.to_vec(), fault: None },
            b"zstd" => packed::zstd(packed, most),
            b"lz4" => packed::lz4(packed, most),
            other => {
                let other = String::from_utf8_lossy(other);
                return Err(format!("compression '{}'", super::shortened(&other)));
            }
        };
        let bytes = unpacked.bytes;
        *self.budget = self.budget.saturating_sub(bytes.len() as u64);
        if cut {
            return Ok(bytes);
        }
        if let Some(fault) = unpacked.fault {
            return Err(fault);
        }
        if bytes.len() as u64 != header.unpacked {
            return Err(format!("{} bytes instead of {}", bytes.len(), header.unpacked));
        }
        let found = crc32fast::hash(&bytes);
        if header.checksum != 0 && found != header.checksum {
            return Err(format!("checksum {found:08x} instead of {:08x}", header.checksum));
        }
        Ok(bytes)
    }

    fn record(&mut self, opcode: u8, body: &[u8]) {
        let Some(record) = parse(opcode, body) else {
            let (file, messages) = (self.file.to_owned(), self.messages);
            return self.losses.add(Loss::Record { file, opcode, messages });
        };
        match record {
            Record::Schema { id, name } => {
                self.schemas.insert(id, name.to_owned());
            }
            Record::Channel { id, schema, topic, encoding } => {
                let type_name = self.schemas.get(&schema).cloned().unwrap_or_default();
                (self.each)(Event::Topic { name: topic, type_name: &type_name });
                let (topic, encoding) = (topic.to_owned(), encoding.to_owned());
                self.channels.insert(id, Channel { topic, type_name, encoding });
            }
            Record::Message { channel, log_time, data } => match self.channels.get(&channel) {
                Some(Channel { topic, type_name, encoding }) => {
                    self.messages += 1;
                    let time = Stamp(i64::try_from(log_time).unwrap_or(i64::MAX));
                    (self.each)(Event::Message { topic, type_name, encoding, time, data });
                }
                None => *self.unknown.entry(channel).or_default() += 1,
            },
            Record::Metadata(text) => (self.each)(Event::Metadata(text)),
            Record::CustomData(words) => (self.each)(Event::CustomData(&words)),
            Record::Other => {}
        }
    }
}
