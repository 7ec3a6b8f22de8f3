//! What a robot recorded: skeletons, transforms or markers, and targets; and what was not seen.

use handover_mesh::bodies::{Body, to_joint_state, to_markers, to_transforms};
use handover_mesh::formats::bag::Read;
use handover_mesh::messages::{
    Duration, Header, MarkerArray, Message, MultiDofJointState, MultiDofPoint, MultiDofTrajectory,
    PoseStamped, Quaternion, Time, Transform, TransformStamped, TransformTree, Vector3, encode,
};
use handover_mesh::{Point, Recording, Role, Skeleton, Span, Stamp, Vector};

use nalgebra::{Isometry3, UnitQuaternion};

use super::scenes::{STEP, Sent, bag_of, place, read};

/// Somebody at a frame.
fn body(person: usize, frame: i64, frame_id: &str) -> Body {
    let names = Skeleton::nite();
    let joints = names.names().iter().enumerate();
    let joints = joints.map(|(joint, name)| (name.clone(), place(person, frame, joint)));
    Body {
        stamp: Stamp(frame * STEP),
        frame: frame_id.to_owned(),
        id: Some(4),
        joints: joints.collect(),
    }
}

fn sent<M: Message>(topic: &str, stamp: Stamp, message: &M) -> Sent {
    (topic.to_owned(), M::TYPE.to_owned(), stamp, encode(message))
}

/// The robot's target at a stamp of its own: frame `frame` and a part of the next.
fn target(frame: i64, part: f64) -> Sent {
    let (now, next) = (body(1, frame, "world"), body(1, frame + 1, "world"));
    let transforms = now.joints.iter().zip(&next.joints).map(|((_, a), (_, b))| Transform {
        translation: (a + (b - a) * part).into(),
        ..Transform::default()
    });
    let stamp = Stamp(frame * STEP) + Span((part * STEP as f64) as i64);
    let later = MultiDofPoint {
        time_from_start: Duration::of(Span(100_000_000)),
        transforms: vec![Transform::default(); 15],
        ..Default::default()
    };
    let message = MultiDofTrajectory {
        header: Header { stamp: Time::of(stamp), frame_id: "/world".to_owned() },
        joint_names: now.joints.iter().map(|(name, _)| name.clone()).collect(),
        points: vec![
            MultiDofPoint { transforms: transforms.collect(), ..Default::default() },
            later,
        ],
    };
    sent("/handover/joint_targets", stamp, &message)
}

/// Partner by `partner`, robot by targets between the frames.
fn live(frames: i64, partner: impl Fn(i64) -> Vec<Sent>) -> Vec<Sent> {
    let targets = |frame| [target(frame, 0.25), target(frame, 0.75)];
    (0..frames).flat_map(|frame| partner(frame).into_iter().chain(targets(frame))).collect()
}

fn skeleton(frame: i64) -> Vec<Sent> {
    let message = to_joint_state(&body(0, frame, "world"));
    vec![sent("/robot_1/skeleton", Stamp(frame * STEP), &message)]
}

#[track_caller]
fn check_live(found: &Read, frames: std::ops::Range<i64>) {
    let recording = &found.recording;
    let names = recording.people().each_ref().map(|person| person.name.as_str());
    assert_eq!(names, ["partner", "robot"]);
    let stamps: Vec<Stamp> = recording.stamps().collect();
    assert_eq!(stamps, frames.clone().map(|k| Stamp(k * STEP)).collect::<Vec<_>>());
    for (at, frame) in frames.enumerate() {
        for joint in 0..15 {
            let of = |role| recording.person(role).motion.frames()[at].positions[joint];
            assert_eq!(of(Role::First), place(0, frame, joint), "as it was sent");
            let apart = of(Role::Second) - place(1, frame, joint);
            assert!(apart.norm() < 0.01, "between the targets: {apart}");
        }
    }
}

#[test]
fn a_live_bag_is_the_partner_and_the_robot() {
    let found = read(&bag_of(&live(20, skeleton))).unwrap();
    check_live(&found, 1..20);
    assert_eq!(
        found.notes,
        [
            "interpolated: robot at 19 stamps of partner's frames",
            "left out: 1 of 20 frames of partner at which robot is not known",
        ]
    );
}

#[test]
fn transforms_and_markers_show_the_partner_as_a_skeleton_does() {
    let transforms = |frame: i64| {
        let stamp = Stamp(frame * STEP);
        let tree = to_transforms(&body(0, frame, "world")).transforms;
        // One message for each joint, beside frames that are none of a body.
        let each = tree.into_iter().map(|edge| TransformTree { transforms: vec![edge] });
        each.map(|message| sent("/tf", stamp, &message)).collect()
    };
    check_live(&read(&bag_of(&live(20, transforms))).unwrap(), 1..20);
    let markers = |frame: i64| {
        let message: MarkerArray = to_markers(&body(0, frame, "world"));
        vec![sent("/skeleton_markers", Stamp(frame * STEP), &message)]
    };
    check_live(&read(&bag_of(&live(20, markers))).unwrap(), 1..20);
    // All of them at once are still one partner.
    let all = |frame: i64| {
        let mut all: Vec<Sent> = transforms(frame);
        all.extend(markers(frame));
        all.extend(skeleton(frame));
        all
    };
    check_live(&read(&bag_of(&live(20, all))).unwrap(), 1..20);
}

#[test]
fn static_transforms_join_frames_and_nothing_else_does() {
    let shift = Vector3 { x: 0.5, y: -0.25, z: 1.0 };
    let seen = |frame: i64| {
        let mut body = body(0, frame, "camera");
        for (_, place) in &mut body.joints {
            *place = Point::new(place.x - 0.5, place.y + 0.25, place.z - 1.0);
        }
        vec![sent("/skeleton", Stamp(frame * STEP), &to_joint_state(&body))]
    };
    let mut messages = live(20, seen);
    let error = read(&bag_of(&messages)).unwrap_err().to_string();
    let expected = "message 1 of /skeleton: places are in 'camera', others in 'world' (hint: \
                    neither /tf_static nor /tf of the bag joins them then)";
    assert!(error.starts_with(expected), "{error}");
    let mount = TransformStamped {
        header: Header { stamp: Time::default(), frame_id: "world".to_owned() },
        child_frame_id: "/camera".to_owned(),
        transform: Transform { translation: shift, ..Transform::default() },
    };
    let mount = TransformTree { transforms: vec![mount] };
    messages.push(sent("/tf_static", Stamp(0), &mount));
    let found = read(&bag_of(&messages)).unwrap();
    let partner = &found.recording.person(Role::First).motion;
    let apart = partner.frames()[2].positions[7] - place(0, 3, 7);
    assert!(apart.norm() < 1e-12, "{apart}");
}

#[test]
fn a_camera_on_a_head_that_turns_sees_the_partner_where_they_are() {
    let camera = |frame: i64| {
        let (angle, at) = (0.02 * frame as f64, Vector3 { x: 0.5, y: 0.01 * frame as f64, z: 1.0 });
        let turn = UnitQuaternion::from_axis_angle(&nalgebra::Vector3::z_axis(), angle);
        (Isometry3::from_parts(Vector::from(at).into(), turn), at)
    };
    let seen = |told: std::ops::Range<i64>| {
        move |frame: i64| {
            let (world_from_camera, translation) = camera(frame);
            let mut body = body(0, frame, "camera");
            for (_, place) in &mut body.joints {
                *place = world_from_camera.inverse() * *place;
            }
            let q = world_from_camera.rotation.coords;
            let rotation = Quaternion { x: q.x, y: q.y, z: q.z, w: q.w };
            let stamp = Stamp(frame * STEP);
            let neck = TransformStamped {
                header: Header { stamp: Time::of(stamp), frame_id: "world".to_owned() },
                child_frame_id: "camera".to_owned(),
                transform: Transform { translation, rotation },
            };
            let mut messages = vec![sent("/skeleton", stamp, &to_joint_state(&body))];
            if told.contains(&frame) {
                messages.push(sent("/tf", stamp, &TransformTree { transforms: vec![neck] }));
            }
            messages
        }
    };
    // Whoever is seen by it second is not what the room turns about.
    let two = (0..20).flat_map(|frame| {
        let giver = to_joint_state(&body(1, frame, "world"));
        let mut messages = vec![sent("/giver/skeleton", Stamp(frame * STEP), &giver)];
        messages.extend(seen(0..20)(frame));
        messages[1].0 = "/receiver/skeleton".to_owned();
        messages
    });
    let found = read(&bag_of(&two.collect::<Vec<_>>())).unwrap();
    let note = "brought from frame 'camera' into 'world': 20 of 20 messages of /receiver/skeleton";
    assert_eq!(found.notes, [note]);
    for (role, person) in [(Role::First, 1), (Role::Second, 0)] {
        for (frame, known) in found.recording.person(role).motion.frames().iter().zip(0..) {
            assert!((frame.positions[7] - place(person, known, 7)).norm() < 1e-12, "{known}");
        }
    }
    let found = read(&bag_of(&live(20, seen(0..20)))).unwrap();
    let partner = &found.recording.person(Role::First).motion;
    for (frame, known) in partner.frames().iter().zip(1..) {
        let apart = frame.positions[7] - place(0, known, 7);
        assert!(apart.norm() < 1e-12, "{known}: {apart}");
    }
    // What was said a second before holds no more.
    let error = read(&bag_of(&live(60, seen(0..20)))).unwrap_err().to_string();
    assert!(error.contains("message 51 of /skeleton: places are in 'camera'"), "{error}");
    assert!(!error.contains("message 50 of /skeleton"), "{error}");
}

/// Two people on topics of their own, at the same stamps, changed by `change`.
fn pair(frames: i64, change: impl Fn(&str, i64, &mut MultiDofJointState)) -> Vec<Sent> {
    let of = |person: usize, name: &str, frame: i64| {
        let mut message = to_joint_state(&body(person, frame, "world"));
        change(name, frame, &mut message);
        sent(&format!("/{name}/skeleton"), Stamp(frame * STEP), &message)
    };
    (0..frames).flat_map(|frame| [of(0, "giver", frame), of(1, "receiver", frame)]).collect()
}

const LEFT_HAND: usize = 5;

#[test]
fn who_is_out_of_sight_for_a_moment_is_put_on_the_line() {
    let lost = |name: &str, frame: i64, message: &mut MultiDofJointState| {
        let hand = &mut message.transforms[LEFT_HAND].translation;
        if name == "giver" && (4..8).contains(&frame) {
            hand.x = f64::NAN;
        }
    };
    let found = read(&bag_of(&pair(20, lost))).unwrap();
    let words = "filled in: 4 places of joints of giver that were not tracked for at most 0.5 s";
    assert_eq!(found.notes, [words]);
    let hand = |frame: usize| {
        found.recording.person(Role::First).motion.frames()[frame].positions[LEFT_HAND]
    };
    let middle = between(hand(3), hand(8), 0.4);
    assert!((hand(5) - middle).norm() < 1e-6, "{} {middle}", hand(5));
    assert_eq!(hand(8), place(0, 8, LEFT_HAND));
    let still = read(&bag_of(&pair(20, |_, _, _| {}))).unwrap();
    assert!(still.notes.is_empty());
    let same = |r: &Recording| r.person(Role::Second).clone();
    assert_eq!(same(&found.recording), same(&still.recording));
}

fn between(from: Point, to: Point, part: f64) -> Point {
    from + (to - from) * part
}

#[test]
fn who_is_out_of_sight_for_long_is_named_and_what_is_never_seen_left_out() {
    let long = |name: &str, frame: i64, message: &mut MultiDofJointState| {
        if name == "receiver" && (10..30).contains(&frame) {
            message.joint_names.remove(LEFT_HAND);
            message.transforms.remove(LEFT_HAND);
        }
    };
    let error = read(&bag_of(&pair(60, long))).unwrap_err().to_string();
    let expected = "message 11 of /receiver/skeleton: 'left_hand' of 'receiver' is not tracked \
                    from here on for 0.7 s";
    assert_eq!(error, expected);
    let rare = |_: &str, frame: i64, message: &mut MultiDofJointState| {
        if frame % 3 != 0 {
            message.joint_names.remove(LEFT_HAND);
            message.transforms.remove(LEFT_HAND);
        }
    };
    let found = read(&bag_of(&pair(30, rare))).unwrap();
    assert_eq!(found.recording.people()[0].motion.skeleton().len(), 14);
    assert_eq!(found.notes[0], "left out: 'left_hand' of giver, tracked in 10 of 30 messages");
    // Before somebody is seen whole nothing is made up.
    let late = |name: &str, frame: i64, message: &mut MultiDofJointState| {
        if name == "giver" && frame < 5 {
            message.transforms[0].translation.z = f64::INFINITY;
        }
    };
    let found = read(&bag_of(&pair(30, late))).unwrap();
    assert_eq!(
        (found.recording.len(), found.recording.stamps().next()),
        (25, Some(Stamp(5 * STEP)))
    );
    assert!(found.notes[0].starts_with("left out: 5 of 30 messages of giver at the beginning"));
}

#[test]
fn bags_of_one_or_three_people_say_who_there_is() {
    let mut messages = pair(10, |_, _, _| {});
    let mut third = messages[0].clone();
    third.0 = "/guest/skeleton".to_owned();
    messages.push(third);
    let error = read(&bag_of(&messages)).unwrap_err().to_string();
    let expected = "two people are needed, found 3 (giver in /giver/skeleton, 10 times, receiver in \
                    /receiver/skeleton, 10 times, guest in /guest/skeleton, 1 times); topics: \
                    /giver/skeleton (sensor_msgs/msg/MultiDOFJointState, 10), ";
    assert!(error.starts_with(expected), "{error}");
    let pose = PoseStamped::default();
    let error = read(&bag_of(&[sent("/elsewhere", Stamp(0), &pose)])).unwrap_err().to_string();
    let expected = "two people are needed, found none; topics: /elsewhere \
                    (geometry_msgs/msg/PoseStamped, 1)";
    assert_eq!(error, expected);
}

#[test]
fn broken_messages_are_named_with_topic_and_number() {
    let mut messages = pair(10, |name, frame, message| {
        if name == "giver" && frame == 3 {
            message.transforms.pop();
        }
        if name == "receiver" && frame == 4 {
            message.transforms[0].translation.x = 1700.0;
        }
        if name == "receiver" && frame == 6 {
            message.header.stamp = Time::of(Stamp(5 * STEP));
        }
        if name == "giver" && frame == 7 {
            message.joint_names[0] = "tail".to_owned();
        }
    });
    messages[1].3.truncate(40);
    let error = read(&bag_of(&messages)).unwrap_err().to_string();
    for expected in [
        "message 1 of /receiver/skeleton: sensor_msgs/msg/MultiDOFJointState: ",
        "message 4 of /giver/skeleton: 15 joint names, but 14 places",
        "message 5 of /receiver/skeleton: field 'head': 1700 m is farther than 1000 m",
        "message 7 of /receiver/skeleton: stamp 0.1667 s is not after 0.1667 s",
        "message 8 of /giver/skeleton: person 'giver': unknown joint 'tail'",
    ] {
        assert!(error.contains(expected), "no '{expected}' in {error}");
    }
}

#[test]
fn what_was_sent_twice_counts_once() {
    let mut messages = pair(10, |_, _, _| {});
    let again = messages[6].clone();
    messages.insert(8, again);
    let found = read(&bag_of(&messages)).unwrap();
    assert_eq!((found.recording.len(), found.notes.len()), (10, 0));
}

#[test]
fn a_change_of_rate_is_named_where_frames_are() {
    let slower = |frame: i64| Stamp(if frame < 20 { frame } else { 2 * frame - 20 } * STEP);
    let messages = pair(40, |_, frame, message| message.header.stamp = Time::of(slower(frame)));
    let error = read(&bag_of(&messages)).unwrap_err().to_string();
    let expected = "message 21 of /giver/skeleton: mixed rates: 15.0 Hz from here on, 30.0 Hz in \
                    most of the file";
    assert_eq!(error, expected);
    // A robot ticks as it likes.
    let mut live = live(40, skeleton);
    live.retain(|(topic, _, time, _)| !topic.ends_with("targets") || time.0 % 3 > 0);
    assert!(read(&bag_of(&live)).is_ok());
}
