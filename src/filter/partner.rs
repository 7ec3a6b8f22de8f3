//! A person who is known now, as the filter shows them.

use super::update::Filter;
use crate::geometry::{Point, Vector};
use crate::skeleton::JointId;
use crate::time::Stamp;

/// A person who is known now; borrowed from the filter.
#[derive(Debug, Clone, Copy)]
pub struct Partner<'a> {
    pub(super) filter: &'a Filter,
}

impl<'a> Partner<'a> {
    /// When the newest sighting that was taken is of.
    pub fn stamp(&self) -> Stamp {
        self.filter.tracks.stamp()
    }

    /// Where the joints were then, filtered: `[m]` in the world, in skeleton order. A joint that
    /// was not seen has gone with its parent.
    pub fn positions(&self) -> &'a [Point] {
        &self.filter.tracks.places
    }

    /// How fast the joints were then: `[m/s]` in the world.
    pub fn velocities(&self) -> &'a [Vector] {
        &self.filter.tracks.velocities
    }

    /// Whether the newest sighting showed the joint itself, believably.
    ///
    /// # Panics
    /// If the skeleton has no such joint: the caller's bug.
    pub fn is_tracked(&self, joint: JointId) -> bool {
        self.unseen(joint) == Some(0.0)
    }

    /// Whether the joint was not seen for so long (or never, a leg's) that its place is a guess.
    ///
    /// # Panics
    /// If the skeleton has no such joint: the caller's bug.
    pub fn is_lost(&self, joint: JointId) -> bool {
        self.unseen(joint).is_none_or(|absence| absence > self.filter.settings.bridge)
    }

    /// Whether a sighting was taken in the last update.
    pub fn is_fresh(&self) -> bool {
        self.filter.is_fresh
    }

    /// Whether this is the first time that this person is shown: after the start, a reset, someone
    /// else's coming, or a change of sides. Whatever followed the person before starts anew too.
    pub fn is_new(&self) -> bool {
        self.filter.is_new
    }

    /// Whether left and right of arms or legs were exchanged in the newest sighting, and mended.
    pub fn swapped(&self) -> bool {
        self.filter.is_swapped
    }

    /// Where the joints were, or will be, at an instant: interpolated in the kept past (0.6 s at
    /// least), before it as at its beginning, after the newest sighting carried by velocities
    /// that die away, for at most [`carry`](super::FilterSettings::carry).
    ///
    /// - `out`: `[m]` in the world, one per joint, overwritten.
    ///
    /// # Panics
    /// If `out` has another number of joints: the caller's bug.
    pub fn at(&self, stamp: Stamp, out: &mut [Point]) {
        let Filter { body, tracks, history, settings, .. } = self.filter;
        assert_eq!(out.len(), body.len(), "joints of the skeleton and to fill");
        if stamp <= tracks.stamp() {
            history.at(stamp, out);
            return;
        }
        for (joint, place) in out.iter_mut().enumerate() {
            *place = tracks.carried(body, joint, stamp, settings.carry, settings);
        }
    }

    /// For how long a joint has not been seen itself `[s]`: 0 if the newest sighting showed it;
    /// none: never.
    ///
    /// # Panics
    /// If the skeleton has no such joint: the caller's bug.
    pub fn unseen(&self, joint: JointId) -> Option<f64> {
        self.filter.tracks.absence(joint.index(), self.stamp())
    }
}
