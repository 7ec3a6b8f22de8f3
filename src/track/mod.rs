//! Where in the demonstrations an interaction is: the partner as seen so far → a distribution over
//! (demonstration, frame), and how far the demonstrations are to be believed at all.
//!
//! The path of the data: demonstrations → [`Library`] (each on one grid of time, its moments in a
//! latent space); the partner's moment → [`Tracker::observe`] → [`Belief`]. Within a demonstration
//! time is a hidden Markov chain that goes forward, pauses or hurries (`P(f|d) ∝ Σ P(g|d) a(f−g)
//! e(f, f−g)`, Rabiner 1989, eq. 20; what is seen depends on how the frame was come to: a pause has
//! its places and no velocities, so that a partner who stops half-way is half-way, not at an end);
//! demonstrations weigh by how near the partner has kept to them of late.
//!
//! Uses the past alone. Knows nothing of meshes, targets or limits.

mod belief;
mod library;
mod settings;
mod tracker;

pub use belief::{Belief, Followed};
pub use library::{Between, Exemplar, Library, LibraryError, Who};
pub use settings::TrackSettings;
pub use tracker::Tracker;
