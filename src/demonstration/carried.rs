//! Who carries the thing that is handed over, and where in the hand.
//!
//! After the hands met, a thing goes with the other person, and its track would tell what the human
//! in the robot's role did. So of the track only this is looked at: before the hands meet, whose
//! hand it keeps its distance to; and where in that hand it sits for the first half second in which
//! it is carried. From then on, and before, it rides on the hand.

use super::Contact;
use crate::geometry::{Point, Vector, smallest_rotation};
use crate::skeleton::{AttachError, JointId, ObjectTrack, Part, Recording, Role, Sequence};
use crate::statistics::median;
use crate::time::Stamp;

/// For how long it is looked at how a thing is held `[s]`.
const LOOKED_AT: f64 = 0.5;

/// As far from its usual distance to the hand `[m]` a thing is not yet carried.
const LOOSE: f64 = 0.1;

/// Farther than this from the hand `[m]` nothing is held: a long thing's middle, its tracker's and a
/// wrist's errors.
const REACH: f64 = 0.6;

/// What moves less than this `[m]` while the hand moves farther than [`LOOSE`] stands somewhere.
const STILL: f64 = 0.05;

/// Why a recording's object is nobody's.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CarryError {
    /// There is none.
    #[error("no object was tracked")]
    NoObject,
    /// It cannot be said whose hand it is in.
    #[error("the object is not known in two frames before the hands meet")]
    Unknown,
    /// Nobody holds it.
    #[error("nobody holds the object before the hands meet")]
    NotHeld,
    /// It has more points than are taken.
    #[error(
        "the object has {points} points, at most {most} are taken (hint: object.points={points} \
         takes all of them)"
    )]
    Points {
        /// How many it has.
        points: usize,
        /// How many are taken.
        most: usize,
    },
    /// It cannot ride on the hand.
    #[error(transparent)]
    Attach(#[from] AttachError),
}

/// A frame in which all of the object is known: where its points are, and their middle.
struct Seen {
    frame: usize,
    points: Vec<Point>,
    middle: Point,
}

/// The recording with its object's points as joints that ride on the hand that carries it: see
/// [`Recording::with_attached`]. The object's own track stays as it is.
///
/// Of the two hands that meet, the carrier's is the one whose distance to the object varies least
/// over the second half of the time before they do. It is no carrier if the object is more than 0.6 m
/// off, or stays where it is while the hand moves.
///
/// - `most`: how many points an object may have.
///
/// # Errors
/// [`CarryError`] if there is no object, if it is not known or not held before the hands meet, or
/// has too many points.
pub fn with_object_carried(recording: &Recording, most: usize) -> Result<Recording, CarryError> {
    let object = recording.object().ok_or(CarryError::NoObject)?;
    let points = object.points.len();
    if points > most {
        return Err(CarryError::Points { points, most });
    }
    let contact = Contact::closest(recording, Role::First).ok_or(CarryError::NotHeld)?;
    let seen = seen(recording, object, contact.frame);
    let late = &seen[seen.partition_point(|seen| 2 * seen.frame < contact.frame)..];
    if late.len() < 2 {
        return Err(CarryError::Unknown);
    }
    let sides = [(Role::First, contact.hands.robot), (Role::Second, contact.hands.partner)];
    let hands = sides.into_iter().filter_map(|(role, side)| {
        let hand = recording.person(role).motion.skeleton().part(Part::Hand(side))?;
        Some((role, hand))
    });
    let distance = |(role, hand): (Role, JointId), seen: &Seen| {
        (seen.middle - recording.person(role).motion.position(seen.frame, hand)).norm()
    };
    let spread = |hand: (Role, JointId)| {
        let distances = late.iter().map(|seen| distance(hand, seen));
        let mean = distances.clone().sum::<f64>() / late.len() as f64;
        (distances.map(|d| (d - mean).powi(2)).sum::<f64>() / late.len() as f64).sqrt()
    };
    let carried = hands.min_by(|a, b| spread(*a).total_cmp(&spread(*b)));
    let (role, hand) = carried.ok_or(CarryError::NotHeld)?;
    let usual = median(late.iter().map(|seen| distance((role, hand), seen)).collect());
    let usual = usual.ok_or(CarryError::Unknown)?;
    if usual > REACH || stands(&recording.person(role).motion, hand, late) {
        return Err(CarryError::NotHeld);
    }
    let is_held = |seen: &Seen| (distance((role, hand), seen) - usual).abs() <= LOOSE;
    let stamps: Vec<Stamp> = recording.stamps().collect();
    let mut looked_at = (0..seen.len()).map(|first| {
        let since = |at: &Seen| (stamps[at.frame] - stamps[seen[first].frame]).seconds();
        let count = seen[first..].partition_point(|seen| since(seen) <= LOOKED_AT);
        &seen[first..first + count]
    });
    // Near contact less than all of it is left; one frame alone tells nothing.
    let held = looked_at.find(|held| held.len() > 1 && held.iter().all(is_held));
    let held = held.ok_or(CarryError::NotHeld)?;
    let motion = &recording.person(role).motion;
    let first = held[0].frame;
    let named = object.points.iter().zip(grasp(motion, hand, held));
    let points: Vec<(String, Point)> = named
        .map(|(point, offset)| (point.name.clone(), motion.position(first, hand) + offset))
        .collect();
    Ok(recording.with_attached(role, hand, first, &points)?)
}

/// Whether an object stays where it is while a hand moves.
fn stands(motion: &Sequence, hand: JointId, late: &[Seen]) -> bool {
    let farthest = |place: &dyn Fn(&Seen) -> Point| {
        late.iter().map(|seen| (place(seen) - place(&late[0])).norm()).fold(0.0, f64::max)
    };
    farthest(&|seen| seen.middle) < STILL
        && farthest(&|seen| motion.position(seen.frame, hand)) > LOOSE
}

/// Where the object is before the hands meet.
fn seen(recording: &Recording, object: &ObjectTrack, before: usize) -> Vec<Seen> {
    let stamps = recording.stamps().enumerate().take(before);
    let seen = stamps.filter_map(|(frame, stamp)| {
        let points: Option<Vec<Point>> =
            object.points.iter().map(|point| point.place(stamp)).collect();
        let points = points?;
        let sum: Vector = points.iter().map(|p| p.coords).sum();
        Some(Seen { frame, middle: Point::from(sum / points.len() as f64), points })
    });
    seen.collect()
}

/// From the hand to each point `[m]`, with the forearm as it is in the first of these frames: the
/// median over all of them.
fn grasp(motion: &Sequence, hand: JointId, held: &[Seen]) -> Vec<Vector> {
    let bone = motion.skeleton().bones().find(|bone| bone.child == hand);
    let forearm = |frame: usize| {
        let along = |parent| motion.position(frame, hand) - motion.position(frame, parent);
        bone.map_or(Vector::zeros(), |bone| along(bone.parent))
    };
    let first = forearm(held[0].frame);
    let offset = |seen: &Seen, point: usize| {
        let turn = smallest_rotation(forearm(seen.frame), first);
        turn * (seen.points[point] - motion.position(seen.frame, hand))
    };
    let middle = |point: usize| {
        Vector::from_fn(|axis, _| {
            let values = held.iter().map(|seen| offset(seen, point)[axis]);
            median(values.collect()).unwrap_or(0.0)
        })
    };
    (0..held[0].points.len()).map(middle).collect()
}
