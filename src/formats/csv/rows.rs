//! The text of a CSV → rows of numbers, sorted into frames as they stand in the file.
//!
//! Each row is judged by itself and against the frame it stands in; what only the whole file can
//! tell is left to the assembly.

use std::collections::BTreeSet;

use super::super::detect::without_mark;
use super::super::error::{Reason, Violations, shortened};
use super::super::field;
use super::super::up::UpAxis;
use super::{COLUMNS, OBJECT};
use crate::geometry::Point;
use crate::skeleton::{Part, Skeleton, SkeletonError};
use crate::time::Stamp;

/// An object has no more points than this.
const MOST_POINTS: usize = Skeleton::MAX_JOINTS;

/// All rows that could be read.
#[derive(Default)]
pub(super) struct Table {
    pub(super) frames: Vec<FrameStart>,
    /// In the file's order, so the rows of a frame are neighbours.
    pub(super) rows: Vec<Row>,
    /// The first two people named, each with the line.
    pub(super) people: Vec<(String, u64)>,
    /// Every joint of any person.
    pub(super) joints: Vec<String>,
    /// Every point of the object.
    pub(super) points: Vec<String>,
}

/// Where a frame starts and what holds for all of it.
pub(super) struct FrameStart {
    pub(super) line: u64,
    pub(super) number: u64,
    /// `None` until a row tells it.
    pub(super) stamp: Option<Stamp>,
    /// A row was lost, which is noted; what is missing for it need not be noted again.
    pub(super) damaged: bool,
    /// Two times in one frame, which is noted once.
    disputed: bool,
}

/// Where something is in one frame.
pub(super) struct Row {
    /// Index into the table's frames.
    pub(super) frame: usize,
    pub(super) line: u64,
    pub(super) who: Who,
    /// `[m]`, z up.
    pub(super) point: Point,
}

/// Whose place it is: indices into the table's people, joints and points.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Who {
    Joint { person: usize, joint: usize },
    Object { point: usize },
}

struct Reader<'a> {
    table: Table,
    up: UpAxis,
    violations: &'a mut Violations,
    /// Names complained about: once each is enough.
    refused: BTreeSet<String>,
    known_joints_told: bool,
    /// The last row's frame could not be read: it belongs to this frame or starts the next.
    frame_lost: bool,
}

impl Table {
    /// Reads the header and all rows, noting what is wrong with each.
    pub(super) fn read(bytes: &[u8], up: UpAxis, violations: &mut Violations) -> Self {
        let bytes = without_mark(bytes);
        let (start, mut line) = header_start(bytes);
        let body = &bytes[start..];
        let mut records =
            ::csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(body);
        let mut reader = Reader {
            table: Self::default(),
            up,
            violations,
            refused: BTreeSet::new(),
            known_joints_told: false,
            frame_lost: false,
        };
        let mut record = ::csv::ByteRecord::new();
        let (mut header, mut at) = (true, 0);
        // Reading from memory in a flexible dialect: the only error there is, is the end.
        while records.read_byte_record(&mut record).unwrap_or(false) {
            // The reader's own count is that of the blank lines before a record.
            let from = record.position().map_or(at, |p| p.byte() as usize).min(body.len());
            let blank = body[from..].iter().take_while(|b| matches!(b, b'\r' | b'\n')).count();
            line += body[at..from + blank].iter().filter(|b| **b == b'\n').count() as u64;
            at = from + blank;
            let Ok(text) = ::csv::StringRecord::from_byte_record(record.clone()) else {
                reader.violations.add(line, Reason::NotUtf8);
                reader.damage();
                header = false;
                continue;
            };
            if std::mem::take(&mut header) {
                if !text.iter().map(str::trim).eq(COLUMNS) {
                    let got = text.iter().collect::<Vec<_>>().join(",");
                    reader.violations.add(line, Reason::Header { got: shortened(&got) });
                    // Rows under other columns would only repeat that.
                    break;
                }
            } else if text.len() > 1 || text.iter().any(|field| !field.trim().is_empty()) {
                reader.row(&text, line);
            }
        }
        reader.table
    }
}

/// Where the header starts, after comments and blank lines: its byte and its line.
fn header_start(bytes: &[u8]) -> (usize, u64) {
    let (mut at, mut number) = (0, 1);
    for line in bytes.split_inclusive(|byte| *byte == b'\n') {
        let text = line.trim_ascii();
        if !text.is_empty() && !text.starts_with(b"#") {
            break;
        }
        at += line.len();
        number += 1;
    }
    (at, number)
}

impl Reader<'_> {
    fn damage(&mut self) {
        self.frame_lost = true;
        if let Some(frame) = self.table.frames.last_mut() {
            frame.damaged = true;
        }
    }

    fn row(&mut self, record: &::csv::StringRecord, line: u64) {
        if record.len() != COLUMNS.len() {
            let (expected, got) = (COLUMNS.len(), record.len());
            self.violations.add(line, Reason::FieldCount { expected, got });
            return self.damage();
        }
        let field = |column: usize| record.get(column).unwrap_or("").trim();
        let frame = self.noted(line, field::frame_number(field(0), || COLUMNS[0].into()));
        let stamp = self.noted(line, field::stamp(field(1), || COLUMNS[1].into()));
        let who = self.who(field(2), field(3), line);
        let point = [4, 5, 6].map(|column| {
            let name = || COLUMNS[column].to_string();
            let metres = field::number(field(column), name)
                .and_then(|metres| field::within_reach(metres, name));
            self.noted(line, metres)
        });
        let Some(number) = frame else { return self.damage() };
        let frame = self.frame(number, stamp, line);
        match (who, point) {
            (Some(who), [Some(x), Some(y), Some(z)]) => {
                let point = self.up.to_z_up(Point::new(x, y, z));
                self.table.rows.push(Row { frame, line, who, point });
            }
            _ => self.table.frames[frame].damaged = true,
        }
    }

    fn noted<T>(&mut self, line: u64, found: Result<T, Reason>) -> Option<T> {
        found.map_err(|reason| self.violations.add(line, reason)).ok()
    }

    /// The frame a row belongs to: the last one, or a new one if the number is another.
    fn frame(&mut self, number: u64, stamp: Option<Stamp>, line: u64) -> usize {
        let mut damaged = std::mem::take(&mut self.frame_lost);
        match self.table.frames.last_mut().map(|frame| (frame.number, frame)) {
            Some((before, frame)) if before == number => {
                match (frame.stamp, stamp) {
                    (Some(first), Some(time)) if first != time && !frame.disputed => {
                        frame.disputed = true;
                        let reason = Reason::TimesDiffer { frame: number, time, first };
                        self.violations.add(line, reason);
                    }
                    _ => frame.stamp = frame.stamp.or(stamp),
                }
                return self.table.frames.len() - 1;
            }
            Some((before, _)) if number < before => {
                self.violations.add(line, Reason::FrameOrder { frame: number, before });
                damaged = true;
            }
            _ => {}
        }
        self.table.frames.push(FrameStart { line, number, stamp, damaged, disputed: false });
        self.table.frames.len() - 1
    }

    fn who(&mut self, person: &str, joint: &str, line: u64) -> Option<Who> {
        for (name, column) in [(person, 2), (joint, 3)] {
            if name.is_empty() {
                self.violations.add(line, Reason::EmptyField { field: COLUMNS[column].into() });
            }
        }
        if person.is_empty() || joint.is_empty() {
            return None;
        }
        if person == OBJECT {
            return Some(Who::Object { point: self.point(joint, line)? });
        }
        let person_known = self.person(person, line);
        let joint = self.joint(joint, person, line);
        Some(Who::Joint { person: person_known?, joint: joint? })
    }

    fn point(&mut self, name: &str, line: u64) -> Option<usize> {
        if let Some(known) = self.table.points.iter().position(|known| known == name) {
            return Some(known);
        }
        // So the search above is short, whatever the file holds.
        if self.table.points.len() == MOST_POINTS {
            if self.refused.insert("object".to_owned()) {
                self.violations.add(line, Reason::ManyPoints { most: MOST_POINTS });
            }
            return None;
        }
        self.table.points.push(name.into());
        Some(self.table.points.len() - 1)
    }

    fn person(&mut self, name: &str, line: u64) -> Option<usize> {
        if let Some(known) = self.table.people.iter().position(|(known, _)| known == name) {
            return Some(known);
        }
        if let [(first, _), (second, _)] = &self.table.people[..] {
            if self.refused.insert(format!("person/{name}")) {
                let [first, second, third] = [first, second, name].map(shortened);
                self.violations.add(line, Reason::ThirdPerson { first, second, third });
            }
            return None;
        }
        self.table.people.push((name.into(), line));
        Some(self.table.people.len() - 1)
    }

    fn joint(&mut self, name: &str, person: &str, line: u64) -> Option<usize> {
        if let Some(known) = self.table.joints.iter().position(|known| known == name) {
            return Some(known);
        }
        // So the search above is as long as there are known names, whatever the file holds.
        if Part::from_name(name).is_none() {
            self.refuse_joint(shortened(name), shortened(person), line);
            return None;
        }
        self.table.joints.push(name.into());
        Some(self.table.joints.len() - 1)
    }

    /// Once for each name; the long list of known ones once for the file.
    fn refuse_joint(&mut self, name: String, person: String, line: u64) {
        if !self.refused.insert(format!("joint/{name}")) {
            return;
        }
        let reason = if std::mem::replace(&mut self.known_joints_told, true) {
            Reason::UnknownJoint { person, joint: name }
        } else {
            Reason::Skeleton { person, source: SkeletonError::Unknown { name } }
        };
        self.violations.add(line, reason);
    }
}
