//! Recordings as bytes → [`Recording`]s, and back: CSV, SBU text and bags; one person's motion: ASF
//! and AMC; shapes: OBJ.
//!
//! A reader looks at the whole file and reports every violation it finds, each with its place, so
//! that a file is mended in one round; what it returns holds everything [`Recording`] promises.
//! Bytes that are no recording never panic and never cost more memory than a small multiple of
//! their own size.
//!
//! Opens no file and does not look at names: what a file is called tells nothing about its bytes.

pub mod amc;
pub mod bag;
pub mod csv;
mod detect;
mod error;
mod field;
mod input;
pub mod obj;
mod rate;
pub mod sbu;
mod up;

pub use detect::{Format, detect};
pub(crate) use error::shortened_to;
pub use error::{Place, ReadError, Reason, Violation};
pub(crate) use field::FARTHEST;
pub use input::{FileError, LARGEST, bytes};
pub use rate::rate;
pub use up::UpAxis;

use crate::skeleton::Recording;

/// Reads a recording of any known format, found from the bytes themselves.
///
/// - `name`: what reports call the clip.
/// - `up`: which axis of the file points up; the recording's is always z.
///
/// ```
/// use handover_mesh::formats::{self, UpAxis};
/// let text = "frame,time_s,person,joint,x,y,z\n\
///     0,0.0,giver,head,0,0,1.7\n0,0.0,giver,torso,0,0,1.2\n\
///     0,0.0,receiver,head,1,0,1.7\n0,0.0,receiver,torso,1,0,1.2\n";
/// let recording = formats::read(text.as_bytes(), "clip", UpAxis::Z)?;
/// assert_eq!((recording.len(), recording.people()[1].name.as_str()), (1, "receiver"));
/// # Ok::<(), formats::ReadError>(())
/// ```
///
/// # Errors
/// [`ReadError`] lists every violation; [`Reason::UpIsFixed`] if the format leaves no choice of
/// axis and `up` is not z; [`Reason::Lost`] of a damaged bag, of which [`bag::read`] gives the rest.
pub fn read(bytes: &[u8], name: &str, up: UpAxis) -> Result<Recording, ReadError> {
    match detect(bytes)? {
        Format::Csv => csv::read(bytes, name, up),
        Format::Sbu if up != UpAxis::Z => Err(ReadError::of(1, Reason::UpIsFixed)),
        Format::Sbu => sbu::read(bytes, name),
        Format::Mcap | Format::Sqlite => {
            let file = bag::File { name, bytes: Some(bytes) };
            let read = bag::read(&[file], None, name, up)?;
            match read.losses.into_iter().next() {
                Some(loss) => Err(ReadError::of(Place::File, Reason::Lost(loss))),
                None => Ok(read.recording),
            }
        }
    }
}
