//! Whether people stand upright: read with the wrong axis up, they lie on their sides.

use std::f64::consts::FRAC_PI_3;

use handover_mesh::statistics::median;
use handover_mesh::{Part, Recording, Vector};

use super::ReadFile;
use crate::args::{Selection, Up};

/// A trunk farther than this `[rad]` from upright lies: nobody leans as far for long.
const LYING: f64 = FRAC_PI_3;

/// Says so where people lie in most frames of some recording, naming the first one, and which axis
/// would have them stand.
pub(super) fn note(files: &[ReadFile], selection: &Selection) -> Option<String> {
    let recordings = files.iter().filter_map(|file| Some((file, file.outcome.as_ref().ok()?)));
    let mut lying = recordings.filter(|(_, loaded)| lies(&loaded.recording, Vector::z()));
    let (first, loaded) = lying.next()?;
    let others = match lying.count() {
        0 => String::new(),
        others => format!(" and {others} more"),
    };
    // Where the other axis of the file points, as it was read.
    let (axis, name) = match selection.up {
        Some(Up::Y) => (-Vector::y(), "z"),
        Some(Up::Z) | None => (Vector::y(), "y"),
    };
    let hint = if lies(&loaded.recording, axis) {
        "neither y nor z points up".to_owned()
    } else {
        format!("hint: --up {name}")
    };
    Some(format!("note: {}{others}: people lie on their sides ({hint})", first.path.display()))
}

/// Whether in most frames both people's trunks, from the base to the neck or head, are far from
/// `up`; not so where nobody has a trunk.
fn lies(recording: &Recording, up: Vector) -> bool {
    let tilts = recording.people().iter().flat_map(|person| {
        let (motion, skeleton) = (&person.motion, person.motion.skeleton());
        let top = skeleton.part(Part::Neck).or(skeleton.part(Part::Head));
        let top = top.filter(|top| *top != skeleton.root());
        let frames = top.into_iter().flat_map(|top| (0..motion.len()).map(move |at| (at, top)));
        frames.map(|(at, top)| {
            (motion.position(at, top) - motion.position(at, skeleton.root())).angle(&up)
        })
    });
    median(tilts.collect()).is_some_and(|tilt| tilt > LYING)
}
