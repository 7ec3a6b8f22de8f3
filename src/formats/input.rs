//! Bytes of files that somebody else opens, as many as there may be.

use std::io::{self, Read};

/// No file that is read here is larger, nor are all files of a bag together; what claims to be must
/// not fill the memory `[B]`.
pub const LARGEST: u64 = 1 << 29;

/// Why a file's bytes are not had.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// Whoever holds it says so.
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    /// Larger than [`LARGEST`].
    #[error("larger than {} MiB", LARGEST >> 20)]
    TooLarge,
}

/// All bytes of a file.
///
/// # Errors
/// [`FileError`].
pub fn bytes(file: impl Read) -> Result<Vec<u8>, FileError> {
    bytes_within(file, LARGEST)
}

/// The same where others have taken part of what there may be.
pub(super) fn bytes_within(file: impl Read, largest: u64) -> Result<Vec<u8>, FileError> {
    let mut bytes = Vec::new();
    match file.take(largest + 1).read_to_end(&mut bytes) {
        Ok(count) if count as u64 > largest => Err(FileError::TooLarge),
        Ok(_) => Ok(bytes),
        Err(error) => Err(FileError::Unreadable(error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_large_is_not_read_to_its_end() {
        assert_eq!(bytes_within(io::repeat(7).take(10), 10).unwrap(), [7; 10]);
        assert!(matches!(bytes_within(io::repeat(7), 10), Err(FileError::TooLarge)));
    }
}
