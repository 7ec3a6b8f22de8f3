//! A shape (OBJ) around the one place at which an object was recorded: its outermost points.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::bail;
use handover_mesh::geometry::outermost;
use handover_mesh::{ObjectTrack, Person, Point, PointTrack, Recording, Skeleton, Vector};

use crate::files::{self, BadFile};
use crate::output::{Output, counted};

/// What goes from hand to hand is no larger `[m]`: a shape that is was taken in the wrong unit.
const LARGEST: f64 = 3.0;

/// The outermost points of a shape `[m]`.
pub(super) struct ObjectMesh(Vec<Point>);

impl ObjectMesh {
    /// Those of a file's faces, and a note of how large it is; `None` if the file is bad, which was
    /// said.
    ///
    /// - `scale`: the file's unit `[m]`, above 0.
    /// - `most`: how many points are taken at most, 1 or more.
    ///
    /// # Errors
    /// If it is too large to be handed over.
    pub(super) fn read(
        path: &Path,
        scale: f64,
        most: usize,
        output: &Output,
    ) -> anyhow::Result<Option<Self>> {
        let shape = match files::read_obj(path) {
            Ok(shape) => shape,
            Err(faults) => {
                files::name_bad(&[BadFile { path: path.to_owned(), faults }], output);
                return Ok(None);
            }
        };
        // A vertex that no face has is no part of the surface.
        let corners: BTreeSet<u32> = shape.triangles().into_iter().flatten().collect();
        let places = || corners.iter().map(|vertex| shape.positions()[*vertex as usize].coords);
        // Seen from a corner of the box around it, wherever in the file it lies.
        let corner = places().reduce(|a, b| a.inf(&b)).unwrap_or_default();
        let mut points: Vec<Point> =
            places().map(|place| Point::from((place - corner) * scale)).collect();
        let size = points.iter().fold(Vector::zeros(), |size, point| size.sup(&point.coords));
        let shown =
            format!("{} is {:.3} x {:.3} x {:.3} m", path.display(), size.x, size.y, size.z);
        if size.max() > LARGEST {
            bail!(
                "{shown}, more than the {LARGEST} m of what anybody hands over (hint: \
                 --object-scale 0.001 if it is in millimetres)"
            );
        }
        points = outermost(&points, most).into_iter().map(|at| points[at]).collect();
        let taken = counted(points.len(), "point");
        output.note(&format!("note: {shown}; {taken} of it around each object's place"));
        Ok(Some(Self(points)))
    }

    /// The recording with the points in place of its object's only one, which is their mean; no
    /// more of them than a person can have beside their own joints.
    ///
    /// # Errors
    /// Why there is nothing that they can be around.
    pub(super) fn around_object(&self, recording: &Recording) -> Result<Recording, String> {
        let object = recording.object().ok_or("no object was tracked")?;
        let [middle] = &object.points[..] else {
            let points = object.points.len();
            return Err(format!("the object has {points} points already, a mesh goes around one"));
        };
        let own = |person: &Person| person.motion.skeleton().own();
        let joints = recording.people().iter().map(own).max().unwrap_or_default();
        let chosen = outermost(&self.0, Skeleton::MAX_JOINTS - joints);
        let places = || chosen.iter().map(|at| self.0[*at].coords);
        let mean = places().sum::<Vector>() / chosen.len().max(1) as f64;
        let points = places().enumerate().map(|(number, place)| PointTrack {
            name: format!("p{number:02}"),
            places: middle.places.iter().map(|(at, seen)| (*at, seen + (place - mean))).collect(),
        });
        let object = ObjectTrack { points: points.collect() };
        let (people, metadata) = (recording.people().clone(), recording.metadata().clone());
        Recording::new(recording.name(), people, Some(object), metadata)
            .map_err(|error| error.to_string())
    }
}
