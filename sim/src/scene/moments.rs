//! Durations → the instants between which each hand reaches, dwells and retreats.

use handover_mesh::Role;

use super::config::SceneConfig;
use crate::profile::step;

/// The instants of one handover, `[s]` from its start.
///
/// The giver leads; contact is when the later hand arrives, and the earlier one waits for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Moments {
    /// Start and end of the walk; equal where nobody walks.
    pub walk: [f64; 2],
    /// Start and end of each person's reach: giver, receiver.
    pub reach: [[f64; 2]; 2],
    /// Both hands have arrived.
    pub contact: f64,
    /// The object changes owner.
    pub transfer: f64,
    /// Start and end of each person's retreat: giver, receiver.
    pub retreat: [[f64; 2]; 2],
    /// The clip ends.
    pub end: f64,
}

impl Moments {
    /// The instants that follow from checked durations.
    pub(super) fn of(config: &SceneConfig) -> Self {
        let timing = &config.timing;
        let scale = 1.0 / timing.tempo;
        let walk_end =
            timing.lead_in + config.approach.as_ref().map_or(0.0, |approach| approach.duration);
        let take = walk_end + timing.reaction;
        let reach =
            [[walk_end, walk_end + timing.giver_reach], [take, take + timing.receiver_reach]];
        let contact = reach[0][1].max(reach[1][1]);
        let transfer = contact + timing.hold / 2.0;
        let receiver_leaves = contact + timing.hold;
        // A giver who let go before the transfer would drop it.
        let giver_leaves = (receiver_leaves + timing.release).max(transfer);
        let retreat = [giver_leaves, receiver_leaves].map(|start| [start, start + timing.retreat]);
        let end = retreat[0][1].max(retreat[1][1]) + timing.lead_out;
        let scaled = |span: [f64; 2]| span.map(|t| t * scale);
        Self {
            walk: scaled([timing.lead_in, walk_end]),
            reach: reach.map(scaled),
            contact: contact * scale,
            transfer: transfer * scale,
            retreat: retreat.map(scaled),
            end: end * scale,
        }
    }

    /// How far a person's hand is from rest (0) to the meeting point (1): a minimum-jerk step
    /// each way.
    pub fn progress(&self, role: Role, seconds: f64) -> f64 {
        let [[start, arrival], [leave, end]] =
            [self.reach[role as usize], self.retreat[role as usize]];
        step(seconds, start, arrival) - step(seconds, leave, end)
    }
}
