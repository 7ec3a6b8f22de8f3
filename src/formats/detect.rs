//! The first bytes or the first line of a file → which format it is.

use std::fmt;

use super::error::{ReadError, Reason, shortened};
use super::{amc, bag, sbu};

/// A format that recordings are read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// `frame,time_s,person,joint,x,y,z`.
    Csv,
    /// SBU Kinect Interaction: 91 numbers a line.
    Sbu,
    /// A bag of rosbag2 in MCAP files.
    Mcap,
    /// A bag of rosbag2 in SQLite3 files.
    Sqlite,
}

impl fmt::Display for Format {
    /// `CSV`, `SBU text`, `MCAP bag`, `SQLite3 bag`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Csv => "CSV",
            Self::Sbu => "SBU text",
            Self::Mcap => "MCAP bag",
            Self::Sqlite => "SQLite3 bag",
        })
    }
}

/// Which format these bytes are in: a bag by how it begins, else by the first line that is neither
/// blank nor a comment.
///
/// A line that starts with the word `frame` is a CSV header, one of a dozen numbers or more an
/// SBU line: which fields are wrong in it is for the reader to say.
///
/// # Errors
/// [`Reason::Empty`], [`Reason::NoFrames`] (comments only), [`Reason::OnePerson`] (ASF, AMC) or
/// [`Reason::UnknownFormat`].
pub fn detect(bytes: &[u8]) -> Result<Format, ReadError> {
    if let Some(format) = bag::detect(bytes) {
        return Ok(format);
    }
    let mut number = 1;
    let mut comments = false;
    for line in without_mark(bytes).split(|byte| *byte == b'\n') {
        let line = line.trim_ascii();
        if line.is_empty() || line.starts_with(b"#") {
            comments |= !line.is_empty();
            number += 1;
            continue;
        }
        // Ours are short; whatever is cut off a garbage line cannot make it ours.
        let text = String::from_utf8_lossy(&line[..line.len().min(LONGEST_LINE)]);
        return of_line(&text).map_err(|reason| ReadError::of(number, reason));
    }
    Err(ReadError::of(1, if comments { Reason::NoFrames } else { Reason::Empty }))
}

/// Room for 91 numbers in their longest spelling.
const LONGEST_LINE: usize = 4096;

fn of_line(line: &str) -> Result<Format, Reason> {
    let mut fields = line.split(',').map(|field| field.trim().trim_matches('"'));
    if fields.next() == Some("frame") {
        return Ok(Format::Csv);
    }
    let numbers = line.split(',').filter(|field| field.trim().parse::<f64>().is_ok()).count();
    if numbers >= sbu::FIELDS / 8 {
        return Ok(Format::Sbu);
    }
    if let Some(format) = of_one_person(line) {
        return Err(Reason::OnePerson { format });
    }
    Err(Reason::UnknownFormat { start: shortened(line) })
}

/// What an Acclaim file is, which holds no recording.
fn of_one_person(line: &str) -> Option<&'static str> {
    let word = line.split_ascii_whitespace().next()?;
    let is_in = |sections: &[&str]| sections.iter().any(|known| known.eq_ignore_ascii_case(word));
    if is_in(&amc::MOTION_SECTIONS) {
        return Some("AMC motion");
    }
    is_in(&amc::SKELETON_SECTIONS).then_some("ASF skeleton")
}

/// The bytes without the mark that some editors put before UTF-8 text.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(bytes: &[u8], expected: Result<Format, &str>) {
        let found = detect(bytes).map_err(|error| error.to_string());
        match (found, expected) {
            (Ok(found), Ok(expected)) => assert_eq!(found, expected),
            (Err(found), Err(part)) => assert!(found.contains(part), "{found}"),
            (found, expected) => panic!("{found:?} instead of {expected:?}"),
        }
    }

    #[test]
    fn the_first_line_decides() {
        check(b"\xef\xbb\xbf# class=07\r\n\r\n\"frame\",\"time_s\"\r\n", Ok(Format::Csv));
        check(format!("1{}\r\n", ",0.5".repeat(90)).as_bytes(), Ok(Format::Sbu));
        check(format!("1{}", ",0.5".repeat(60)).as_bytes(), Ok(Format::Sbu));
        check(b"", Err("line 1: the file is empty"));
        check(b"\n \r\n", Err("the file is empty"));
        check(b"# pair=s01s02\n", Err("no frames"));
        check(b"\nclip,frames\n1,2\n", Err("line 2: neither CSV (header 'frame,time_s,"));
        check(b"0,0.0,giver,head,0,0,1\n", Err("nor SBU text (91 numbers"));
        check(&[0xff; 300], Err("neither CSV"));
        let motion =
            "line 2: AMC motion of one person; a recording has two (hint: `handover motion`";
        check(b"#!OML:ASF x.ASF\n:FULLY-SPECIFIED\n:DEGREES\n", Err(motion));
        check(b":version 1.10\n:name VICON\n", Err("line 1: ASF skeleton of one person"));
        check(b":magic\n", Err("neither CSV"));
    }
}
