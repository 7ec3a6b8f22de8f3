//! Which edges between the people a movement needs, and how strong they are.
//!
//! The path of the data: demonstrations → [`Predictor`](crate::predict::Predictor) →
//! [`Lessons`] (references, each a retargeting whose right answer is known) → [`Search`] (one step
//! after another, resumable) → [`LearnedEdges`](crate::predict::LearnedEdges).
//!
//! The distance to bring down is `d = Σᵢ ωᵢ ‖vᵢ − v'ᵢ‖` `[m]` over all joints and frames of a
//! reference (Thai 2014, eq. 3.9), its mean over the references where there are several.

mod climb;
mod descent;
mod error;
mod lesson;
mod lessons;
mod record;
mod search;
mod settings;

pub use descent::DescentState;
pub use error::LearnError;
pub use lesson::Lesson;
pub use lessons::{Lessons, Room};
pub use record::RecordError;
pub use search::{Move, Search, Step, learn};
pub use settings::{LearnMethod, LearnSettings};
