//! Makes two-person handovers, and what a Kinect-like sensor would see of them.
//!
//! One way only: a [`scene::SceneConfig`] is checked into a [`scene::Scene`]; recorded, it is the
//! truth; a [`sensor::Sensor`] turns the truth into a measured recording. [`generate`] does all
//! three for one clip of a set. Every random choice comes from the seed and the clip's number, so
//! equal seeds give equal bytes, in whatever order or on however many threads clips are made.
//!
//! With [`scenario`] and [`closed_loop`] the robot itself takes part: a trial's file says who meets
//! whom and what goes wrong, the product's tick moves a simple arm among them, and the trial's figures
//! are held against the file's bounds.
//!
//! [`broadcast`] plays recordings and made-up scenes to whoever listens, in place of a sensor.
//!
//! The library opens no file and reads no clock; the binary `handover_sim` writes what it makes.

pub mod body;
pub mod broadcast;
mod check;
pub mod closed_loop;
pub mod output;
pub mod profile;
pub mod scenario;
pub mod scene;
pub mod sensor;

use std::collections::BTreeMap;

use handover_mesh::Recording;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use scene::{RecordError, Scene, Take};
use sensor::{Sensor, View};

pub use check::{Violation, Violations};

/// One clip: what two people did, and what the sensor saw.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// The handover, playable at any instant.
    pub scene: Scene,
    /// What the two did, at every instant of capture.
    pub truth: Recording,
    /// What the sensor recorded of it, and its faults.
    pub view: View,
    /// Frames in which the active hand's goal was out of its arm's reach: giver, receiver.
    pub clamped_frames: [usize; 2],
}

/// Why a clip could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GenerateError {
    /// A scene drawn out of range: a fault of the drawing, not of the seed.
    #[error("drawn scene: {0}")]
    Scene(#[from] Violations),
    /// A scene that is no recording.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// Makes clip `index` of the set that `seed` stands for.
///
/// The scene and the sensor draw from two streams of the same seed, so the same people do the
/// same whatever the sensor's noise (as long as its rate and jitter are the same, at the same
/// stamps).
///
/// - `name`: what the recordings are called.
///
/// # Errors
/// [`GenerateError`]; no seed is known to give one.
pub fn generate(seed: u64, index: u64, name: &str, sensor: &Sensor) -> Result<Clip, GenerateError> {
    let stream = |of_sensor: u64| {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(2 * index + of_sensor);
        random
    };
    let scene = Scene::new(scene::draw(&mut stream(0)))?;
    let random = &mut stream(1);
    let stamps = sensor.capture_stamps(scene.moments().end, random);
    let Take { truth, clamped_frames } = scene.record(name, &stamps)?;
    // Truth and measurement show one scene: nobody may learn one from the other.
    let scene_name = BTreeMap::from([(Recording::SCENE.to_owned(), format!("{seed}/{index}"))]);
    let truth = truth.with_metadata(scene_name);
    let view = sensor.observe(&truth, random)?;
    Ok(Clip { scene, truth, view, clamped_frames })
}
