//! What is played: each time anew, as a sensor sees it.

use handover_mesh::{
    ObjectTrack, Person, Point, PointTrack, Recording, Role, SequenceError, Stamp,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::{BroadcastError, Settings};
use crate::scene::{RecordError, Scene, draw};
use crate::sensor::Sensor;

/// What is played.
#[derive(Debug, Clone)]
pub enum Source {
    /// What was recorded.
    Recording(Box<Recording>),
    /// What two people might do.
    Scene(Box<Scene>),
}

/// One time through.
#[derive(Debug, Clone)]
pub(super) struct Take {
    /// What the people did.
    pub(super) truth: Recording,
    /// What the sensor saw of it: some of the frames.
    pub(super) measured: Recording,
}

impl Source {
    /// The handover that `seed` stands for: the first clip of the set that
    /// [`generate`](crate::generate()) makes of it.
    ///
    /// # Errors
    /// [`BroadcastError::Scene`]; no seed is known to give one.
    pub fn generated(seed: u64) -> Result<Self, BroadcastError> {
        let scene = Scene::new(draw(&mut ChaCha8Rng::seed_from_u64(seed)))?;
        Ok(Self::Scene(Box::new(scene)))
    }

    /// What is seen when it is played for the `repetition`th time, from 0.
    ///
    /// The sensor draws from stream `2 repetition + 1` of the seed, as it does in clips of a set.
    pub(super) fn take(
        &self,
        settings: &Settings,
        repetition: u64,
    ) -> Result<Take, BroadcastError> {
        let mut random = ChaCha8Rng::seed_from_u64(settings.seed);
        random.set_stream(repetition.wrapping_mul(2).wrapping_add(1));
        let random = &mut random;
        let sensor = Sensor::new(settings.sensor.clone())?;
        let truth = match self {
            Self::Scene(scene) => {
                let rate = settings.rate_or_own();
                let stamps = sensor.stamps_at(rate, scene.moments().end, random);
                scene.record("generated", &stamps)?.truth
            }
            Self::Recording(recording) => {
                let first = first(recording);
                let seconds = (last(recording) - first).seconds();
                let resampled = settings.rate.map(|rate| {
                    let stamps = sensor.stamps_at(rate, seconds, random);
                    stamps.iter().map(|stamp| first + (*stamp - Stamp(0))).collect::<Vec<_>>()
                });
                at(recording, resampled)?
            }
        };
        let measured = sensor.observe(&truth, random)?.measured;
        Ok(Take { truth, measured })
    }

    /// Who is in it.
    pub(super) fn role(&self, name: &str) -> Result<Role, BroadcastError> {
        let names = match self {
            Self::Recording(recording) => recording.people().each_ref().map(|p| p.name.clone()),
            Self::Scene(_) => [crate::scene::GIVER, crate::scene::RECEIVER].map(str::to_owned),
        };
        let found =
            [Role::First, Role::Second].into_iter().find(|role| names[*role as usize] == name);
        found.ok_or_else(|| BroadcastError::Role { name: name.to_owned(), names })
    }

    /// When its first frame is.
    pub(super) fn first_stamp(&self) -> Stamp {
        match self {
            Self::Recording(recording) => first(recording),
            Self::Scene(_) => Stamp(0),
        }
    }
}

fn first(recording: &Recording) -> Stamp {
    // A recording has a frame.
    recording.stamps().next().unwrap_or_default()
}

fn last(recording: &Recording) -> Stamp {
    recording.stamps().last().unwrap_or_default()
}

/// The same people at other instants, by linear interpolation, or at their own to the bit; the
/// object at these instants, where it is known.
fn at(recording: &Recording, others: Option<Vec<Stamp>>) -> Result<Recording, BroadcastError> {
    let person = |role: Role| -> Result<Person, SequenceError> {
        let Person { name, motion } = recording.person(role);
        let motion = match &others {
            Some(stamps) => motion.resampled(stamps)?,
            None => motion.clone(),
        };
        Ok(Person { name: name.clone(), motion })
    };
    let people = [
        person(Role::First).map_err(RecordError::from)?,
        person(Role::Second).map_err(RecordError::from)?,
    ];
    let stamps = others.unwrap_or_else(|| recording.stamps().collect());
    let object = recording.object().map(|object| {
        let points = object.points.iter().map(|point| {
            let places = stamps.iter().filter_map(|stamp| Some((*stamp, place(point, *stamp)?)));
            PointTrack { name: point.name.clone(), places: places.collect() }
        });
        // A point that is at none of the instants is none.
        ObjectTrack { points: points.filter(|point| !point.places.is_empty()).collect() }
    });
    let object = object.filter(|object| !object.points.is_empty());
    let metadata = recording.metadata().clone();
    Ok(Recording::new(recording.name(), people, object, metadata).map_err(RecordError::from)?)
}

/// Where a point of the object is `[m]`, between two instants at which that is known.
fn place(object: &PointTrack, stamp: Stamp) -> Option<Point> {
    let after = object.places.partition_point(|(known, _)| *known < stamp);
    let (next, there) = object.places.get(after)?;
    if *next == stamp {
        return Some(*there);
    }
    let (last, from) = object.places.get(after.checked_sub(1)?)?;
    let part = (stamp - *last).seconds() / (*next - *last).seconds();
    Some(from + (there - from) * part)
}
