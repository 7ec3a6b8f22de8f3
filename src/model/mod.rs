//! What learning leaves: demonstrations, learned edges and parameters as one value, and as the
//! bytes of a `.safetensors` file.
//!
//! A [`Model`] predicts as it was learned, on any machine: its positions and weights are written
//! to the bit and its parameters whole. The container is safetensors (a length, a JSON header,
//! plain little-endian numbers), so that Python reads it without us:
//!
//! | tensor | type | shape |
//! | --- | --- | --- |
//! | `demonstration.<n>.positions` | F64 `[m]` | frames × joints of both people × 3 |
//! | `demonstration.<n>.stamps` | I64 `[ns]` | frames |
//! | `edges` | I64 | edges × 2 joints, counted over both people, the first person's first |
//! | `weights` | F64 `[-]` | edges × phases |
//!
//! `__metadata__` holds `format`, `format_version`, `program_version`, `units` and, as JSON in
//! `model`, all the rest: people, bones, roles, parameters, where it comes from.
//!
//! Deliberately absent: the track of what was handed over (of an object in the mesh its points are
//! joints, and no method reads more of it), anything
//! computed from the demonstrations, compression, files: bytes in, bytes out.

mod container;
mod contents;
mod error;
mod read;
mod write;

use std::sync::Arc;

use crate::config::Config;
use crate::demonstration::Demonstration;
use crate::formats::FARTHEST;
use crate::mesh::Pair;
use crate::predict::LearnedEdges;
use crate::skeleton::{Part, Recording, RecordingError, Role};

pub use error::{ModelError, TensorFault};

/// A recording to learn from, and the file it was read from.
#[derive(Debug, Clone)]
pub struct Source {
    /// Two people; the object, if there is one, is not kept.
    pub recording: Arc<Recording>,
    /// SHA-256 of the file's bytes: 64 hexadecimal digits, lower case.
    pub sha256: String,
}

/// What learning did and how near it came; distances as learning measures them, in metres.
#[derive(Debug, Clone, PartialEq)]
pub struct Training {
    /// The method's name; `none` where nothing was learned.
    pub method: String,
    /// Changes of the mesh that were kept.
    pub steps: usize,
    /// Meshes that were tried.
    pub evaluations: usize,
    /// Distance before the first step `[m]`, finite, ≥ 0.
    pub initial_distance: f64,
    /// Distance after the last step `[m]`, finite, ≥ 0.
    pub final_distance: f64,
    /// Distance on recordings that were not learned from `[m]`, finite, ≥ 0; where measured.
    pub held_out_distance: Option<f64>,
}

/// A learned model: whoever holds one can predict with it and write it.
///
/// ```
/// use std::sync::Arc;
/// use handover_mesh::demonstration::Hands;
/// use handover_mesh::formats::{self, UpAxis};
/// use handover_mesh::model::{Model, Source, Training};
/// use handover_mesh::predict::LearnedEdges;
/// use handover_mesh::{Config, Side};
/// let text = "frame,time_s,person,joint,x,y,z\n\
///     0,0.0,giver,torso,0,0,1.2\n0,0.0,giver,right_hand,0,0,1.2\n\
///     0,0.0,receiver,torso,1,0,1.2\n0,0.0,receiver,right_hand,1,0,1.2\n";
/// let recording = Arc::new(formats::read(text.as_bytes(), "clip", UpAxis::Z)?);
/// let edges = LearnedEdges::none(Hands { robot: Side::Right, partner: Side::Right });
/// let training = Training {
///     method: "none".into(),
///     steps: 0,
///     evaluations: 1,
///     initial_distance: 0.1,
///     final_distance: 0.1,
///     held_out_distance: None,
/// };
/// let source = Source { recording, sha256: "0".repeat(64) };
/// let model = Model::new(vec![source], "giver", edges, Config::default(), training)?;
/// let read = Model::from_bytes(&model.to_bytes())?;
/// assert_eq!(read.demonstrations()[0].recording(), model.demonstrations()[0].recording());
/// assert_eq!(read.to_bytes(), model.to_bytes());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Model {
    demonstrations: Vec<Arc<Demonstration>>,
    hashes: Vec<String>,
    pair: Pair,
    edges: LearnedEdges,
    config: Config,
    training: Training,
    program_version: String,
}

impl Model {
    /// The newest version of the format. Version 2 has joints that ride on others; a model without
    /// such is written as version 1.
    pub const FORMAT_VERSION: u64 = 2;

    /// No header is longer `[bytes]`; thousands of demonstrations fit.
    pub const MOST_HEADER: usize = 8 << 20;

    /// No parameters are longer `[bytes]`, as JSON.
    pub const MOST_CONFIG: usize = 64 << 10;

    /// No name (of a person, joint, demonstration, method, version) is longer `[bytes]`.
    pub const MOST_NAME: usize = 1 << 10;

    /// The only way in, for what was learned as for what was read.
    ///
    /// - `sources`: at least one, all of the same two people's names and skeletons, in one order.
    /// - `role`: the name of the person the robot stands in for.
    /// - `edges`: between joints of these two skeletons, named for hands that they have.
    /// - `config`: what `edges` were learned with.
    ///
    /// # Errors
    /// [`ModelError`] names the first fault, of parameters all.
    pub fn new(
        sources: Vec<Source>,
        role: &str,
        edges: LearnedEdges,
        config: Config,
        training: Training,
    ) -> Result<Self, ModelError> {
        let program_version = env!("CARGO_PKG_VERSION").to_owned();
        Self::checked(sources, role, edges, config, training, program_version)
    }

    fn checked(
        sources: Vec<Source>,
        role: &str,
        edges: LearnedEdges,
        config: Config,
        training: Training,
        program_version: String,
    ) -> Result<Self, ModelError> {
        if Config::from_values(config.values())? != config {
            return Err(ModelError::UnsayableConfig);
        }
        let Some(first) = sources.first() else { return Err(ModelError::NoDemonstrations) };
        let pair = Pair::of(&first.recording);
        let people = first.recording.people().each_ref().map(|person| person.name.clone());
        error::check_name("program version", &program_version)?;
        error::check_name("role", role)?;
        check_training(&training)?;
        for (role, name) in [Role::First, Role::Second].into_iter().zip(&people) {
            error::check_name("person", name)?;
            for joint in pair.skeleton(role).names() {
                error::check_name("joint", joint)?;
            }
        }
        let (mut demonstrations, mut hashes) = (Vec::new(), Vec::new());
        for (at, source) in sources.into_iter().enumerate() {
            let Source { recording, sha256 } = source;
            error::check_name("demonstration", recording.name())?;
            check_source(at, &recording, &sha256, &people, &pair)?;
            let recording = without_object(recording)
                .map_err(|source| ModelError::Recording { demonstration: at, source })?;
            let demonstration = Demonstration::new(recording, role, &config.base_joint)
                .map_err(|source| ModelError::Demonstration { demonstration: at, source })?;
            demonstrations.push(Arc::new(demonstration));
            hashes.push(sha256);
        }
        let edges =
            LearnedEdges::new(&pair, edges.hands(), edges.phases(), edges.edges().to_vec())?;
        let model = Self { demonstrations, hashes, pair, edges, config, training, program_version };
        model.check_hands()?;
        // What cannot be read back is no model: `to_bytes` has no way to fail.
        let config = model.config_json().len();
        if config > Self::MOST_CONFIG {
            return Err(ModelError::ConfigTooLong { bytes: config, most: Self::MOST_CONFIG });
        }
        let header = model.header().len();
        if header > Self::MOST_HEADER {
            let (bytes, most) = (header as u64, Self::MOST_HEADER);
            return Err(ModelError::HeaderTooLarge { bytes, most });
        }
        Ok(model)
    }

    /// The hands that the edges are named for are there.
    fn check_hands(&self) -> Result<(), ModelError> {
        let (robot, hands) = (self.robot_role(), self.edges.hands());
        for (role, side) in [(robot, hands.robot), (robot.partner(), hands.partner)] {
            if self.pair.skeleton(role).part(Part::Hand(side)).is_none() {
                let person = error::shortened_name(self.people()[role as usize]);
                return Err(ModelError::NoHand { person, side: side.name() });
            }
        }
        Ok(())
    }

    /// Reads the bytes of a `.safetensors` file that [`Self::to_bytes`] wrote, or Python.
    ///
    /// Bytes that are no model never panic, and never cost more memory than 64 bytes for each
    /// byte of the header, twice the rest and a constant of 8 MiB: lengths are checked before
    /// they are believed.
    ///
    /// # Errors
    /// [`ModelError`]; all missing, unknown and misshapen tensors and all wrong parameters
    /// together, of anything else the first.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelError> {
        read::read(bytes)
    }

    /// The bytes of a `.safetensors` file: the same for the same model.
    pub fn to_bytes(&self) -> Vec<u8> {
        write::write(self)
    }

    /// What was learned from, each from the robot's side; at least one.
    pub fn demonstrations(&self) -> &[Arc<Demonstration>] {
        &self.demonstrations
    }

    /// SHA-256 of the file of each demonstration: 64 hexadecimal digits.
    pub fn hashes(&self) -> &[String] {
        &self.hashes
    }

    /// Both people's joints.
    pub fn pair(&self) -> &Pair {
        &self.pair
    }

    /// The names of the people, in the recordings' order.
    pub fn people(&self) -> [&str; 2] {
        self.demonstrations[0].recording().people().each_ref().map(|person| person.name.as_str())
    }

    /// The role the robot takes.
    pub fn robot_role(&self) -> Role {
        self.demonstrations[0].robot_role()
    }

    /// The joint that a person's place is known by: the parameter `robot.base_joint`.
    pub fn base_joint(&self) -> &str {
        &self.config.base_joint
    }

    /// The edges between the people.
    pub fn edges(&self) -> &LearnedEdges {
        &self.edges
    }

    /// The parameters it was learned with.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// What learning did.
    pub fn training(&self) -> &Training {
        &self.training
    }

    /// The version of `handover_mesh` that made it.
    pub fn program_version(&self) -> &str {
        &self.program_version
    }
}

/// A recording among others: its people, its places, its hash.
fn check_source(
    demonstration: usize,
    recording: &Recording,
    sha256: &str,
    people: &[String; 2],
    pair: &Pair,
) -> Result<(), ModelError> {
    let name = || error::shortened_name(recording.name());
    for (role, expected) in [Role::First, Role::Second].into_iter().zip(people) {
        let person = recording.person(role);
        let same_joints = person.motion.skeleton() == pair.skeleton(role);
        if person.name != *expected || !same_joints {
            let expected = error::shortened_name(expected);
            let got = error::shortened_name(&person.name);
            return Err(ModelError::OtherPeople { demonstration, name: name(), expected, got });
        }
        for (frame, place) in person.motion.frames().iter().enumerate() {
            for (joint, point) in place.positions.iter().enumerate() {
                let Some(metres) = point.iter().copied().find(|c| c.abs() > FARTHEST) else {
                    continue;
                };
                let person = error::shortened_name(&person.name);
                let joint = pair.skeleton(role).names()[joint].clone();
                return Err(ModelError::TooFar { demonstration, frame, person, joint, metres });
            }
        }
    }
    let digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
    if sha256.len() != 64 || !sha256.bytes().all(digit) {
        let found = error::shortened_name(sha256);
        return Err(ModelError::Hash { demonstration, found });
    }
    Ok(())
}

fn check_training(training: &Training) -> Result<(), ModelError> {
    error::check_name("method", &training.method)?;
    let distances = [
        ("initial_distance", Some(training.initial_distance)),
        ("final_distance", Some(training.final_distance)),
        ("held_out_distance", training.held_out_distance),
    ];
    for (which, value) in distances {
        if let Some(value) = value.filter(|value| !(value.is_finite() && *value >= 0.0)) {
            return Err(ModelError::Distance { which, value });
        }
    }
    Ok(())
}

fn without_object(recording: Arc<Recording>) -> Result<Arc<Recording>, RecordingError> {
    if recording.object().is_none() {
        return Ok(recording);
    }
    let (people, metadata) = (recording.people().clone(), recording.metadata().clone());
    Recording::new(recording.name(), people, None, metadata).map(Arc::new)
}
