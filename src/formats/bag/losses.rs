//! What of a damaged bag is lost.

use super::super::error::shortened;

/// Part of a bag that could not be read; the rest was.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Loss {
    /// The file ends before it says that it does.
    #[error(
        "{file} is cut off: behind byte {at} nothing is whole but what of the chunk there could be \
         unpacked ({messages} messages are)"
    )]
    Cut {
        /// Which file.
        file: String,
        /// Where the first record begins that is not whole.
        at: u64,
        /// How many messages are whole.
        messages: u64,
    },
    /// All messages of a chunk.
    #[error("{file}, chunk {number} at byte {at}: {reason}; its messages are lost")]
    Chunk {
        /// Which file.
        file: String,
        /// Which chunk, counted from 1.
        number: u64,
        /// Where it begins.
        at: u64,
        /// What is wrong with it.
        reason: String,
    },
    /// What of a chunk stands behind a record that is not whole.
    #[error(
        "{file}, chunk {number} at byte {at}: its last {left} bytes, behind {messages} messages that \
         are whole, begin with a record that is damaged; they are lost"
    )]
    Rest {
        /// Which file.
        file: String,
        /// Which chunk, counted from 1.
        number: u64,
        /// Where it begins.
        at: u64,
        /// How many bytes are lost, as they came out of the chunk.
        left: u64,
        /// How many of the chunk's messages are whole.
        messages: u64,
    },
    /// Messages of which nobody says what they are.
    #[error("{file}: {messages} messages are of channel {channel}, which the file does not define")]
    Channel {
        /// Which file.
        file: String,
        /// The channel's number.
        channel: u16,
        /// How many.
        messages: u64,
    },
    /// Rows of which nobody says what they are.
    #[error("{file}: {messages} messages are of topic {topic}, which the file does not define")]
    Topic {
        /// Which file.
        file: String,
        /// The topic's number.
        topic: i64,
        /// How many.
        messages: u64,
    },
    /// A record whose inside makes no sense.
    #[error("{file}: a record of kind {opcode} behind {messages} messages is damaged")]
    Record {
        /// Which file.
        file: String,
        /// MCAP's number of the kind.
        opcode: u8,
        /// How many messages there were before it.
        messages: u64,
    },
    /// Rows of a database.
    #[error("{file}: {reason}; {messages} messages before that are whole")]
    Rows {
        /// Which file.
        file: String,
        /// What the database says.
        reason: String,
        /// How many are whole.
        messages: u64,
    },
    /// A file that the bag should have.
    #[error("{file}: {reason}")]
    File {
        /// Which file.
        file: String,
        /// What is wrong with it.
        reason: String,
    },
    /// More of these than are told.
    #[error("... and {more} more losses")]
    More {
        /// How many.
        more: u64,
    },
}

/// Losses as they are found.
#[derive(Debug, Default)]
pub(super) struct Losses {
    kept: Vec<Loss>,
    more: u64,
}

impl Losses {
    /// How many are told one by one.
    const MOST: usize = 20;

    pub(super) fn add(&mut self, loss: Loss) {
        if self.kept.len() < Self::MOST {
            self.kept.push(loss);
        } else {
            self.more += 1;
        }
    }

    /// A file that nothing can be read of.
    pub(super) fn file(&mut self, file: &str, reason: &str) {
        self.add(Loss::File { file: file.to_owned(), reason: shortened(reason) });
    }

    pub(super) fn told(mut self) -> Vec<Loss> {
        if self.more > 0 {
            self.kept.push(Loss::More { more: self.more });
        }
        self.kept
    }
}
