//! Things in hands as further joints: where they ride, who carries them, and that ticks take them.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic as tests do")]

#[path = "common/handovers.rs"]
#[allow(dead_code, reason = "every test uses some of it")]
mod handovers;

use std::sync::Arc;

use handover_mesh::demonstration::{CarryError, Demonstration, with_object_carried};
use handover_mesh::filter::Sighting;
use handover_mesh::formats::csv;
use handover_mesh::geometry::yaw_isometry;
use handover_mesh::online::{OnlineSettings, Pipeline, TickInput};
use handover_mesh::retarget::Transform;
use handover_mesh::skeleton::{AttachError, Riders};
use handover_mesh::track::Who;
use handover_mesh::{
    ObjectTrack, Point, PointTrack, Recording, Role, Skeleton, SkeletonError, Stamp, Vector,
};

const HAND: usize = 8;
const ELBOW: usize = 7;

fn bare(seed: u64) -> Recording {
    handovers::Handover::new(seed).recording(&format!("clip_{seed}"))
}

/// The recording with an object of two points: from a table to the giver's right hand, and from
/// where the hands meet on in the receiver's.
fn with_object(bare: &Recording, picked_up: usize) -> Recording {
    let [giver, receiver] = [Role::First, Role::Second].map(|role| &bare.person(role).motion);
    let gap = |k: usize| {
        (giver.frames()[k].positions[HAND] - receiver.frames()[k].positions[HAND]).norm()
    };
    let met = (0..bare.len()).min_by(|a, b| gap(*a).total_cmp(&gap(*b))).unwrap();
    let point = |name: &str, along: f64| {
        let place = |(k, stamp): (usize, Stamp)| {
            let who = if k < met { giver } else { receiver };
            let pose = &who.frames()[k].positions;
            let forearm = (pose[HAND] - pose[ELBOW]).normalize();
            let table = Point::new(-0.4, -0.8, 0.7 + along);
            (stamp, if k < picked_up { table } else { pose[HAND] + along * forearm })
        };
        PointTrack { name: name.into(), places: bare.stamps().enumerate().map(place).collect() }
    };
    let object = ObjectTrack { points: vec![point("rim", 0.2), point("base", 0.05)] };
    let (people, words) = (bare.people().clone(), bare.metadata().clone());
    Recording::new(bare.name(), people, Some(object), words).unwrap()
}

#[test]
fn attached_points_keep_their_distance_to_the_hand() {
    let bare = bare(1);
    let motion = &bare.person(Role::First).motion;
    let hand = motion.skeleton().joint("right_hand").unwrap();
    let cup = motion.position(12, hand) + Vector::new(0.1, 0.02, -0.05);
    let points = [("cup".to_owned(), cup)];
    let carried = motion.with_attached(hand, 12, &points).unwrap();
    let skeleton = carried.skeleton();
    assert_eq!((skeleton.own(), skeleton.len(), skeleton.attached().len()), (15, 16, 1));
    assert_eq!(skeleton.without_attached(), **motion.skeleton());
    let cup = skeleton.joint("cup").unwrap();
    assert_eq!(skeleton.part_of(cup), None);
    let angle = |k: usize| {
        let pose = &carried.frames()[k].positions;
        (pose[15] - pose[HAND]).angle(&(pose[HAND] - pose[ELBOW]))
    };
    for k in 0..carried.len() {
        let pose = &carried.frames()[k].positions;
        assert_eq!(pose[..15], *motion.frames()[k].positions);
        let off = (pose[15] - pose[HAND]).norm()
            - points[0].1.coords.metric_distance(&motion.position(12, hand).coords);
        assert!(off.abs() < 1e-12, "{k}: {off}");
        assert!((angle(k) - angle(12)).abs() < 1e-6, "turned along with the forearm");
    }
    assert!((carried.position(12, cup) - points[0].1).norm() < 1e-12);
    // Whoever turns with all they hold, holds it as before.
    let turn = yaw_isometry(2.0, Vector::new(1.0, -2.0, 0.3));
    let turned = motion.transformed(&turn);
    let other = turned.with_attached(hand, 12, &[("cup".into(), turn * points[0].1)]).unwrap();
    for (a, b) in carried.transformed(&turn).frames().iter().zip(other.frames()) {
        assert!((a.positions[15] - b.positions[15]).norm() < 1e-9);
    }

    let again = carried.with_attached(hand, 0, &points).unwrap_err();
    let repeated = SkeletonError::Repeated { name: "cup".into() };
    assert_eq!(again, AttachError::Skeleton(repeated));
    let nowhere = [("lid".to_owned(), Point::new(0.0, f64::NAN, 0.0))];
    assert!(matches!(carried.with_attached(hand, 0, &nowhere), Err(AttachError::Sequence(_))));
    let many: Vec<_> = (0..50).map(|k| (format!("vertex_{k}"), Point::origin())).collect();
    assert!(matches!(motion.with_attached(hand, 0, &many), Err(AttachError::Skeleton(_))));
}

#[test]
fn what_is_not_seen_sits_as_before() {
    let bare = Skeleton::nite();
    let skeleton = bare.with_attached(bare.joint("right_hand").unwrap(), &["cup".into()]).unwrap();
    let mut pose: Vec<Point> = (0..16).map(|k| Point::new(0.1 * f64::from(k), 0.0, 1.0)).collect();
    let mut riders = Riders::new(&skeleton, &pose);
    let before = riders.clone();
    for unseen in [ELBOW, HAND, 15] {
        let mut pose = pose.clone();
        pose[15].z = 5.0;
        pose[unseen].x = f64::NAN;
        riders.take(&pose);
        assert_eq!(riders, before);
    }
    pose[15] = pose[HAND] + Vector::z();
    riders.take(&pose);
    pose[15] = Point::origin();
    riders.place(&mut pose);
    assert_eq!(pose[15], pose[HAND] + Vector::z());
}

#[test]
fn bones_of_bodies_and_of_things_are_told_apart() {
    let names = ["torso", "left_hand", "rim", "base"].map(String::from).to_vec();
    let bones = [[1, 3], [0, 1], [1, 2]];
    let skeleton = Skeleton::new_with_attached(names.clone(), &bones, 2).unwrap();
    assert_eq!((skeleton.own(), skeleton.attached().len()), (2, 2));
    let ends = skeleton.bones().map(|bone| [bone.parent.index(), bone.child.index()]);
    assert_eq!(ends.collect::<Vec<_>>(), [[0, 1], [1, 2], [1, 3]]);
    assert_eq!(Skeleton::new_with_attached(names.clone(), &bones, 0).unwrap().own(), 4);
    for (bones, attached) in [
        (vec![[0, 1], [1, 2]], 2),
        (vec![[0, 1], [1, 2], [2, 3]], 2),
        (vec![[0, 1], [1, 2], [1, 3], [0, 3]], 2),
        (vec![[0, 1], [1, 2], [1, 3], [0, 4]], 2),
        (vec![[0, 1], [1, 2], [9, 3]], 2),
        (vec![[0, 1], [1, 2], [1, 3]], 3),
        (vec![[0, 1], [1, 2], [1, 3]], 9),
    ] {
        let found = Skeleton::new_with_attached(names.clone(), &bones, attached);
        assert!(found.is_err(), "{bones:?} {attached}: {found:?}");
    }
}

#[test]
fn the_carrier_is_whoever_holds_it_before_the_hands_meet() {
    for picked_up in [0, 20] {
        let recording = with_object(&bare(2), picked_up);
        let carried = with_object_carried(&recording, 2).unwrap();
        assert_eq!(carried.object(), recording.object());
        assert_eq!(carried.person(Role::Second), recording.person(Role::Second));
        let giver = &carried.person(Role::First).motion;
        assert_eq!(giver.skeleton().names()[15..], ["base", "rim"]);
        let parents = giver.skeleton().bones().skip(14).map(|bone| bone.parent.index());
        assert!(parents.eq([HAND; 2]));
        for frame in giver.frames() {
            let pose = &frame.positions;
            let forearm = (pose[HAND] - pose[ELBOW]).normalize();
            // From the first frame to the last, whoever has it then.
            assert!((pose[15] - (pose[HAND] + 0.05 * forearm)).norm() < 1e-9);
            assert!((pose[16] - (pose[HAND] + 0.2 * forearm)).norm() < 1e-9);
        }
    }
    let recording = with_object(&bare(2), 0);
    let many = with_object_carried(&recording, 1).unwrap_err();
    assert_eq!(many, CarryError::Points { points: 2, most: 1 });
    assert_eq!(with_object_carried(&bare(2), 1).unwrap_err(), CarryError::NoObject);
    let with = |object: ObjectTrack| {
        let people = recording.people().clone();
        Recording::new("other", people, Some(object), Default::default()).unwrap()
    };
    let late = recording.object().unwrap().points[0].places[80..].to_vec();
    let late = with(ObjectTrack::of_point("cup", late));
    assert_eq!(with_object_carried(&late, 1).unwrap_err(), CarryError::Unknown);
    // Something that stands on the table, near and far.
    for place in [Point::new(0.55, 0.1, 1.0), Point::new(5.0, 5.0, 1.0), Point::origin()] {
        let places = recording.stamps().map(|stamp| (stamp, place)).collect();
        let still = with(ObjectTrack::of_point("cup", places));
        assert_eq!(with_object_carried(&still, 1).unwrap_err(), CarryError::NotHeld, "{place}");
    }
    // Now here, now there.
    let places = recording.stamps().enumerate();
    let places = places.map(|(k, stamp)| (stamp, Point::new((k % 3) as f64, 9.0, 0.0)));
    let wild = with(ObjectTrack::of_point("cup", places.collect()));
    assert_eq!(with_object_carried(&wild, 1).unwrap_err(), CarryError::NotHeld);
}

#[test]
fn what_rides_on_a_joint_is_not_written() {
    let recording = with_object(&bare(3), 0);
    let carried = with_object_carried(&recording, 2).unwrap();
    assert_eq!(csv::write(&carried), csv::write(&recording));
}

/// Ticks of a giver and of a receiver, each with the object in the mesh: it stays in the hand, and
/// nothing is allocated. What the tracker says of the object may be missing.
#[test]
fn ticks_take_what_rides_on_either_hand() {
    for role in ["giver", "receiver"] {
        let demonstrations = (0..4).map(|seed| {
            let recording = with_object_carried(&with_object(&bare(seed), 0), 2).unwrap();
            Arc::new(Demonstration::new(Arc::new(recording), role, "torso").unwrap())
        });
        let demonstrations: Vec<Arc<Demonstration>> = demonstrations.collect();
        let seen = demonstrations[0].observation();
        let model = handovers::model(demonstrations, Transform::None, OnlineSettings::default());
        let mut pipeline = Pipeline::new(model.clone(), &seen.bone_lengths, true).unwrap();
        let (mut solved, mut before) = (0, Point::origin());
        for (k, frame) in seen.partner.frames().iter().enumerate() {
            let mut positions = frame.positions.to_vec();
            if k > 10 && k % 2 == 0 {
                positions[15..].fill(Point::new(f64::NAN, f64::NAN, f64::NAN));
            }
            let sighting = Sighting {
                stamp: frame.stamp,
                body: None,
                positions: &positions,
                confidences: &[],
            };
            let robot = Some(&seen.first_pose[..]);
            let input = TickInput { now: frame.stamp, sighting: Some(sighting), robot };
            let mut held = None;
            let allocations = allocation_counter::measure(|| {
                let tick = pipeline.tick(&input);
                solved += usize::from(tick.solved.is_some());
                let who = if role == "giver" { Who::Robot } else { Who::Partner };
                let pose = match who {
                    Who::Robot => tick.target.map(|target| target.positions()),
                    Who::Partner => tick.partner,
                };
                held = pose.map(|pose| (pose.len(), pose[HAND], pose[15], pose[16]));
            });
            assert_eq!(allocations.count_total, 0, "{role}, frame {k}");
            if let Some((joints, hand, base, rim)) = held {
                assert_eq!(joints, 17);
                assert!(((base - hand).norm() - 0.05).abs() < 2e-3, "{role}, frame {k}");
                assert!(((rim - hand).norm() - 0.2).abs() < 2e-3, "{role}, frame {k}");
                before = rim;
            }
        }
        assert!(solved > seen.len() / 2, "{role}: {solved}");
        assert_ne!(before, Point::origin());
    }
}
