//! Places expected and places seen → whether left and right have changed their names.
//!
//! Arms and legs each: exchanged where the other side's labels are clearly nearer to what is
//! expected than the given ones. A body that turns, or hands that cross, move through what is
//! expected, so the given labels stay nearer.

use super::body::Body;
use super::{FilterSettings, seconds_since};
use crate::geometry::Point;
use crate::time::Stamp;

/// Exchanged labels have to be off by less than this share of what the given ones are.
const SHARE: f64 = 0.5;
/// Given labels that are off by less than this `[m]` a joint are not questioned.
const LEAST: f64 = 0.1;

/// Since when each of arms and legs are exchanged, if they are.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Swap {
    since: [Option<Stamp>; 2],
}

/// What to do about arms, or legs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Labels {
    /// They are as given.
    Given,
    /// They are exchanged for a while.
    Exchanged,
    /// They were exchanged for so long that the given ones are to be believed.
    Believed,
}

impl Swap {
    /// Whether arms, and legs, of this sighting are exchanged.
    pub(super) fn find(
        body: &Body,
        expected: &[Option<Point>],
        seen: &[Option<Point>],
    ) -> [bool; 2] {
        body.pairs.each_ref().map(|pairs| {
            let (mut given, mut exchanged, mut count) = (0.0, 0.0, 0);
            for &[left, right] in pairs {
                let (Some(l), Some(r), Some(expected_l), Some(expected_r)) =
                    (seen[left], seen[right], expected[left], expected[right])
                else {
                    continue;
                };
                given += (l - expected_l).norm() + (r - expected_r).norm();
                exchanged += (r - expected_l).norm() + (l - expected_r).norm();
                count += 2;
            }
            // Two hands alone that pass each other quickly tell nothing.
            count >= 4 && given > LEAST * f64::from(count) && exchanged < SHARE * given
        })
    }

    /// Exchanges the labels of arms, or legs.
    pub(super) fn exchange(body: &Body, group: usize, seen: &mut [Option<Point>]) {
        for &[left, right] in &body.pairs[group] {
            seen.swap(left, right);
        }
    }

    /// Counts how long labels have been exchanged; `started`: when the person was first seen.
    ///
    /// No longer than before that were they as now: whoever began with wrong labels is not kept
    /// to them.
    pub(super) fn judge(
        &mut self,
        found: [bool; 2],
        stamp: Stamp,
        started: Stamp,
        settings: &FilterSettings,
    ) -> [Labels; 2] {
        let mut group = 0;
        self.since.each_mut().map(|since| {
            group += 1;
            if !found[group - 1] {
                *since = None;
                return Labels::Given;
            }
            let first = *since.get_or_insert(stamp);
            let longest = settings.swap.min(seconds_since(first, started));
            if seconds_since(stamp, first) > longest {
                *since = None;
                return Labels::Believed;
            }
            Labels::Exchanged
        })
    }
}
