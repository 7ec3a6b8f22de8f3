//! A [`Recording`] → CSV that reads back as the same recording.

use super::super::field;
use super::{HEADER, OBJECT, metadata};
use crate::geometry::Point;
use crate::skeleton::{Part, Recording};
use crate::time::Stamp;

/// Why a recording cannot be written as CSV.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WriteError {
    /// Rows of a person of this name would be read as the object's, or as nobody's.
    #[error("a person cannot be called '{name}' in a CSV")]
    PersonName {
        /// The name.
        name: String,
    },
    /// Blank, or with blanks at its ends.
    #[error("an object cannot be called '{name}' in a CSV")]
    ObjectName {
        /// The name.
        name: String,
    },
    /// A joint that no reader knows, so its bones would be lost.
    #[error("'{person}' has a joint '{joint}' that a CSV cannot hold: its name is not known")]
    UnknownJoint {
        /// Whose joint.
        person: String,
        /// Its name.
        joint: String,
    },
    /// A CSV has one time for all that is in a frame.
    #[error("the object's place at {time} is at none of the frames' times")]
    ObjectBetweenFrames {
        /// When.
        time: Stamp,
    },
}

/// Writes the recording: metadata sorted, one row a joint, `\n` line ends.
///
/// [`read`](super::read) gives the same recording back, names, stamps and coordinates to the bit,
/// if its joints are in canonical order as every reader leaves them and within 1000 m. What rides on
/// a joint is left out: it says no more than the joint and the object do.
///
/// # Errors
/// [`WriteError`] if the recording holds what a CSV cannot.
pub fn write(recording: &Recording) -> Result<String, WriteError> {
    // The shortest text of an f64 that reads back as the same bits is what Display gives.
    write_by(recording, |coordinate| coordinate.to_string())
}

/// As [`write()`], with places rounded to the micrometre: less than half the bytes, and nobody's
/// joints are known better.
///
/// # Errors
/// [`WriteError`] if the recording holds what a CSV cannot.
pub fn write_rounded(recording: &Recording) -> Result<String, WriteError> {
    // Adding zero makes `0` of the `-0` that a small negative is rounded to.
    write_by(recording, |coordinate| ((coordinate * 1e6).round() / 1e6 + 0.0).to_string())
}

fn write_by(
    recording: &Recording,
    coordinate: impl Fn(f64) -> String,
) -> Result<String, WriteError> {
    check_names(recording)?;
    let mut rows = ::csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    let points = recording.object().map_or(&[][..], |object| &object.points);
    let mut places: Vec<_> = points.iter().map(|point| point.places.iter().peekable()).collect();
    for (number, stamp) in recording.stamps().enumerate() {
        let head = [number.to_string(), field::stamp_text(stamp)];
        for person in recording.people() {
            let (skeleton, frame) = (person.motion.skeleton(), &person.motion.frames()[number]);
            let joints = skeleton.names().iter().zip(&frame.positions);
            for (joint, point) in joints.take(skeleton.own()) {
                write_row(&mut rows, &head, [&person.name, joint], point, &coordinate);
            }
        }
        for (object, places) in points.iter().zip(&mut places) {
            if let Some((time, point)) = places.next_if(|(time, _)| *time <= stamp) {
                if *time < stamp {
                    return Err(WriteError::ObjectBetweenFrames { time: *time });
                }
                write_row(&mut rows, &head, [OBJECT, &object.name], point, &coordinate);
            }
        }
    }
    if let Some((time, _)) = places.iter_mut().find_map(Iterator::next) {
        return Err(WriteError::ObjectBetweenFrames { time: *time });
    }
    let rows = rows.into_inner().unwrap_or_default();
    let rows = String::from_utf8(rows).unwrap_or_default();
    Ok(format!("{}{HEADER}\n{rows}", metadata::lines(recording.metadata())))
}

fn write_row(
    rows: &mut ::csv::Writer<Vec<u8>>,
    [number, time]: &[String; 2],
    [person, joint]: [&str; 2],
    point: &Point,
    coordinate: impl Fn(f64) -> String,
) {
    let [x, y, z] = [point.x, point.y, point.z].map(coordinate);
    // Cannot fail: the rows go to memory and all have as many fields.
    let _ = rows.write_record([number, time, person, joint, &x, &y, &z]);
}

fn check_names(recording: &Recording) -> Result<(), WriteError> {
    let blank = |name: &str| name.trim().is_empty() || name.trim() != name;
    for person in recording.people() {
        let name = &person.name;
        if blank(name) || name == OBJECT {
            return Err(WriteError::PersonName { name: name.clone() });
        }
        let skeleton = person.motion.skeleton();
        for joint in &skeleton.names()[..skeleton.own()] {
            if Part::from_name(joint).is_none() {
                let (person, joint) = (name.clone(), joint.clone());
                return Err(WriteError::UnknownJoint { person, joint });
            }
        }
    }
    let mut points = recording.object().into_iter().flat_map(|object| &object.points);
    match points.find(|point| blank(&point.name)) {
        Some(point) => Err(WriteError::ObjectName { name: point.name.clone() }),
        None => Ok(()),
    }
}
