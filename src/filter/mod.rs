//! One person's skeleton messages as they come in → where that person is now, or why nobody knows.
//!
//! The path of a message: [`Sighting`] → its stamp (`clock`) → left and right (`swap`) → is it
//! still this person (`identity`) → each joint by its bones (`bones`) and its speed, smoothed
//! (`smoother`) or carried with its parent (`tracks`) → the kept past (`history`) → [`Partner`].
//!
//! Causal: nothing later than the message is used, and no place waits for the next one. Every
//! decision is made of distances, times and labels, so it is the same wherever the person stands
//! and whichever way they face. After [`Filter::new`] nothing is allocated, and no data panics.
//!
//! Chooses no one among several people, predicts no further than a moment, knows no robot.

mod body;
mod bones;
mod clock;
mod history;
mod identity;
mod partner;
mod settings;
mod smoother;
mod swap;
mod tracks;
mod update;

pub use partner::Partner;
pub use settings::FilterSettings;
pub use update::Filter;

use crate::geometry::{Point, is_finite};
use crate::time::{Span, Stamp};

/// One skeleton message.
#[derive(Debug, Clone, Copy)]
pub struct Sighting<'a> {
    /// When the sensor saw it, on the clock of [`Filter::update`]'s `now`.
    pub stamp: Stamp,
    /// The sensor's number of the person, where it gives one.
    pub body: Option<u32>,
    /// Where the joints are: `[m]` in the world, in skeleton order; NaN: untracked.
    pub positions: &'a [Point],
    /// How sure the sensor is of each joint: 0 to 1, or no values at all.
    pub confidences: &'a [f64],
}

/// Why the partner is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Doubt {
    /// Never seen, or not since the last reset.
    Nobody,
    /// No sighting was taken for this long, counted from the receipt of the last one.
    Stale(Span),
    /// Too few joints for too long, or some joint that is no leg's was never seen yet.
    Lost,
    /// All of the person is farther away than a person can move.
    Jump,
    /// Another body number, at a place where the known person cannot be.
    Exchanged,
    /// The stamp repeats or runs back.
    OutOfOrder,
    /// The stamp is this much after `now` (before, if negative): more than clocks may differ.
    FarFromNow(Span),
}

impl Doubt {
    /// The name in traces.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nobody => "nobody",
            Self::Stale(_) => "stale",
            Self::Lost => "lost",
            Self::Jump => "jump",
            Self::Exchanged => "exchanged",
            Self::OutOfOrder => "out_of_order",
            Self::FarFromNow(_) => "far_from_now",
        }
    }
}

/// Coordinates beyond this `[m]` are no place of a person, in whatever world.
const FARTHEST: f64 = 1e6;

/// Whether a place can be computed with.
fn is_usable(place: &Point) -> bool {
    is_finite(place) && place.coords.amax() <= FARTHEST
}

/// How long after `before` a stamp is `[s]`, at least 0.
fn seconds_since(stamp: Stamp, before: Stamp) -> f64 {
    (stamp - before).seconds().max(0.0)
}

/// For how many seconds of full velocity `elapsed` `[s]` of one that dies away with `damping`
/// `[s]` counts: `τ (1 − e^(−t/τ))`.
fn damped(elapsed: f64, damping: f64) -> f64 {
    -damping * (-elapsed / damping).exp_m1()
}
