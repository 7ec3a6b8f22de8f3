//! A truth → what a Kinect-like sensor records of it.
//!
//! Frame by frame: the camera's noise and steps of depth, the tracker's own drift, left and right
//! mistaken, joints held at their last place, frames that never arrive. Instants of capture may
//! jitter; a stamp always says truly when its frame was captured, so truth and measurement share
//! their stamps, and the truth has those of the lost frames too.
//!
//! Deliberately no occlusion and no field of view: faults strike at random, not where one body
//! hides another.

mod config;
mod faults;
mod noise;

use handover_mesh::{
    Frame, ObjectTrack, Person, Point, Recording, Role, Sequence, Skeleton, Span, Stamp,
};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::check::Violations;
use crate::scene::RecordError;
use faults::Faults;
use noise::{Camera, Drift};

pub use config::{Figure, SensorConfig};

/// A checked sensor. It remembers nothing between recordings.
///
/// ```
/// use handover_sim::scene::{Scene, SceneConfig};
/// use handover_sim::sensor::{Sensor, SensorConfig};
/// use rand::SeedableRng;
/// let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
/// let scene = Scene::new(SceneConfig::default())?;
/// let sensor = Sensor::new(SensorConfig::ideal(15.0))?;
/// let stamps = sensor.capture_stamps(scene.moments().end, &mut random);
/// let truth = scene.record("clip", &stamps).unwrap().truth;
/// assert_eq!(sensor.observe(&truth, &mut random).unwrap().measured, truth);
/// # Ok::<(), handover_sim::Violations>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    config: SensorConfig,
}

/// A measured recording, and what went wrong in it.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// What the sensor recorded: the truth's name, people and object, at those of its stamps
    /// whose frames arrived.
    pub measured: Recording,
    /// Frames of the truth that never arrived.
    pub lost_frames: usize,
    /// Person-frames that arrived with left and right mistaken.
    pub swapped_frames: usize,
    /// Joint-frames that arrived with a joint held at its last place.
    pub held_joints: usize,
}

impl Sensor {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Violations`] names every one out of range.
    pub fn new(config: SensorConfig) -> Result<Self, Violations> {
        config.check()?;
        Ok(Self { config })
    }

    /// The parameters.
    pub fn config(&self) -> &SensorConfig {
        &self.config
    }

    /// When frames are captured in a clip of `seconds`: an even beat from stamp 0, each but the
    /// first jittered; rising, never empty.
    pub fn capture_stamps(&self, seconds: f64, random: &mut impl Rng) -> Vec<Stamp> {
        self.stamps_at(self.config.rate, seconds.clamp(0.0, 3600.0), random)
    }

    /// The same at another rate `[Hz]`, > 0, for as long as it takes.
    pub(crate) fn stamps_at(&self, rate: f64, seconds: f64, random: &mut impl Rng) -> Vec<Stamp> {
        let beat = 1.0 / rate;
        let count = (seconds * rate).floor() as i64;
        let stamp = |frame: i64| {
            let normal: f64 = StandardNormal.sample(random);
            let jitter = (self.config.stamp_jitter * normal).clamp(-0.4 * beat, 0.4 * beat);
            let late = if frame == 0 { 0.0 } else { jitter };
            // What lasts longer than centuries is no recording.
            Stamp::from_seconds(frame as f64 * beat + late).unwrap_or_default()
        };
        (0..=count).map(stamp).collect()
    }

    /// What the sensor makes of `truth`. The first frame always arrives, so that there is one.
    ///
    /// Without noise, steps, losses and faults this is the truth, bit for bit.
    ///
    /// # Errors
    /// [`RecordError`] if a point is so far off that noise takes it out of the range of numbers.
    pub fn observe(&self, truth: &Recording, random: &mut impl Rng) -> Result<View, RecordError> {
        let config = &self.config;
        let arrives: Vec<bool> = (0..truth.len())
            .map(|frame| random.random::<f64>() >= config.frame_loss || frame == 0)
            .collect();
        let mut view = Counts::default();
        let mut person = |role: Role| -> Result<Person, RecordError> {
            let Person { name, motion } = truth.person(role);
            let frames = self.track(motion, &arrives, &mut view, random);
            let motion = Sequence::new(motion.skeleton().clone(), frames)?;
            Ok(Person { name: name.clone(), motion })
        };
        let people = [person(Role::First)?, person(Role::Second)?];
        let object = truth.object().map(|object| {
            let stamps: Vec<Stamp> = people[0].motion.stamps().collect();
            self.track_object(object, &stamps, random)
        });
        let measured = Recording::new(truth.name(), people, object, truth.metadata().clone())?;
        Ok(View {
            measured,
            lost_frames: arrives.iter().filter(|arrived| !**arrived).count(),
            swapped_frames: view.swapped_frames,
            held_joints: view.held_joints,
        })
    }

    /// One person's frames as they arrive. The tracker runs through lost frames too: it is the
    /// message that is lost.
    fn track(
        &self,
        motion: &Sequence,
        arrives: &[bool],
        counts: &mut Counts,
        random: &mut impl Rng,
    ) -> Vec<Frame> {
        let config = &self.config;
        let camera = Camera::of(config);
        let skeleton: &Skeleton = motion.skeleton();
        let mut drifts = vec![Drift::default(); skeleton.len()];
        let mut faults = Faults::of(skeleton.len());
        let mut last: Option<Stamp> = None;
        let mut frames = Vec::new();
        for (frame, arrived) in motion.frames().iter().zip(arrives) {
            let elapsed = last.replace(frame.stamp).map_or(Span(0), |last| frame.stamp - last);
            let elapsed = elapsed.seconds();
            let joints = skeleton.joints().zip(&frame.positions).zip(&mut drifts);
            let seen = joints.map(|((joint, point), drift)| {
                let part = skeleton.part_of(joint);
                camera.measured(config, point, random) + drift.next(config, part, elapsed, random)
            });
            let mut points: Vec<Point> = seen.collect();
            let wrong = faults.apply(config, skeleton, elapsed, &mut points, random);
            if *arrived {
                counts.swapped_frames += usize::from(wrong.swapped);
                counts.held_joints += wrong.held_joints;
                frames.push(Frame { stamp: frame.stamp, positions: points.into() });
            }
        }
        frames
    }

    /// The object is seen by the camera alone, in the frames that arrive.
    fn track_object(
        &self,
        object: &ObjectTrack,
        stamps: &[Stamp],
        random: &mut impl Rng,
    ) -> ObjectTrack {
        let camera = Camera::of(&self.config);
        let mut points = object.points.clone();
        for point in &mut points {
            for (_, place) in &mut point.places {
                *place = camera.measured(&self.config, place, random);
            }
            // Measured first, dropped then: a lost frame must not change the noise of the next.
            point.places.retain(|(stamp, _)| stamps.binary_search(stamp).is_ok());
        }
        ObjectTrack { points }
    }
}

#[derive(Default)]
struct Counts {
    swapped_frames: usize,
    held_joints: usize,
}
