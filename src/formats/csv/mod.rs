//! CSV of two people and perhaps an object ↔ [`Recording`](crate::Recording).
//!
//! One row a joint, `frame,time_s,person,joint,x,y,z`: seconds and metres. The rows of a frame
//! stand together and bear the same time; frame numbers and times rise. Two people, the first one
//! named is [`Role::First`](crate::Role::First); rows of the person `object` are the object's
//! place (`joint` is its name, or that of a point of it), which may be missing in some frames. Lines `# key=value` before
//! the header are the clip's metadata.
//!
//! Joints come out in canonical order whatever the order of rows, and every number is written so
//! that it reads back as the same bits. Frame numbers are only an order: they are written from 0.

mod assemble;
mod metadata;
mod read;
mod rows;
mod write;

pub use metadata::metadata;
pub use read::read;
pub use write::{WriteError, write, write_rounded};

/// The header, and the fields of a row.
pub const HEADER: &str = "frame,time_s,person,joint,x,y,z";
/// The `person` of the object's rows.
pub(super) const OBJECT: &str = "object";
/// The columns by name.
const COLUMNS: [&str; 7] = ["frame", "time_s", "person", "joint", "x", "y", "z"];
