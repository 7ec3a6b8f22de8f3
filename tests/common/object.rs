//! The short handovers with what is handed over; included by path, beside `clips`.

use std::fs;

use handover_mesh::formats::{self, UpAxis, csv};
use handover_mesh::{ObjectTrack, Recording, Vector};
use tempfile::TempDir;

use crate::clips::clips;

/// Clips with an object in the giver's right hand until the hands meet, then in the receiver's; the
/// first `without` have none.
pub(crate) fn clips_with_object(count: u32, without: u32) -> TempDir {
    let folder = clips(count);
    for number in without..count {
        let path = folder.path().join(format!("clips/{number}.csv"));
        let clip = formats::read(&fs::read(&path).unwrap(), "clip", UpAxis::Z).unwrap();
        let places = clip.stamps().enumerate().map(|(k, stamp)| {
            let holder = &clip.people()[usize::from(k > 12)].motion.frames()[k];
            (stamp, holder.positions[8] + Vector::new(0.0, 0.0, 0.1))
        });
        let object = ObjectTrack::of_point("cup", places.collect());
        let (people, words) = (clip.people().clone(), clip.metadata().clone());
        let clip = Recording::new("clip", people, Some(object), words).unwrap();
        fs::write(path, csv::write(&clip).unwrap()).unwrap();
    }
    folder
}
