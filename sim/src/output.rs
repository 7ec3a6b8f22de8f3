//! Clips → the manifest that says what each of them is.

use handover_mesh::{Part, Point, Role, Side};
use serde_json::{Value, json};

use crate::Clip;
use crate::scene::{GIVER, PersonConfig, RECEIVER, SceneConfig};
use crate::sensor::SensorConfig;

/// What a set of clips is: seed, sensor, and every clip's parameters.
///
/// Lengths in metres, times in seconds from the clip's start, angles in radians.
pub fn manifest(seed: u64, noise: &str, sensor: &SensorConfig, clips: Vec<Value>) -> Value {
    json!({
        "format": "handover_sim manifest 1",
        "seed": seed,
        "noise": noise,
        "sensor": {
            "rate": sensor.rate,
            "stamp_jitter": sensor.stamp_jitter,
            "position": sensor.position.coords.as_slice(),
            "yaw": sensor.yaw,
            "depth_noise": sensor.depth_noise,
            "depth_step": sensor.depth_step,
            "angle_noise": sensor.angle_noise,
            "pixels": sensor.pixels,
            "joint_noise": sensor.joint_noise,
            "joint_noise_time": sensor.joint_noise_time,
            "frame_loss": sensor.frame_loss,
            "hold_rate": sensor.hold_rate,
            "hold_duration": sensor.hold_duration,
            "swap_rate": sensor.swap_rate,
            "swap_duration": sensor.swap_duration,
            "whole_body_swaps": sensor.whole_body_swaps,
        },
        "clips": clips,
    })
}

/// One clip's entry in the [`manifest`].
pub fn clip_entry(clip: &Clip) -> Value {
    let scene = &clip.scene;
    let SceneConfig { distance, gap, suit_receiver, approach, heading, centre, timing, .. } =
        scene.config();
    let moments = scene.moments();
    let people = [Role::First, Role::Second].map(|role| {
        let at = role as usize;
        let person = person_entry(scene.config().person(role));
        let Value::Object(mut person) = person else { return person };
        let shortfall = scene.pose(role, moments.contact).shortfall;
        person.insert("reach".into(), json!(moments.reach[at]));
        person.insert("retreat".into(), json!(moments.retreat[at]));
        person.insert("contact_shortfall".into(), json!(shortfall));
        person.insert("clamped_frames".into(), json!(clip.clamped_frames[at]));
        Value::Object(person)
    });
    let [giver, receiver] = people;
    let approach = approach.as_ref().map(|approach| {
        let who = [GIVER, RECEIVER][approach.role as usize];
        json!({
            "person": who,
            "distance": approach.distance,
            "walk": moments.walk,
        })
    });
    json!({
        "name": clip.truth.name(),
        "frames": clip.truth.len(),
        "lost_frames": clip.view.lost_frames,
        "swapped_frames": clip.view.swapped_frames,
        "held_joints": clip.view.held_joints,
        "duration": moments.end,
        "contact": moments.contact,
        "transfer": moments.transfer,
        "meeting_point": scene.meeting_point().coords.as_slice(),
        "distance": distance,
        "gap": gap,
        "contact_gap": contact_gap(clip),
        "suit_receiver": suit_receiver,
        "tempo": timing.tempo,
        "centre": centre,
        "heading": heading,
        "approach": approach,
        "giver": giver,
        "receiver": receiver,
    })
}

/// Between the two hands at contact, `[m]`: the planned gap where both reach.
fn contact_gap(clip: &Clip) -> f64 {
    let scene = &clip.scene;
    let hands = [Role::First, Role::Second].map(|role| {
        let hand = Part::Hand(scene.config().person(role).hand);
        let joint = clip.truth.person(role).motion.skeleton().part(hand);
        let pose = scene.pose(role, scene.moments().contact);
        joint.map_or(Point::origin(), |joint| pose.positions[joint.index()])
    });
    (hands[1] - hands[0]).norm()
}

fn person_entry(person: &PersonConfig) -> Value {
    json!({
        "stature": person.stature,
        "hand": match person.hand { Side::Left => "left", Side::Right => "right" },
        "facing": person.facing,
        "lean": person.lean,
        "twist": person.twist,
        "swivel": person.swivel,
        "carry": person.carry,
    })
}
