//! Lines `# key=value` before the header ↔ a clip's metadata.
//!
//! What would end a line or a key, and blanks at the ends, are written as `%` and two hexadecimal
//! digits, so any words survive. Comments without `=` say nothing to us.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::super::detect::without_mark;

/// The metadata alone, without looking at the rows: cheap, and there even if the rows are bad.
///
/// Of a key given twice the last value counts.
///
/// ```
/// use handover_mesh::formats::csv::metadata;
/// let found = metadata(b"# class=07\n# made by hand\n#pair = s01s02\nframe,time_s\n# a=b\n");
/// assert_eq!(found.len(), 2);
/// assert_eq!((found["class"].as_str(), found["pair"].as_str()), ("07", "s01s02"));
/// ```
pub fn metadata(bytes: &[u8]) -> BTreeMap<String, String> {
    let lines = without_mark(bytes).split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    let comments = lines
        .take_while(|line| line.is_empty() || line.starts_with(b"#"))
        .filter_map(|line| std::str::from_utf8(line).ok()?.strip_prefix('#')?.split_once('='));
    comments.map(|(key, value)| (decoded(key.trim()), decoded(value.trim()))).collect()
}

/// The lines that [`metadata`] reads back as the same, sorted by key.
pub(super) fn lines(metadata: &BTreeMap<String, String>) -> String {
    let mut lines = String::new();
    for (key, value) in metadata {
        lines.push_str("# ");
        encode(key, &mut lines);
        lines.push('=');
        encode(value, &mut lines);
        lines.push('\n');
    }
    lines
}

fn encode(text: &str, out: &mut String) {
    let last = text.chars().count().saturating_sub(1);
    for (at, letter) in text.chars().enumerate() {
        let at_end = (at == 0 || at == last) && letter.is_whitespace();
        if letter.is_control() || matches!(letter, '%' | '=') || at_end {
            for byte in letter.encode_utf8(&mut [0; 4]).bytes() {
                // Writing to a String cannot fail.
                let _ = write!(out, "%{byte:02X}");
            }
        } else {
            out.push(letter);
        }
    }
}

/// The text with `%41` as `A`; as it stands where that would be no text.
fn decoded(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        let digits = bytes.get(at + 1..at + 3).and_then(|pair| std::str::from_utf8(pair).ok());
        // from_str_radix takes a sign too, which is no digit.
        let digits = digits.filter(|pair| pair.bytes().all(|b| b.is_ascii_hexdigit()));
        match digits.and_then(|pair| u8::from_str_radix(pair, 16).ok()).filter(|_| byte == b'%') {
            Some(value) => {
                out.push(value);
                at += 3;
            }
            None => {
                out.push(byte);
                at += 1;
            }
        }
    }
    String::from_utf8(out).unwrap_or_else(|_| text.into())
}
