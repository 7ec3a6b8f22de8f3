//! How the tick is doing, for people and monitors.

use super::Report;
use crate::messages::{Diagnostic, DiagnosticArray, Header, KeyValue, Time};
use crate::online::{OnlineModel, Tick};
use crate::safety::HoldReason;

impl Report<'_> {
    /// One status: its level and message by the reason, the numbers as values.
    pub(super) fn diagnostics(
        &self,
        model: &OnlineModel,
        tick: Option<&Tick<'_>>,
        reason: Option<HoldReason>,
    ) -> DiagnosticArray {
        let (level, mut message) = match reason {
            None => (Diagnostic::OK, self.state.name().to_owned()),
            Some(HoldReason::NoPartner) => (Diagnostic::OK, "nobody is seen".to_owned()),
            Some(HoldReason::NoRobot) => {
                (Diagnostic::WARN, "the robot has not said where its joints are".to_owned())
            }
            Some(reason) => (Diagnostic::WARN, format!("holds: {reason}")),
        };
        if let Some(refused) = self.refused {
            message += &format!("; not taken: {refused}");
        }
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
        say("not_taken", self.refused.unwrap_or("").to_owned());
        let level = if self.refused.is_some() { level.max(Diagnostic::WARN) } else { level };
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
