//! Bytes → a model: the header, its text, the tensors' shapes, and only then the numbers.

use std::sync::Arc;

use serde_json::Value;

use super::container::{Container, FORMAT, Layout, UNITS};
use super::contents::{Contents, PersonText};
use super::error::{check_name, shortened_name, shortened_reason};
use super::{Model, ModelError, Source};
use crate::config::Config;
use crate::geometry::Point;
use crate::mesh::{Edge, Pair, Vertex};
use crate::predict::{LearnedEdge, LearnedEdges};
use crate::skeleton::{Frame, Person, Recording, Role, Sequence, SequenceError, Skeleton};
use crate::time::Stamp;

/// Reads a whole file.
pub(super) fn read(bytes: &[u8]) -> Result<Model, ModelError> {
    let container = Container::parse(bytes)?;
    check_kind(&container)?;
    let contents: Contents = serde_json::from_str(container.metadata("model")?)
        .map_err(|error| ModelError::Contents { reason: shortened_reason(&error) })?;
    let config = config(contents.config.get())?;
    let [first, second] = &contents.people;
    let pair = Pair::new([skeleton(first)?, skeleton(second)?]);
    let frames = contents.demonstrations.iter().map(|demonstration| demonstration.frames);
    let layouts = Layout::of_model(frames, pair.len(), contents.edges, contents.phases);
    container.check(&layouts)?;
    let edges = edges(&container, &layouts, &contents, &pair)?;
    let Contents { role, people, demonstrations, training, .. } = contents;
    let people = people.map(|person| person.name);
    let mut sources = Vec::with_capacity(demonstrations.len());
    for (at, (text, layouts)) in demonstrations.into_iter().zip(layouts.chunks_exact(2)).enumerate()
    {
        let motions = motions(&container, layouts, &pair).map_err(|(role, source)| {
            let person = people[role as usize].clone();
            ModelError::Motion { demonstration: at, person, source }
        })?;
        let (people, [first, second]) = (people.clone(), motions);
        let [a, b] = people;
        let people = [Person { name: a, motion: first }, Person { name: b, motion: second }];
        let recording = Recording::new(text.name, people, None, text.metadata)
            .map_err(|source| ModelError::Recording { demonstration: at, source })?;
        sources.push(Source { recording: Arc::new(recording), sha256: text.sha256 });
    }
    let program_version = container.metadata("program_version")?.to_owned();
    Model::checked(sources, &role, edges, config, training.into(), program_version)
}

/// Whether it is a model, of a version and in units that are known here.
fn check_kind(container: &Container<'_>) -> Result<(), ModelError> {
    match container.metadata("format") {
        Ok(FORMAT) => {}
        other => return Err(ModelError::NotAModel { found: other.ok().map(shortened_name) }),
    }
    let version = container.metadata("format_version")?;
    match version.parse() {
        Ok(1..=Model::FORMAT_VERSION) => {}
        Ok(found) if found > Model::FORMAT_VERSION => {
            let program = container.metadata("program_version").unwrap_or("of no version");
            let (known, program) = (Model::FORMAT_VERSION, shortened_name(program));
            return Err(ModelError::NewerFormat { found, known, program });
        }
        _ => return Err(ModelError::FormatVersion { found: shortened_name(version) }),
    }
    match container.metadata("units")? {
        UNITS => Ok(()),
        found => Err(ModelError::Units { found: shortened_name(found) }),
    }
}

fn config(text: &str) -> Result<Config, ModelError> {
    if text.len() > Model::MOST_CONFIG {
        return Err(ModelError::ConfigTooLong { bytes: text.len(), most: Model::MOST_CONFIG });
    }
    let values: serde_json::Map<String, Value> = serde_json::from_str(text).map_err(|error| {
        ModelError::Contents { reason: format!("config: {}", shortened_reason(&error)) }
    })?;
    Ok(Config::from_values(values)?)
}

fn skeleton(person: &PersonText) -> Result<Arc<Skeleton>, ModelError> {
    check_name("person", &person.name)?;
    for joint in &person.joints {
        check_name("joint", joint)?;
    }
    let PersonText { joints, bones, attached, .. } = person;
    let skeleton = Skeleton::new_with_attached(joints.clone(), bones, *attached);
    skeleton.map(Arc::new).map_err(|source| {
        let person = shortened_name(&person.name);
        ModelError::Skeleton { person, source }
    })
}

fn edges(
    container: &Container<'_>,
    layouts: &[Layout],
    contents: &Contents,
    pair: &Pair,
) -> Result<LearnedEdges, ModelError> {
    let vertices: Vec<Vertex> =
        [Role::First, Role::Second].into_iter().flat_map(|role| pair.vertices(role)).collect();
    let [.., ends, weights] = layouts else { return Err(ModelError::NoDemonstrations) };
    let most = pair.vertices(Role::First).len() * pair.vertices(Role::Second).len();
    if contents.edges > most {
        return Err(ModelError::TooManyEdges { edges: contents.edges, most });
    }
    let mut ends = container.numbers(ends).map(i64::from_le_bytes);
    let mut weights = container.numbers(weights).map(f64::from_le_bytes);
    let mut edges = Vec::with_capacity(contents.edges);
    for edge in 0..contents.edges {
        let mut end = || {
            let joint = ends.next().unwrap_or(-1);
            let vertex = usize::try_from(joint).ok().and_then(|at| vertices.get(at));
            vertex.copied().ok_or(ModelError::NoJoint { edge, joint, joints: vertices.len() })
        };
        let joined = Edge::new(end()?, end()?);
        let factors = weights.by_ref().take(contents.phases).collect();
        edges.push(LearnedEdge { edge: joined, factors });
    }
    Ok(LearnedEdges::new(pair, contents.hands(), contents.phases, edges)?)
}

/// Both people's motions of one demonstration.
///
/// - `layouts`: of its positions and its stamps.
fn motions(
    container: &Container<'_>,
    layouts: &[Layout],
    pair: &Pair,
) -> Result<[Sequence; 2], (Role, SequenceError)> {
    let mut metres = container.numbers(&layouts[0]).map(f64::from_le_bytes);
    let mut point = || Point::from(std::array::from_fn(|_| metres.next().unwrap_or(f64::NAN)));
    let stamps = container.numbers(&layouts[1]);
    let mut frames = [(); 2].map(|()| Vec::with_capacity(stamps.size_hint().0));
    for stamp in stamps {
        let stamp = Stamp(i64::from_le_bytes(stamp));
        for (role, frames) in [Role::First, Role::Second].into_iter().zip(&mut frames) {
            let positions = (0..pair.skeleton(role).len()).map(|_| point()).collect();
            frames.push(Frame { stamp, positions });
        }
    }
    let [first, second] = frames;
    let sequence = |role, frames| {
        Sequence::new(pair.skeleton(role).clone(), frames).map_err(|error| (role, error))
    };
    Ok([sequence(Role::First, first)?, sequence(Role::Second, second)?])
}
