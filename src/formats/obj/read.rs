//! The bytes of an OBJ file → a shape, or all that is wrong with them.

use std::num::NonZeroU32;
use std::ops::Range;

use super::super::error::{Place, ReadError, Reason, Violations, shortened};
use super::super::field;
use super::shape::{Corner, Obj};
use super::statements::{Statement, Statements};
use crate::geometry::Point;

/// Vertices, texture coordinates and normals: all there are, or those so far.
type Counts = [usize; 3];

/// What the three indices of a corner count, and the statements that these are.
const KINDS: [(&str, &[u8]); 3] =
    [("vertex", b"v"), ("texture coordinate", b"vt"), ("normal", b"vn")];

struct Reader {
    obj: Obj,
    /// In the whole file: faces may come before what they name.
    all: Counts,
    so_far: Counts,
    violations: Violations,
    /// Vertices of the face at hand, kept for their room.
    vertices: Vec<u32>,
}

pub(super) fn read(bytes: &[u8]) -> Result<Obj, ReadError> {
    let mut all = [0; 3];
    for statement in Statements::of(bytes) {
        if let Some(kind) = kind(&statement) {
            all[kind] += 1;
        }
    }
    let obj = Obj {
        bytes: bytes.to_vec(),
        positions: Vec::new(),
        vertex_spans: Vec::new(),
        normal_spans: Vec::new(),
        corners: Vec::new(),
        ends: Vec::new(),
    };
    let mut reader = Reader {
        obj,
        all,
        so_far: [0; 3],
        violations: Violations::default(),
        vertices: Vec::new(),
    };
    let mut faces = 0;
    for statement in Statements::of(bytes) {
        match kind(&statement) {
            Some(kind) => {
                reader.element(kind, &statement);
                reader.so_far[kind] += 1;
            }
            None if statement.keyword == b"f" => {
                reader.face(&statement);
                faces += 1;
            }
            None => {}
        }
    }
    let Reader { obj, mut violations, .. } = reader;
    for (count, what) in [(all[0], "a vertex (v x y z)"), (faces, "a face (f 1 2 3)")] {
        if count == 0 {
            violations.add(Place::File, Reason::Missing { what: what.into() });
        }
    }
    violations.or(Some(obj))
}

/// What a statement adds one of.
fn kind(statement: &Statement<'_>) -> Option<usize> {
    KINDS.iter().position(|(_, keyword)| *keyword == statement.keyword)
}

impl Reader {
    /// `v x y z …`, `vt u …` or `vn x y z`.
    fn element(&mut self, kind: usize, statement: &Statement<'_>) {
        let names: &[&str] =
            [&["v.x", "v.y", "v.z"][..], &["vt.u"], &["vn.x", "vn.y", "vn.z"]][kind];
        let mut values = [0.0; 3];
        let mut span: Option<Range<usize>> = None;
        let mut got = 0;
        for ((at, word), (name, value)) in statement.words().zip(names.iter().zip(&mut values)) {
            got += 1;
            span = Some(span.map_or(at.start, |span| span.start)..at.end);
            match field::number(&String::from_utf8_lossy(word), || (*name).into()) {
                Ok(number) => *value = number,
                Err(reason) => self.violations.add(statement.line, reason),
            }
        }
        if got < names.len() {
            let reason = Reason::FieldCount { expected: names.len(), got };
            self.violations.add(statement.line, reason);
        }
        let Some(span) = span else { return };
        match kind {
            0 => {
                self.obj.positions.push(Point::from(values));
                self.obj.vertex_spans.push(span);
            }
            1 => {}
            _ => self.obj.normal_spans.push(span),
        }
    }

    /// `f 1 2 3`, `f 1/1 2/2 3/3`, `f 1//1 2//2 3//3`, `f 1/1/1 …`, and more corners.
    fn face(&mut self, statement: &Statement<'_>) {
        let line = statement.line;
        self.vertices.clear();
        let mut got = 0;
        for (_, word) in statement.words() {
            got += 1;
            match self.corner(word) {
                Ok(corner) => {
                    self.vertices.push(corner.vertex);
                    self.obj.corners.push(corner);
                }
                Err(reason) => self.violations.add(line, reason),
            }
        }
        self.obj.ends.push(self.obj.corners.len());
        if got < 3 {
            self.violations.add(line, Reason::TooFewCorners { got });
        }
        self.vertices.sort_unstable();
        if let Some(twice) = self.vertices.windows(2).find(|pair| pair[0] == pair[1]) {
            let vertex = u64::from(twice[0]) + 1;
            self.violations.add(line, Reason::RepeatedCorner { vertex });
        }
    }

    fn corner(&self, word: &[u8]) -> Result<Corner, Reason> {
        let text = String::from_utf8_lossy(word);
        let none = || Reason::NotACorner { value: shortened(&text) };
        let mut indices = [None; 3];
        for (at, part) in text.split('/').enumerate() {
            let index = indices.get_mut(at).ok_or_else(none)?;
            if at == 0 || !part.is_empty() {
                let number = part.parse().map_err(|_| none())?;
                *index = Some(self.index(at, number)?);
            }
        }
        let [vertex, _, normal] = indices;
        let vertex = vertex.ok_or_else(none)?.get() - 1;
        Ok(Corner { vertex, normal })
    }

    /// What an index means, counted from 1.
    fn index(&self, kind: usize, index: i64) -> Result<NonZeroU32, Reason> {
        let there = self.all[kind];
        let from_one = if index < 0 {
            i64::try_from(self.so_far[kind]).ok().and_then(|so_far| so_far.checked_add(index + 1))
        } else {
            Some(index)
        };
        let known = from_one.and_then(|from_one| u32::try_from(from_one).ok());
        known
            .filter(|known| *known as usize <= there)
            .and_then(NonZeroU32::new)
            .ok_or(Reason::NoSuchIndex { what: KINDS[kind].0, index, there })
    }
}
