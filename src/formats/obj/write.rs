//! A shape with other places → the bytes of its file.

use std::ops::Range;

use super::shape::{Obj, fan};
use crate::geometry::{Point, Vector};

impl Obj {
    /// The file with these places, and with the normals that belong to them.
    ///
    /// A normal that faces use is made anew: the mean of the normals of these faces, weighed by
    /// their areas, once for each corner that uses it. One whose corners lie on no area stays as
    /// it is. All else keeps its bytes.
    ///
    /// - `positions`: one finite place for each vertex, in the file's own unit and axes.
    ///
    /// # Panics
    /// If there are not as many positions as vertices.
    pub fn write(&self, positions: &[Point]) -> Vec<u8> {
        assert_eq!(positions.len(), self.positions.len(), "a place for each vertex");
        let normals = self.normals(positions);
        let places = positions.iter().map(|point| Some(point.coords));
        let mut places = self.vertex_spans.iter().zip(places).peekable();
        let mut normals = self.normal_spans.iter().zip(normals).peekable();
        let mut written = Vec::with_capacity(self.bytes.len() * 3 / 2);
        let mut at = 0;
        // Both go through the file from its start.
        while let Some((span, numbers)) = earlier(&mut places, &mut normals) {
            if let Some(numbers) = numbers {
                written.extend_from_slice(&self.bytes[at..span.start]);
                // What Display gives is the shortest text that reads back as the same bits.
                written.extend(format!("{} {} {}", numbers.x, numbers.y, numbers.z).bytes());
                at = span.end;
            }
        }
        written.extend_from_slice(&self.bytes[at..]);
        written
    }

    /// Of each normal of the file the direction it has now; `None` where it stays as it is.
    fn normals(&self, positions: &[Point]) -> Vec<Option<Vector>> {
        let mut sums = vec![Vector::zeros(); self.normal_spans.len()];
        // Products of places that are large or small beyond reason stay in range.
        let size =
            positions.iter().map(|point| point.coords.amax()).fold(f64::MIN_POSITIVE, f64::max);
        let place = |vertex: u32| positions[vertex as usize].coords / size;
        for face in self.faces() {
            let area: Vector = fan(face)
                .map(|corners| corners.map(place))
                .map(|[a, b, c]| (b - a).cross(&(c - a)))
                .sum();
            for normal in face.iter().filter_map(|corner| corner.normal) {
                sums[normal.get() as usize - 1] += area;
            }
        }
        sums.into_iter().map(|sum| sum.try_normalize(f64::MIN_POSITIVE)).collect()
    }
}

/// Numbers and where they go; no numbers where the old ones stay.
type Place<'a> = (&'a Range<usize>, Option<Vector>);

/// The next of both in the order of the file.
fn earlier<'a>(
    places: &mut std::iter::Peekable<impl Iterator<Item = Place<'a>>>,
    normals: &mut std::iter::Peekable<impl Iterator<Item = Place<'a>>>,
) -> Option<Place<'a>> {
    let normal = normals.peek().map(|(span, _)| span.start);
    let place = places.next_if(|(span, _)| normal.is_none_or(|normal| span.start < normal));
    place.or_else(|| normals.next())
}
