//! What the robot is told: the only thing that is ever published.

use std::sync::Arc;

use super::HoldReason;
use super::chain::Chain;
use super::plan::Plan;
use crate::geometry::{Point, Vector};
use crate::time::{Span, Stamp};

/// Where the robot is to be now, and from now on if nothing more is said.
///
/// Made by [`super::SafetyGate::admit`] alone. All of it is certified: speed, acceleration and jerk
/// of each joint, the workspace, and, if it [`Self::keeps_separation`], the distance to the partner as given at
/// [`Self::planned`].
#[derive(Debug, Clone)]
pub struct Target {
    pub(super) chain: Arc<Chain>,
    pub(super) plan: Plan,
    /// How far into the plan now is, ≥ 0.
    pub(super) elapsed: Span,
    pub(super) keeps_separation: bool,
    pub(super) stamp: Stamp,
    pub(super) positions: Vec<Point>,
    pub(super) velocities: Vec<Vector>,
    pub(super) reason: Option<HoldReason>,
}

impl Target {
    /// At how many moments two stops are compared that both come too near: see
    /// [`Self::keeps_separation`].
    pub const MOMENTS: u32 = 13;

    /// When the robot is to be at [`Self::positions`].
    pub fn stamp(&self) -> Stamp {
        self.stamp
    }

    /// Where the joints are to be: `[m]` in the world, skeleton order.
    pub fn positions(&self) -> &[Point] {
        &self.positions
    }

    /// How the joints move there: `[m/s]` in the world, skeleton order.
    pub fn velocities(&self) -> &[Vector] {
        &self.velocities
    }

    /// Why the robot is not moving as proposed; none: it is.
    pub fn reason(&self) -> Option<HoldReason> {
        self.reason
    }

    /// Whether the plan is still on its way; without any further tick it ends after
    /// [`Self::stands_in`].
    pub fn is_moving(&self) -> bool {
        self.stands_in() > Span(0)
    }

    /// How long until the robot stands if nothing more is said; 0 if it stands.
    pub fn stands_in(&self) -> Span {
        let left = self.plan.duration() - self.elapsed.seconds();
        Span::from_seconds(left.max(0.0)).unwrap_or_default()
    }

    /// Since when the plan now followed is followed, by the clock as it is set now: it was certified
    /// then, with the partner as given then.
    pub fn planned(&self) -> Stamp {
        self.stamp + Span(-self.elapsed.0)
    }

    /// For how long the plan now followed has been followed, by the time that the gate took to have
    /// passed; 0 if it was made for [`Self::stamp`].
    pub fn followed_for(&self) -> Span {
        self.elapsed
    }

    /// Whether the plan now followed was certified to keep its distance to the partner: nowhere
    /// nearer than `separation`, or than they were when it was planned.
    ///
    /// Not so for a stop that was taken because the partner had come into the way of an older plan,
    /// and no stop keeps clear of them. Of such a stop only this is known: at none of
    /// [`Self::MOMENTS`] moments, spread evenly from its start to its standstill, is it nearer to the
    /// partner as given then than the older plan would have been at the nearest of as many moments,
    /// spread evenly over what was left of it. Between those moments nothing is compared.
    pub fn keeps_separation(&self) -> bool {
        self.keeps_separation
    }

    /// Where the joints are to be so long after [`Self::stamp`], if nothing more is said: they go
    /// on for a moment, brake, and stand. Before it: where they were, back to [`Self::planned`].
    ///
    /// - `joints`: `[m]` in the world, skeleton order, overwritten. Allocates nothing.
    ///
    /// # Panics
    /// If `joints` has not one place for each joint: the caller's bug.
    pub fn positions_at(&self, ahead: Span, joints: &mut [Point]) {
        assert_eq!(joints.len(), self.positions.len(), "one place for each joint");
        let time = self.after(ahead).seconds();
        self.plan.points(&self.chain, time.max(0.0), joints);
    }

    /// How the joints move there so long after now; the sizes and panics are those of
    /// [`Self::positions_at`].
    ///
    /// - `joints`: the velocities `[m/s]` in the world, skeleton order.
    pub fn velocities_at(&self, ahead: Span, joints: &mut [Vector]) {
        assert_eq!(joints.len(), self.velocities.len(), "one velocity for each joint");
        let time = self.after(ahead).seconds();
        self.plan.velocities(&self.chain, time.max(0.0), joints);
    }

    /// How far into the plan it is so long after now. Whole nanoseconds are added, so that what was
    /// published is what the gate will find there.
    pub(super) fn after(&self, ahead: Span) -> Span {
        Span(self.elapsed.0.saturating_add(ahead.0))
    }
}
