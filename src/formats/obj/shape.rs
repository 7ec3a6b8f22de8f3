//! What an OBJ file holds, beside its own bytes.

use std::num::NonZeroU32;
use std::ops::Range;

use super::read;
use crate::formats::ReadError;
use crate::geometry::Point;

/// A shape as an OBJ file has it: places, faces, and the text around them.
///
/// ```
/// use handover_mesh::{Point, formats::obj::Obj};
/// let text = "# a roof\nv 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nusemtl tiles\nf 1 2 3 4\n";
/// let roof = Obj::read(text.as_bytes())?;
/// assert_eq!(roof.positions()[2], Point::new(1.0, 1.0, 0.5));
/// assert_eq!(roof.triangles(), [[0, 1, 2], [0, 2, 3]]);
/// let mut higher = roof.positions().to_vec();
/// higher[2].z = 0.75;
/// let written = String::from_utf8(roof.write(&higher)).unwrap();
/// assert_eq!(written, text.replace("0.5", "0.75"));
/// # Ok::<(), handover_mesh::formats::ReadError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Obj {
    /// The file.
    pub(super) bytes: Vec<u8>,
    pub(super) positions: Vec<Point>,
    /// Where in the file the three numbers of each vertex stand.
    pub(super) vertex_spans: Vec<Range<usize>>,
    /// And those of each normal.
    pub(super) normal_spans: Vec<Range<usize>>,
    /// Of one face after another.
    pub(super) corners: Vec<Corner>,
    /// Where each face ends among the corners.
    pub(super) ends: Vec<usize>,
}

/// A corner of a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Corner {
    /// From 0.
    pub(super) vertex: u32,
    /// From 1, as the file counts.
    pub(super) normal: Option<NonZeroU32>,
}

impl Obj {
    /// Reads an OBJ file.
    ///
    /// # Errors
    /// [`ReadError`] lists every violation: what is no finite number, statements with too few
    /// numbers, indices that are 0 or of nothing in the file, faces of fewer than three corners or
    /// that name a vertex twice, a file without vertices or faces.
    pub fn read(bytes: &[u8]) -> Result<Self, ReadError> {
        read::read(bytes)
    }

    /// Where each vertex is, in the file's own unit and axes; at least one.
    pub fn positions(&self) -> &[Point] {
        &self.positions
    }

    /// How many faces there are, of three corners or more; at least one.
    pub fn face_count(&self) -> usize {
        self.ends.len()
    }

    /// The vertices of all faces, counted from 0: a face of more than three corners as the fan of
    /// triangles around its first one.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        self.faces().flat_map(fan).collect()
    }

    /// The corners of each face.
    pub(super) fn faces(&self) -> impl Iterator<Item = &[Corner]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts.zip(&self.ends).map(|(start, end)| &self.corners[*start..*end])
    }
}

/// The triangles around a face's first corner.
pub(super) fn fan(face: &[Corner]) -> impl Iterator<Item = [u32; 3]> {
    let triangle = |pair: &[Corner]| [face[0].vertex, pair[0].vertex, pair[1].vertex];
    face[1..].windows(2).map(triangle)
}
