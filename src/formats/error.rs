//! What is wrong with a file: every violation, each with its line.

use std::fmt;

use crate::skeleton::{RecordingError, SequenceError, SkeletonError};
use crate::time::Stamp;

/// One thing wrong at one place of a file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("line {line}: {reason}")]
pub struct Violation {
    /// Line of the file, counted from 1; where something is missing, the line where its frame
    /// starts.
    pub line: u64,
    /// What is wrong there.
    pub reason: Reason,
}

/// What can be wrong with a recording's or a motion's file. Values quoted from the file are shortened.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Reason {
    /// Not a byte, or blank lines only.
    #[error("the file is empty")]
    Empty,
    /// A header or comments, and nothing after them.
    #[error("no frames: nothing follows the header")]
    NoFrames,
    /// The first line is that of no known format.
    #[error(
        "neither CSV (header '{}') nor SBU text (91 numbers with commas between): the file starts \
         with '{start}'",
        super::csv::HEADER
    )]
    UnknownFormat {
        /// The beginning of the first line that is not blank.
        start: String,
    },
    /// The first line starts like our CSV but has other columns.
    #[error("the header must be '{}', got '{got}'", super::csv::HEADER)]
    Header {
        /// The header found.
        got: String,
    },
    /// The bytes are no text.
    #[error("not UTF-8 text")]
    NotUtf8,
    /// The format fixes its axes, so there is no up axis to choose.
    #[error(
        "SBU text has fixed axes and always comes out z up; up axis y does not apply \
         (hint: leave it out)"
    )]
    UpIsFixed,
    /// A line is cut short or runs on.
    #[error("expected {expected} fields, got {got}")]
    FieldCount {
        /// Fields the format has.
        expected: usize,
        /// Fields the line has.
        got: usize,
    },
    /// A name is missing.
    #[error("field '{field}' is empty")]
    EmptyField {
        /// Which field.
        field: String,
    },
    /// A field that should hold a number.
    #[error("field '{field}': '{value}' is not a number")]
    NotANumber {
        /// Which field.
        field: String,
        /// What stands there.
        value: String,
    },
    /// A frame is numbered 0, 1, 2, …
    #[error("field '{field}': '{value}' is not a whole number from 0 on")]
    NotAFrameNumber {
        /// Which field.
        field: String,
        /// What stands there.
        value: String,
    },
    /// NaN or infinite.
    #[error("field '{field}': '{value}' is not finite")]
    NotFinite {
        /// Which field.
        field: String,
        /// What stands there.
        value: String,
    },
    /// A time beyond what nanoseconds can count.
    #[error("field '{field}': '{value}' s is beyond ±292 years")]
    TimeOutOfRange {
        /// Which field.
        field: String,
        /// What stands there.
        value: String,
    },
    /// No room is that large.
    #[error("field '{field}': {metres} m is farther than 1000 m (hint: are these millimetres?)")]
    TooFar {
        /// Which field.
        field: String,
        /// Its value `[m]`.
        metres: f64,
    },
    /// The object goes by two names.
    #[error("a second object '{second}' beside '{first}'")]
    SecondObject {
        /// The name first seen.
        first: String,
        /// The other name.
        second: String,
    },
    /// More people than two.
    #[error("a third person '{third}' beside '{first}' and '{second}'")]
    ThirdPerson {
        /// The person first named.
        first: String,
        /// The person named next.
        second: String,
        /// The one too many.
        third: String,
    },
    /// One person or none.
    #[error("two people are needed, found {}", .found.as_ref().map_or("none".into(), |name| format!("only '{name}'")))]
    TooFewPeople {
        /// The one there is.
        found: Option<String>,
    },
    /// A joint whose name no skeleton knows; the first one in a file is told which are known.
    #[error("person '{person}': unknown joint '{joint}'")]
    UnknownJoint {
        /// Whose joint.
        person: String,
        /// The name.
        joint: String,
    },
    /// The joints make no skeleton.
    #[error("person '{person}': {source}")]
    Skeleton {
        /// Whose joints.
        person: String,
        /// What is wrong with them.
        source: SkeletonError,
    },
    /// A joint given twice in one frame.
    #[error("frame {frame}: '{joint}' of '{person}' appears twice")]
    RepeatedJoint {
        /// The frame's number.
        frame: u64,
        /// Whose joint.
        person: String,
        /// Which joint.
        joint: String,
    },
    /// A joint that the person has in most frames.
    #[error("frame {frame}: '{joint}' of '{person}' is missing")]
    MissingJoint {
        /// The frame's number.
        frame: u64,
        /// Whose joint.
        person: String,
        /// Which joint.
        joint: String,
    },
    /// A joint that the person lacks in most frames.
    #[error("'{joint}' of '{person}' is in {frames} of {of} frames only")]
    RareJoint {
        /// Whose joint.
        person: String,
        /// Which joint.
        joint: String,
        /// Frames that have it.
        frames: usize,
        /// Frames of the person.
        of: usize,
    },
    /// One person has a frame where the other has none.
    #[error("frame {frame} lacks '{person}' (hint: were the two recorded at different rates?)")]
    MissingPerson {
        /// The frame's number.
        frame: u64,
        /// Who is missing.
        person: String,
    },
    /// Frame numbers fall or a frame's rows are not together.
    #[error("frame {frame} comes after frame {before}")]
    FrameOrder {
        /// The frame's number.
        frame: u64,
        /// The number before it.
        before: u64,
    },
    /// Time stands still or runs back.
    #[error("frame {frame}: time {time} is not after {before}")]
    TimeOrder {
        /// The frame's number.
        frame: u64,
        /// Its time.
        time: Stamp,
        /// The time of the frame before.
        before: Stamp,
    },
    /// Two rows of one frame bear different times.
    #[error("frame {frame}: time {time} differs from {first} earlier in the same frame")]
    TimesDiffer {
        /// The frame's number.
        frame: u64,
        /// The row's time.
        time: Stamp,
        /// The frame's time.
        first: Stamp,
    },
    /// The rate changes inside the file.
    #[error("mixed rates: {rate:.1} Hz from here on, {usual:.1} Hz in most of the file")]
    MixedRates {
        /// The rate here `[Hz]`.
        rate: f64,
        /// The file's median rate `[Hz]`.
        usual: f64,
    },
    /// A file of one person, where a recording of two is asked for.
    #[error("{format} of one person; a recording has two (hint: `handover motion` takes it)")]
    OnePerson {
        /// What it is: `AMC motion` or `ASF skeleton`.
        format: &'static str,
    },
    /// A section, key or name that means nothing where it stands.
    #[error("{what} '{word}' is not known (known are: {known})")]
    UnknownWord {
        /// What the word would be.
        what: &'static str,
        /// The word.
        word: String,
        /// What may stand there.
        known: &'static str,
    },
    /// Something that may be there once only.
    #[error("{what} appears twice")]
    Repeated {
        /// What it is.
        what: String,
    },
    /// Something that has to be there.
    #[error("{what} is missing")]
    Missing {
        /// What it is.
        what: String,
    },
    /// A number that its field cannot have.
    #[error("field '{field}': {value} must be {bound}")]
    OutOfBounds {
        /// Which field.
        field: String,
        /// Its value, in the file's unit.
        value: f64,
        /// What it must be.
        bound: &'static str,
    },
    /// A line has too few or too many values for what it names.
    #[error("values of '{of}': expected {expected}, got {got}")]
    ValueCount {
        /// Whose values.
        of: String,
        /// As many as the skeleton has.
        expected: usize,
        /// As many as the line has.
        got: usize,
    },
    /// Limits of an angle are two numbers in brackets, the lesser first.
    #[error("'{value}' is no pair of limits such as (-10 20)")]
    NotLimits {
        /// What stands there.
        value: String,
    },
    /// A bone that points nowhere.
    #[error("bone '{bone}': its direction has no length")]
    NoDirection {
        /// Which bone.
        bone: String,
    },
    /// More bones than any skeleton has.
    #[error("more than {most} bones")]
    TooManyBones {
        /// How many there may be.
        most: usize,
    },
    /// A name that is none of the skeleton's; told once for each name.
    #[error("bone '{bone}' is not in the skeleton")]
    NotInSkeleton {
        /// The name.
        bone: String,
    },
    /// Bones that hang from each other in a ring.
    #[error("bone '{bone}' hangs from itself")]
    HangsFromItself {
        /// One of them.
        bone: String,
    },
    /// A frame that does not tell all bones.
    #[error(
        "frame {frame}: without {}{}{}",
        .bones.iter().map(|bone| format!("'{bone}'")).collect::<Vec<_>>().join(", "),
        if *.more > 0 { format!(" and {more} more") } else { String::new() },
        if *.at_end { " (hint: the file ends there)" } else { "" }
    )]
    MissingBones {
        /// The frame's number.
        frame: u64,
        /// The first bones that are missing.
        bones: Vec<String>,
        /// How many are missing besides.
        more: usize,
        /// Nothing follows the frame.
        at_end: bool,
    },
    /// Frames are left out.
    #[error("frame {frame} comes after frame {before}: those between are missing")]
    FrameGap {
        /// The frame's number.
        frame: u64,
        /// The number before it.
        before: u64,
    },
    /// The file breaks off in a line, whose last number may have lost digits.
    #[error("the last line has no end: the file is cut (hint: if not, end it with a line break)")]
    LineWithoutEnd,
    /// A person's frames make no sequence.
    #[error(transparent)]
    Sequence(#[from] SequenceError),
    /// The people make no recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}

/// Everything that is wrong with a file: at least one violation, at most [`Self::MOST`] kept.
///
/// ```
/// use handover_mesh::formats::{self, Reason, UpAxis};
/// let error = formats::read(b"", "clip", UpAxis::Z).unwrap_err();
/// assert_eq!(error.violations()[0].reason, Reason::Empty);
/// assert_eq!(error.to_string(), "line 1: the file is empty");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ReadError {
    violations: Vec<Violation>,
    more: usize,
}

impl ReadError {
    /// How many violations are kept; the others are counted.
    pub const MOST: usize = 20;

    /// A single violation.
    pub(super) fn of(line: u64, reason: Reason) -> Self {
        Self { violations: vec![Violation { line, reason }], more: 0 }
    }

    /// The first violations, by line.
    pub fn violations(&self) -> &[Violation] {
        &self.violations
    }

    /// How many there are besides.
    pub fn more(&self) -> usize {
        self.more
    }
}

impl fmt::Display for ReadError {
    /// One violation a line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, violation) in self.violations.iter().enumerate() {
            let separator = if at == 0 { "" } else { "\n" };
            write!(f, "{separator}{violation}")?;
        }
        if self.more > 0 {
            write!(f, "\n... and {} more", self.more)?;
        }
        Ok(())
    }
}

impl std::error::Error for ReadError {}

/// Violations as they are found, in any order of lines.
#[derive(Default)]
pub(super) struct Violations {
    kept: Vec<Violation>,
    count: usize,
}

impl Violations {
    /// Notes one more.
    pub(super) fn add(&mut self, line: u64, reason: impl Into<Reason>) {
        self.count += 1;
        self.kept.push(Violation { line, reason: reason.into() });
        // Garbage of any length must not grow into an error many times as long.
        if self.kept.len() > 8 * ReadError::MOST {
            self.trim();
        }
    }

    /// Whether there is none.
    pub(super) fn none(&self) -> bool {
        self.count == 0
    }

    fn trim(&mut self) {
        self.kept.sort_by_key(|violation| violation.line);
        self.kept.truncate(ReadError::MOST);
    }

    /// `value`, or all that was noted.
    pub(super) fn or<T>(mut self, value: Option<T>) -> Result<T, ReadError> {
        match value {
            Some(value) if self.none() => Ok(value),
            _ => {
                self.trim();
                let more = self.count - self.kept.len();
                Err(ReadError { violations: self.kept, more })
            }
        }
    }
}

/// `text` short enough for a message, without control characters.
pub(super) fn shortened(text: &str) -> String {
    shortened_to(40, text)
}

/// At most `longest` characters of `text`, without control characters.
pub(crate) fn shortened_to(longest: usize, text: &str) -> String {
    let mut short: String = text.chars().take(longest).flat_map(char::escape_debug).collect();
    if text.chars().nth(longest).is_some() {
        short.push('…');
    }
    short
}
