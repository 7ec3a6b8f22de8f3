//! Where a sighting is → whether it can still be the same person.

use super::body::Body;
use super::{Doubt, FilterSettings, seconds_since};
use crate::geometry::Point;
use crate::time::Stamp;

/// Longer absences `[s]` allow no longer ways.
const LONGEST_ABSENCE: f64 = 0.3;
/// Fewer joints than this say nothing of where a person is.
pub(super) const ENOUGH: usize = 3;

/// How far a sighting is off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Whereabouts {
    /// Where the known person can be.
    Here,
    /// Where the known person cannot be.
    Elsewhere,
    /// Too few joints to tell.
    Unclear,
}

/// Someone seen where the known person cannot be.
#[derive(Debug, Clone, Copy)]
struct Newcomer {
    since: Stamp,
    last: Stamp,
    place: Point,
    body: Option<u32>,
}

/// Who else may be there.
#[derive(Debug, Clone, Default)]
pub(super) struct Identity {
    newcomer: Option<Newcomer>,
    /// How far off each joint is beyond what it can move: scratch.
    excess: Vec<f64>,
}

impl Identity {
    pub(super) fn new(joints: usize) -> Self {
        Self { newcomer: None, excess: Vec::with_capacity(joints) }
    }

    /// Nobody else is there.
    pub(super) fn forget(&mut self) {
        self.newcomer = None;
    }

    /// Whether somebody else was seen last.
    pub(super) fn is_doubted(&self) -> bool {
        self.newcomer.is_some()
    }

    /// Where a sighting is: by the median over the joints that are no leg's of how far each is
    /// off, less what it can have moved in `absence` `[s]`.
    pub(super) fn whereabouts(
        &mut self,
        body: &Body,
        expected: &[Option<Point>],
        seen: &[Option<Point>],
        absence: impl Fn(usize) -> f64,
        settings: &FilterSettings,
    ) -> Whereabouts {
        self.excess.clear();
        for (joint, (expected, seen)) in expected.iter().zip(seen).enumerate() {
            if let (Some(expected), Some(seen), false) = (expected, seen, body.joints[joint].is_leg)
            {
                let way = settings.body_speed * absence(joint).min(LONGEST_ABSENCE);
                self.excess.push((seen - expected).norm() - way);
            }
        }
        if self.excess.len() < ENOUGH {
            return Whereabouts::Unclear;
        }
        self.excess.sort_unstable_by(f64::total_cmp);
        if self.excess[self.excess.len() / 2] <= settings.body_slack {
            Whereabouts::Here
        } else {
            Whereabouts::Elsewhere
        }
    }

    /// Watches somebody elsewhere: `None` once they are there for long enough.
    pub(super) fn watch(
        &mut self,
        body: &Body,
        seen: &[Option<Point>],
        stamp: Stamp,
        ids: [Option<u32>; 2],
        settings: &FilterSettings,
    ) -> Option<Doubt> {
        let [known, id] = ids;
        let doubt = match (known, id) {
            (Some(known), Some(id)) if known != id => Doubt::Exchanged,
            _ => Doubt::Jump,
        };
        let Some(place) = place(body, seen) else { return Some(doubt) };
        let since = match self.newcomer {
            Some(before) if before.body == id => {
                let elapsed = seconds_since(stamp, before.last);
                let way = settings.body_slack + settings.body_speed * elapsed;
                let follows = elapsed <= LONGEST_ABSENCE && (place - before.place).norm() <= way;
                if follows { before.since } else { stamp }
            }
            _ => stamp,
        };
        self.newcomer = Some(Newcomer { since, last: stamp, place, body: id });
        (seconds_since(stamp, since) < settings.settle).then_some(doubt)
    }
}

/// Where somebody is: the base, or where it was not seen the middle of what else was.
fn place(body: &Body, seen: &[Option<Point>]) -> Option<Point> {
    let middle = || {
        let places = seen.iter().flatten();
        let count = places.clone().count();
        (count > 0).then(|| {
            let sum = places.fold(Point::origin(), |sum, place| sum + place.coords);
            sum / count as f64
        })
    };
    seen[body.base].or_else(middle)
}
