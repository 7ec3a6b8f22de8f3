//! Compressed bytes → bytes, within bounds: what a few bytes claim to be fills no memory.

use std::io::Read;

/// What begins a zstd frame; no CDR message, MCAP or SQLite file begins so.
const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// What could be unpacked, and why there is no more of it.
pub(super) struct Unpacked {
    pub(super) bytes: Vec<u8>,
    pub(super) fault: Option<String>,
}

/// Whether the bytes are compressed by zstd.
pub(super) fn is_zstd(bytes: &[u8]) -> bool {
    bytes.starts_with(&ZSTD)
}

/// Unpacks zstd, up to `most` bytes.
pub(super) fn zstd(bytes: &[u8], most: u64) -> Unpacked {
    match zstd::stream::read::Decoder::new(bytes) {
        Ok(mut decoder) => {
            // A claimed window costs its size: 128 MiB is what zstd's own tools take at most.
            let bounded = decoder.window_log_max(27);
            bounded.map_or_else(|e| failed(&e), |()| read(decoder, most))
        }
        Err(error) => failed(&error),
    }
}

/// Unpacks an LZ4 frame, up to `most` bytes.
pub(super) fn lz4(bytes: &[u8], most: u64) -> Unpacked {
    lz4::Decoder::new(bytes).map_or_else(|error| failed(&error), |decoder| read(decoder, most))
}

fn failed(error: &std::io::Error) -> Unpacked {
    Unpacked { bytes: Vec::new(), fault: Some(error.to_string()) }
}

fn read(reader: impl Read, most: u64) -> Unpacked {
    let mut bytes = Vec::new();
    let mut reader = reader.take(most.saturating_add(1));
    let mut block = vec![0; 1 << 16];
    // Block by block, so that what came before a fault is kept.
    let fault = loop {
        match reader.read(&mut block) {
            Ok(0) => break None,
            Ok(count) => bytes.extend_from_slice(&block[..count]),
            Err(error) => break Some(error.to_string()),
        }
    };
    if bytes.len() as u64 > most {
        bytes.truncate(most as usize);
        return Unpacked { bytes, fault: Some(format!("more than {most} bytes come out")) };
    }
    Unpacked { bytes, fault }
}
