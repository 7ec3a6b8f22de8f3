//! Records of MCAP → their fields, borrowed from the bytes: a length that is only claimed costs
//! nothing. (The crate's own parser makes room for what is claimed.)
//!
//! Numbers have their lowest byte first, a text its length before it (mcap.dev/spec).

use mcap::records::op;

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
        op::METADATA if fields.text()? == "rosbag2" => {
            let length = fields.u32()?;
            let mut map = Fields(fields.bytes(length.into())?);
            let mut text = None;
            while !map.0.is_empty() {
                let (key, value) = (map.text()?, map.text()?);
                text = if key == "serialized_metadata" { Some(value) } else { text };
            }
            text.map_or(Record::Other, Record::Metadata)
        }
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
}
