//! How the tick is doing, for people and monitors.

use super::Report;
use crate::messages::{Diagnostic, DiagnosticArray, Header, KeyValue, Time};
use crate::online::{OnlineModel, Tick};
use crate::safety::HoldReason;

impl Report {
    /// How it is going, and how bad that is: what is not taken is told too.
    pub(super) fn words(&self, reason: Option<HoldReason>) -> (u8, String) {
        let level = match reason {
            None | Some(HoldReason::NoPartner) => Diagnostic::OK,
            Some(_) => Diagnostic::WARN,
        };
        let words = reason.map_or_else(|| self.state.name(), words);
        if self.refused.is_empty() {
            return (level, words.to_owned());
        }
        (level.max(Diagnostic::WARN), format!("{words}; not taken: {}", self.refused))
    }

    /// One status: its level and message by the reason, the numbers as values.
    pub(super) fn diagnostics(
        &self,
        model: &OnlineModel,
        tick: Option<&Tick<'_>>,
        reason: Option<HoldReason>,
    ) -> DiagnosticArray {
        let (level, message) = self.words(reason);
        let mut values = Vec::new();
        let mut say = |key: &str, value: String| {
            values.push(KeyValue { key: key.to_owned(), value });
        };
        say("state", self.state.name().to_owned());
        say("hold_reason", reason.map_or("none", HoldReason::name).to_owned());
        if let Some(took) = self.took {
            say("tick_us", format!("{took:.1}"));
        }
        if let Some(body) = self.body {
            say("partner", body.map_or("unnumbered".to_owned(), |number| number.to_string()));
        }
        if let Some(age) = self.robot_age {
            say("robot_age_s", format!("{age:.4}"));
        }
        if let Some(tick) = tick {
            self.say_tick(model, tick, &mut say);
        }
        say("not_taken", self.refused.clone());
        let name = "tick".to_owned();
        let status = Diagnostic { level, name, message, hardware_id: String::new(), values };
        let header = Header { stamp: Time::of(self.now), frame_id: String::new() };
        DiagnosticArray { header, status: vec![status] }
    }

    fn say_tick(&self, model: &OnlineModel, tick: &Tick<'_>, say: &mut impl FnMut(&str, String)) {
        let step = model.library().step().seconds();
        if let Some(followed) = tick.belief.followed.first() {
            say("demonstration", followed.exemplar.to_string());
            say("demonstration_time_s", format!("{:.3}", followed.frame * step));
            say("contact_in_s", format!("{:.3}", tick.belief.contact * step));
            say("tempo", format!("{:.3}", tick.belief.tempo));
            say("distance_m", format!("{:.4}", tick.belief.distance));
        }
        if let Ok(partner) = tick.filter.partner() {
            say("partner_age_s", format!("{:.4}", (self.now - partner.stamp()).seconds()));
        }
        if let Some(doubt) = tick.filter.ignored() {
            say("ignored", doubt.name().to_owned());
        }
        if let Some(hands) = &self.hands {
            say("gap_error_m", format!("{:.4}", hands.gap_error));
        }
        if let Some(solved) = &tick.solved {
            say("solve_steps", solved.residual.steps.to_string());
            say("bone_residual_m", format!("{:.6}", solved.residual.bones));
        }
    }
}

/// Why the robot does not move as demonstrated.
fn words(reason: HoldReason) -> &'static str {
    match reason {
        HoldReason::NoRobot => "the robot has not said where its joints are (robot_skeleton)",
        HoldReason::NoPartner => "nobody is seen",
        HoldReason::Stale => "holds: the partner has not been seen for a while",
        HoldReason::Stopped => "holds: the partner has not been seen for long",
        HoldReason::Lost => "holds: too little of the partner is seen",
        HoldReason::Jump => "holds: the partner moved farther than a person can",
        HoldReason::Exchanged => "holds: somebody else is seen in the partner's place",
        HoldReason::OffDemonstration => "holds: what the partner does was not demonstrated",
        HoldReason::Unsolved => "holds: there is no pose to follow",
        HoldReason::Cancelled => "holds: called off, until ~/reset",
        HoldReason::Separation => "holds: the partner is, or would be, too near",
        HoldReason::Workspace => "holds: a joint is, or would be, outside the workspace",
        HoldReason::Limits => "holds: no way there is within speed, acceleration and jerk",
        HoldReason::Clock => "holds: time did not go on, or was set",
    }
}
