//! Wavefront OBJ of one shape ⇄ vertices, faces and all else that the file says.
//!
//! `v x y z` are places, `vn` normals, `vt` texture coordinates; `f` names the corners of a face as
//! `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 1, or backwards from -1 for the last one before
//! the face. A backslash at the end of a line goes on with the next one, a comment's does not.
//! Whatever else a line says (groups, materials, lines, curves) is kept and not looked at.
//!
//! What is written is the file with other places: the same bytes but for the numbers of `v`, and of
//! those `vn` that a face uses. Numbers are written so that they read back as the same bits.
//!
//! Opens no material library, and does not ask whether the faces make a surface.

mod difference;
mod read;
mod shape;
mod statements;
mod write;

pub use difference::Difference;
pub use shape::Obj;
