//! Why bytes are no model, or parts make none.

use crate::config::ConfigError;
use crate::demonstration::DemonstrationError;
use crate::formats::{FARTHEST, shortened_to};
use crate::predict::EdgesError;
use crate::skeleton::{RecordingError, SequenceError, SkeletonError};

use super::Model;

/// What is wrong with one tensor.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TensorFault {
    /// A tensor that the model's text speaks of is not there.
    #[error("tensor '{name}' is missing")]
    Missing {
        /// Its name.
        name: String,
    },
    /// A tensor that the model's text knows nothing of.
    #[error("tensor '{name}' is none of the model's")]
    Unknown {
        /// Its name, shortened.
        name: String,
    },
    /// Numbers of another type.
    #[error("tensor '{name}' has {got} numbers, must have {expected}")]
    Type {
        /// Its name.
        name: String,
        /// The type it must have.
        expected: String,
        /// The type it has.
        got: String,
    },
    /// Another count of numbers, or another order.
    #[error("tensor '{name}' has shape {got}, the model's text says {expected:?}")]
    Shape {
        /// Its name.
        name: String,
        /// The shape it must have.
        expected: Vec<usize>,
        /// The shape it has, shortened.
        got: String,
    },
}

/// Why bytes are no model, or parts make none. Frames, joints, demonstrations and edges count
/// from 0; what is quoted from a file is shortened.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// The bytes do not begin as safetensors do.
    #[error(
        "no safetensors file: 8 bytes of length and then '{{' expected, it starts with '{start}'"
    )]
    NotSafetensors {
        /// The first bytes.
        start: String,
    },
    /// The header claims to be larger than any.
    #[error("the header has {bytes} bytes, at most {most} are read")]
    HeaderTooLarge {
        /// Its length.
        bytes: u64,
        /// The bound.
        most: usize,
    },
    /// The header claims to be larger than the file.
    #[error("the header takes {header} bytes, only {file} follow (is the file cut short?)")]
    HeaderBeyondFile {
        /// Its length.
        header: u64,
        /// Bytes of the file after the length.
        file: usize,
    },
    /// The header is no JSON.
    #[error("the header is no JSON: {reason}")]
    HeaderNotJson {
        /// What the parser says.
        reason: String,
    },
    /// The header is JSON, but describes no tensors.
    #[error("the header describes no tensors: {reason}")]
    Header {
        /// What the parser says.
        reason: String,
    },
    /// The numbers do not fill the file, or not all are there.
    #[error("the tensors take {expected} bytes, {got} follow the header{}", if got < expected { " (is the file cut short?)" } else { "" })]
    DataLength {
        /// Bytes that the header tells of.
        expected: usize,
        /// Bytes there are.
        got: usize,
    },
    /// A safetensors file of something else.
    #[error(
        "not a model of handover_mesh: the metadata 'format' is {}, must be '{}'",
        .found.as_ref().map_or("missing".to_owned(), |found| format!("'{found}'")),
        super::container::FORMAT
    )]
    NotAModel {
        /// What the file says it is.
        found: Option<String>,
    },
    /// The version is none that ever was.
    #[error(
        "format_version is '{found}', must be a whole number from 1 to {}",
        Model::FORMAT_VERSION
    )]
    FormatVersion {
        /// What stands there.
        found: String,
    },
    /// Written by a program newer than this one.
    #[error(
        "format_version is {found} (written by handover_mesh {program}), this is {} and reads up \
         to {known} (hint: use a newer handover_mesh)",
        env!("CARGO_PKG_VERSION")
    )]
    NewerFormat {
        /// The file's version.
        found: u64,
        /// The newest this program reads.
        known: u64,
        /// The program that wrote it.
        program: String,
    },
    /// Metadata that every model has.
    #[error("the metadata '{key}' is missing")]
    MissingMetadata {
        /// Its key.
        key: &'static str,
    },
    /// Numbers in other units.
    #[error("units are '{found}', must be '{}'", super::container::UNITS)]
    Units {
        /// What stands there.
        found: String,
    },
    /// The model's text is no JSON, lacks something or holds something unknown.
    #[error("the metadata 'model': {reason}")]
    Contents {
        /// What the parser says.
        reason: String,
    },
    /// Tensors missing, unknown, or of the wrong type or shape: all of them, the first
    /// [`Self::MOST`] named.
    #[error("{}", tensor_lines(.faults, *.more))]
    Tensors {
        /// At least one.
        faults: Vec<TensorFault>,
        /// How many there are besides.
        more: usize,
    },
    /// A name that is none.
    #[error("{what} '{name}' must have 1 to {} bytes and no control characters", Model::MOST_NAME)]
    Name {
        /// Whose name.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// The joints and bones make no skeleton.
    #[error("person '{person}': {source}")]
    Skeleton {
        /// Whose joints.
        person: String,
        /// What is wrong with them.
        source: SkeletonError,
    },
    /// Nothing to learn from.
    #[error("no demonstrations; a model has at least one")]
    NoDemonstrations,
    /// A demonstration of other people than the first one's.
    #[error(
        "demonstration {demonstration} ('{name}'): person '{got}' stands where the first \
         demonstration has '{expected}', or has other joints; a model is of one pair"
    )]
    OtherPeople {
        /// Which demonstration.
        demonstration: usize,
        /// Its name.
        name: String,
        /// The person of the first demonstration.
        expected: String,
        /// The person found.
        got: String,
    },
    /// A person's positions or stamps make no sequence: NaN, infinite, or not rising.
    #[error("demonstration {demonstration}, person '{person}': {source}")]
    Motion {
        /// Which demonstration.
        demonstration: usize,
        /// Whose motion.
        person: String,
        /// What is wrong with it.
        source: SequenceError,
    },
    /// No room is that large.
    #[error(
        "demonstration {demonstration}, frame {frame}, '{joint}' of '{person}': {metres:?} m is \
         farther than {FARTHEST} m"
    )]
    TooFar {
        /// Which demonstration.
        demonstration: usize,
        /// Which frame.
        frame: usize,
        /// Whose joint.
        person: String,
        /// Which joint.
        joint: String,
        /// The coordinate `[m]`.
        metres: f64,
    },
    /// Two people make no recording.
    #[error("demonstration {demonstration}: {source}")]
    Recording {
        /// Which demonstration.
        demonstration: usize,
        /// What is wrong with it.
        source: RecordingError,
    },
    /// Nobody of the robot's name, or no hands.
    #[error("demonstration {demonstration}: {source}")]
    Demonstration {
        /// Which demonstration.
        demonstration: usize,
        /// What is wrong with it.
        source: DemonstrationError,
    },
    /// A hash that is none.
    #[error("demonstration {demonstration}: sha256 is '{found}', must be 64 digits 0-9 and a-f")]
    Hash {
        /// Which demonstration.
        demonstration: usize,
        /// What stands there.
        found: String,
    },
    /// The edges are named for a hand that is not there.
    #[error("the edges are named for the {side} hand of '{person}', who has none")]
    NoHand {
        /// Who lacks it.
        person: String,
        /// Which hand.
        side: &'static str,
    },
    /// More edges than two people can have without one being there twice.
    #[error("{edges} edges between the people, who can have {most} at most")]
    TooManyEdges {
        /// How many there are.
        edges: usize,
        /// The bound.
        most: usize,
    },
    /// An edge ends at a joint that is not there.
    #[error("edge {edge} ends at joint {joint}; the people have {joints} joints, counted from 0")]
    NoJoint {
        /// Which edge.
        edge: usize,
        /// The joint.
        joint: i64,
        /// Joints of both people.
        joints: usize,
    },
    /// The edges and their weights are no learned edges.
    #[error(transparent)]
    Edges(#[from] EdgesError),
    /// A distance of learning that is none.
    #[error("{which} is {value:?} m, must be finite and >= 0")]
    Distance {
        /// Which one.
        which: &'static str,
        /// Its value.
        value: f64,
    },
    /// Parameters unknown or out of range: all of them.
    #[error("parameters: {0}")]
    Config(#[from] ConfigError),
    /// The parameters are longer than any.
    #[error("the parameters take {bytes} bytes, at most {most} are read")]
    ConfigTooLong {
        /// Their length.
        bytes: usize,
        /// The bound.
        most: usize,
    },
    /// A setting of the library alone, which no parameter file could say.
    #[error("the settings hold something that no parameter says, and so cannot be written")]
    UnsayableConfig,
}

impl ModelError {
    /// How many faulty tensors are named; the others are counted.
    pub const MOST: usize = 20;
}

fn tensor_lines(faults: &[TensorFault], more: usize) -> String {
    let mut lines: Vec<String> = faults.iter().map(ToString::to_string).collect();
    if more > 0 {
        lines.push(format!("... and {more} more"));
    }
    lines.join("\n")
}

/// What a parser says, short enough for a message.
pub(super) fn shortened_reason(error: &serde_json::Error) -> String {
    shortened_to(300, &error.to_string())
}

/// A name short enough for a message.
pub(super) fn shortened_name(name: &str) -> String {
    shortened_to(60, name)
}

/// Names go into messages and onto terminals.
pub(super) fn check_name(what: &'static str, name: &str) -> Result<(), ModelError> {
    if name.is_empty() || name.len() > Model::MOST_NAME || name.chars().any(char::is_control) {
        return Err(ModelError::Name { what, name: shortened_name(name) });
    }
    Ok(())
}
