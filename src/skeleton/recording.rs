//! Two people over the same instants, and perhaps what one hands the other.

use std::collections::BTreeMap;

use super::{Sequence, StampsError};
use crate::geometry::{Isometry, Point, is_finite};
use crate::time::Stamp;

/// Which of a recording's two people: the robot plays one, the other is its partner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// The person the file names first.
    First,
    /// The person the file names second.
    Second,
}

impl Role {
    /// The other person.
    pub fn partner(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }

    /// `[this one's, the other person's]` → `[the first person's, the second's]`.
    pub fn in_order<T>(self, [own, other]: [T; 2]) -> [T; 2] {
        match self {
            Self::First => [own, other],
            Self::Second => [other, own],
        }
    }
}

/// One person of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Person {
    /// The role's name: `giver`, `receiver`, `A`, `B`.
    pub name: String,
    /// The person's joints.
    pub motion: Sequence,
}

/// Where the object is: one point of it, or several.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectTrack {
    /// At least one, of different names; a recording has them in the order of these.
    pub points: Vec<PointTrack>,
}

impl ObjectTrack {
    /// An object of one point.
    pub fn of_point(name: impl Into<String>, places: Vec<(Stamp, Point)>) -> Self {
        Self { points: vec![PointTrack { name: name.into(), places }] }
    }
}

/// Where a point of the object is, at those of the recording's instants where it is known.
#[derive(Debug, Clone, PartialEq)]
pub struct PointTrack {
    /// Its name in the file.
    pub name: String,
    /// Place `[m]` in the world at rising stamps.
    pub places: Vec<(Stamp, Point)>,
}

impl PointTrack {
    /// Where it is at an instant `[m]`, if that is known.
    pub fn place(&self, stamp: Stamp) -> Option<Point> {
        let found = self.places.binary_search_by_key(&stamp, |(stamp, _)| *stamp).ok()?;
        Some(self.places[found].1)
    }
}

/// Two people over the same stamps, perhaps an object, and what is known about the clip.
///
/// ```
/// # use handover_mesh::*;
/// # let frame = |k: i64| Frame { stamp: Stamp(k), positions: vec![Point::origin(); 15].into() };
/// # let motion = Sequence::new(Skeleton::nite(), vec![frame(0), frame(1)]).unwrap();
/// let person = |name: &str| Person { name: name.into(), motion: motion.clone() };
/// let recording =
///     Recording::new("clip", [person("giver"), person("receiver")], None, Default::default())?;
/// assert_eq!(recording.role("receiver"), Some(Role::Second));
/// assert_eq!(recording.person(Role::First).name, "giver");
/// # Ok::<(), RecordingError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    name: String,
    people: [Person; 2],
    object: Option<ObjectTrack>,
    metadata: BTreeMap<String, String>,
}

/// Why two people are no recording; frames count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecordingError {
    /// The two cannot be told apart.
    #[error("both people are called '{name}'")]
    SameName {
        /// The shared name.
        name: String,
    },
    /// One person has more frames than the other.
    #[error("{first} frames of one person, {second} of the other")]
    FrameCount {
        /// Frames of the first person.
        first: usize,
        /// Frames of the second person.
        second: usize,
    },
    /// A frame of one person is not at the same instant as the other's.
    #[error("frame {frame} is at {first} for one person, at {second} for the other")]
    StampsDiffer {
        /// Which frame.
        frame: usize,
        /// The first person's stamp.
        first: Stamp,
        /// The second person's stamp.
        second: Stamp,
    },
    /// An object that is nowhere.
    #[error("an object without points")]
    ObjectWithoutPoints,
    /// Two points of the object share a name.
    #[error("object: two points are called '{name}'")]
    SamePoint {
        /// The shared name.
        name: String,
    },
    /// The stamps of a point of the object do not rise.
    #[error("object: {0}")]
    ObjectStamps(StampsError),
    /// A place of the object is NaN or infinite.
    #[error("object, place {place}: not finite")]
    ObjectNotFinite {
        /// Which of its point's places, counted from 0.
        place: usize,
    },
}

impl Recording {
    /// The metadata key that names what was recorded, where several recordings show the same
    /// (two sensors, or a made-up scene and a sensor's view of it).
    pub const SCENE: &str = "scene";

    /// The only way in.
    ///
    /// - `name`: what reports call the clip; a file's stem, or its place in a folder tree.
    /// - `metadata`: free words about the clip (`class`, `pair`).
    ///
    /// # Errors
    /// [`RecordingError`] names the first fault.
    pub fn new(
        name: impl Into<String>,
        people: [Person; 2],
        mut object: Option<ObjectTrack>,
        metadata: BTreeMap<String, String>,
    ) -> Result<Self, RecordingError> {
        let [a, b] = &people;
        if a.name == b.name {
            return Err(RecordingError::SameName { name: a.name.clone() });
        }
        let (first, second) = (a.motion.len(), b.motion.len());
        if first != second {
            return Err(RecordingError::FrameCount { first, second });
        }
        for (frame, (first, second)) in a.motion.stamps().zip(b.motion.stamps()).enumerate() {
            if first != second {
                return Err(RecordingError::StampsDiffer { frame, first, second });
            }
        }
        if let Some(object) = &mut object {
            object.points.sort_by(|a, b| a.name.cmp(&b.name));
            let points = &object.points;
            if points.is_empty() {
                return Err(RecordingError::ObjectWithoutPoints);
            }
            if let Some(same) = points.windows(2).find(|pair| pair[0].name == pair[1].name) {
                return Err(RecordingError::SamePoint { name: same[0].name.clone() });
            }
            for point in points {
                StampsError::check(point.places.iter().map(|(stamp, _)| *stamp))
                    .map_err(RecordingError::ObjectStamps)?;
                if let Some(place) = point.places.iter().position(|(_, p)| !is_finite(p)) {
                    return Err(RecordingError::ObjectNotFinite { place });
                }
            }
        }
        Ok(Self { name: name.into(), people, object, metadata })
    }

    /// What reports call the clip.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Both people, in the file's order.
    pub fn people(&self) -> &[Person; 2] {
        &self.people
    }

    /// The person in this role.
    pub fn person(&self, role: Role) -> &Person {
        &self.people[role as usize]
    }

    /// The role of the person of this name.
    pub fn role(&self, name: &str) -> Option<Role> {
        [Role::First, Role::Second].into_iter().find(|role| self.person(*role).name == name)
    }

    /// What is handed over, where it was tracked.
    pub fn object(&self) -> Option<&ObjectTrack> {
        self.object.as_ref()
    }

    /// Free words about the clip (`class`, `pair`).
    pub fn metadata(&self) -> &BTreeMap<String, String> {
        &self.metadata
    }

    /// What was recorded: the metadata [`Self::SCENE`] names it, or the recording itself.
    pub fn scene(&self) -> &str {
        self.metadata.get(Self::SCENE).unwrap_or(&self.name)
    }

    /// The number of frames of each person.
    #[expect(clippy::len_without_is_empty, reason = "a recording has frames")]
    pub fn len(&self) -> usize {
        self.people[0].motion.len()
    }

    /// The instants of both people's frames.
    pub fn stamps(&self) -> impl ExactSizeIterator<Item = Stamp> + '_ {
        self.people[0].motion.stamps()
    }

    /// The recording under another name.
    pub fn renamed(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// The recording with these words about the clip added; of a key it has, the new ones count.
    pub fn with_metadata(mut self, more: BTreeMap<String, String>) -> Self {
        self.metadata.extend(more);
        self
    }

    /// The recording with another motion of one person.
    ///
    /// # Errors
    /// [`RecordingError`] if it is not at the recording's instants.
    pub fn with_motion(&self, role: Role, motion: Sequence) -> Result<Self, RecordingError> {
        let same = self.replacing(role, motion);
        Self::new(same.name, same.people, same.object, same.metadata)
    }

    /// The same with a motion of one person that is at the recording's instants.
    pub(super) fn replacing(&self, role: Role, motion: Sequence) -> Self {
        let mut same = self.clone();
        same.people[role as usize].motion = motion;
        same
    }

    /// Both people and the object seen from another frame.
    pub fn transformed(&self, world_from_here: &Isometry) -> Self {
        let mut moved = self.clone();
        for person in &mut moved.people {
            person.motion = person.motion.transformed(world_from_here);
        }
        moved.each_place(|place| *place = world_from_here * *place);
        moved
    }

    /// Both people smoothed by `sigma` `[s]`: see [`Sequence::smoothed`].
    pub fn smoothed(&self, sigma: f64) -> Self {
        let mut smooth = self.clone();
        for person in &mut smooth.people {
            person.motion = person.motion.smoothed(sigma);
        }
        smooth
    }

    /// The mirror image in the x-z plane: see [`Sequence::mirrored`].
    pub fn mirrored(&self) -> Self {
        let mut image = self.clone();
        for person in &mut image.people {
            person.motion = person.motion.mirrored();
        }
        image.each_place(|place| place.y = -place.y);
        image
    }

    /// Changes every place of the object.
    fn each_place(&mut self, mut change: impl FnMut(&mut Point)) {
        let points = self.object.iter_mut().flat_map(|object| &mut object.points);
        points.flat_map(|point| &mut point.places).for_each(|(_, place)| change(place));
    }
}
