//! Records of MCAP → their fields, borrowed from the bytes: a length that is only claimed costs
//! nothing. (The crate's own parser makes room for what is claimed.)
//!
//! Numbers have their lowest byte first, a text its length before it (mcap.dev/spec).

use std::collections::BTreeMap;

use mcap::records::op;

/// The name of the words about a bag that `rosbag2` writes at its end.
pub(super) const ROSBAG: &str = "rosbag2";
/// The key under which they hold the text of `metadata.yaml`.
pub(super) const ROSBAG_TEXT: &str = "serialized_metadata";
/// The name of the words about a recording that we write at its beginning.
pub(super) const CUSTOM_DATA: &str = "handover_mesh";

/// A record of the kinds that are of use.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Record<'a> {
    /// A type of messages.
    Schema { id: u16, name: &'a str },
    /// A topic.
    Channel { id: u16, schema: u16, topic: &'a str, encoding: &'a str },
    /// A message.
    Message { channel: u16, log_time: u64, data: &'a [u8] },
    /// Words about the bag, `rosbag2`'s own.
    Metadata(&'a str),
    /// Words about the bag, ours.
    CustomData(BTreeMap<&'a str, &'a str>),
    /// Of no use.
    Other,
}

/// The record, if its inside makes sense.
pub(super) fn parse(opcode: u8, body: &[u8]) -> Option<Record<'_>> {
    let mut fields = Fields(body);
    Some(match opcode {
        op::SCHEMA => Record::Schema { id: fields.u16()?, name: fields.text()? },
        op::CHANNEL => Record::Channel {
            id: fields.u16()?,
            schema: fields.u16()?,
            topic: fields.text()?,
            encoding: fields.text()?,
        },
        op::MESSAGE => {
            let (channel, _, log_time, _) =
                (fields.u16()?, fields.u32()?, fields.u64()?, fields.u64()?);
            Record::Message { channel, log_time, data: fields.0 }
        }
        op::METADATA => match fields.text()? {
            ROSBAG => match fields.map()?.remove(ROSBAG_TEXT) {
                Some(text) => Record::Metadata(text),
                None => Record::Other,
            },
            CUSTOM_DATA => Record::CustomData(fields.map()?),
            _ => Record::Other,
        },
        _ => Record::Other,
    })
}

/// What a chunk says of itself.
pub(super) struct ChunkHeader<'a> {
    /// How many bytes should come out.
    pub(super) unpacked: u64,
    /// Of what comes out; 0 if nobody reckoned it.
    pub(super) checksum: u32,
    /// The name of the compression, empty for none.
    pub(super) compression: &'a [u8],
    /// How many bytes are compressed.
    pub(super) packed: u64,
    /// They, and what stands behind.
    pub(super) rest: &'a [u8],
}

impl<'a> ChunkHeader<'a> {
    pub(super) fn read(body: &'a [u8]) -> Option<Self> {
        let mut fields = Fields(body);
        // The times of its messages, which they say themselves.
        fields.bytes(16)?;
        let (unpacked, checksum) = (fields.u64()?, fields.u32()?);
        let length = fields.u32()?;
        let compression = fields.bytes(length.into())?;
        Some(Self { unpacked, checksum, compression, packed: fields.u64()?, rest: fields.0 })
    }
}

/// What is left of a record.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn bytes(&mut self, length: u64) -> Option<&'a [u8]> {
        let (bytes, rest) = self.0.split_at_checked(usize::try_from(length).ok()?)?;
        self.0 = rest;
        Some(bytes)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (bytes, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*bytes)
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Option<&'a str> {
        let length = self.u32()?;
        std::str::from_utf8(self.bytes(length.into())?).ok()
    }

    fn map(&mut self) -> Option<BTreeMap<&'a str, &'a str>> {
        let length = self.u32()?;
        let mut entries = Fields(self.bytes(length.into())?);
        let mut map = BTreeMap::new();
        while !entries.0.is_empty() {
            map.insert(entries.text()?, entries.text()?);
        }
        Some(map)
    }
}
