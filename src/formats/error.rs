//! What is wrong with a file: every violation, each with its place.

use std::fmt;

use crate::skeleton::{RecordingError, SequenceError, SkeletonError};
use crate::time::Stamp;

/// Where in a file; earlier places are less.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// All of it.
    File,
    /// Line of a text, counted from 1; where something is missing, the line where its frame
    /// starts.
    Line(u64),
    /// A message of a bag.
    Message {
        /// Its topic.
        topic: String,
        /// Which of the topic's messages, counted from 1.
        number: u64,
    },
}

impl From<u64> for Place {
    fn from(line: u64) -> Self {
        Self::Line(line)
    }
}

impl fmt::Display for Place {
    /// `line 3`, `message 17 of /giver/skeleton`; nothing of the whole file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, "line {line}"),
            Self::Message { topic, number } => {
                write!(f, "message {number} of {}", shortened_to(100, topic))
            }
        }
    }
}

/// One thing wrong at one place of a file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{place}{}{reason}", if *.place == Place::File { "" } else { ": " })]
pub struct Violation {
    /// Where.
    pub place: Place,
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
    /// The object has more points than any has.
    #[error("the object has more than {most} points")]
    ManyPoints {
        /// How many it may have.
        most: usize,
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
    /// A corner of a face that names no vertex.
    #[error("'{value}' is no corner of a face such as 1, 1/2, 1//3 or 1/2/3")]
    NotACorner {
        /// What stands there.
        value: String,
    },
    /// A corner of a face names something that is not in the file.
    #[error("no {what} {index}: there are {there}, counted from 1, or from -1 backwards")]
    NoSuchIndex {
        /// What it would be.
        what: &'static str,
        /// Which one.
        index: i64,
        /// How many there are in the file.
        there: usize,
    },
    /// Too little for a face.
    #[error("a face has three corners or more, got {got}")]
    TooFewCorners {
        /// Corners the face has.
        got: usize,
    },
    /// A face that touches itself.
    #[error("the face names vertex {vertex} twice")]
    RepeatedCorner {
        /// The vertex, counted from 1.
        vertex: u64,
    },
    /// A bag that is none, or of which nothing is whole.
    #[error("no bag: {reason}")]
    NoBag {
        /// What is wrong with it.
        reason: String,
    },
    /// Somebody asked for a bag that is whole.
    #[error("part of the bag is lost: {0}")]
    Lost(super::bag::Loss),
    /// A message that its type cannot be.
    #[error(transparent)]
    Message(#[from] crate::messages::MessageError),
    /// A message that shows no body.
    #[error(transparent)]
    Body(#[from] crate::bodies::BodyError),
    /// A bag that does not hold two people, or more.
    #[error("two people are needed, found {}; topics: {topics}", listed(.found))]
    WhichPeople {
        /// Who could be meant.
        found: Vec<String>,
        /// All topics of the bag with their types and counts.
        topics: String,
    },
    /// Two places in frames of which nobody knows how they lie to each other.
    #[error(
        "places are in '{frame}', others in '{other}' (hint: neither /tf_static nor /tf of the bag \
         joins them then)"
    )]
    Frames {
        /// The frame here.
        frame: String,
        /// The frame of the others.
        other: String,
    },
    /// A message's stamp repeats or runs back.
    #[error("stamp {time} is not after {before}")]
    StampOrder {
        /// Its stamp.
        time: Stamp,
        /// The stamp of the message before.
        before: Stamp,
    },
    /// A joint that is tracked in most frames, but not for a while that is too long to fill in.
    #[error("'{joint}' of '{person}' is not tracked from here on for {seconds:.1} s")]
    Untracked {
        /// Whose joint.
        person: String,
        /// Which joint.
        joint: String,
        /// For how long `[s]`.
        seconds: f64,
    },
    /// The two have no instant in common.
    #[error("'{first}' and '{second}' are never whole at the same time")]
    NeverTogether {
        /// The first person.
        first: String,
        /// The second person.
        second: String,
    },
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
    pub(super) fn of(place: impl Into<Place>, reason: Reason) -> Self {
        Self { violations: vec![Violation { place: place.into(), reason }], more: 0 }
    }

    /// The first violations, by place.
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

/// Violations as they are found, in any order of places.
#[derive(Default)]
pub(super) struct Violations {
    kept: Vec<Violation>,
    count: usize,
}

impl Violations {
    /// Notes one more.
    pub(super) fn add(&mut self, place: impl Into<Place>, reason: impl Into<Reason>) {
        self.count += 1;
        self.kept.push(Violation { place: place.into(), reason: reason.into() });
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
        self.kept.sort_by(|a, b| a.place.cmp(&b.place));
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

/// `none`, or how many and which.
fn listed(found: &[String]) -> String {
    match found {
        [] => "none".into(),
        found => format!("{} ({})", found.len(), found.join(", ")),
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
