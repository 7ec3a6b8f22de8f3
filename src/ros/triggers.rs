//! `~/reset` and `~/cancel`.

use anyhow::Result;
use r2r::Node;
use r2r::std_srvs::srv::Trigger;

use super::services::{Answers, Requests};

/// What somebody asks for in the middle of a handover.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Asked {
    /// A new interaction.
    Reset,
    /// Brake, and stand until reset.
    Cancel,
}

/// The two services.
pub(super) struct Triggers {
    reset: Requests<Trigger::Service>,
    cancel: Requests<Trigger::Service>,
}

impl Triggers {
    /// # Errors
    /// If a service cannot be offered.
    pub(super) fn new(node: &mut Node, answers: &Answers) -> Result<Self> {
        Ok(Self {
            reset: Requests::new(node, "~/reset", answers)?,
            cancel: Requests::new(node, "~/cancel", answers)?,
        })
    }

    /// Answers all that has come in.
    ///
    /// - `take`: does it, or says why not.
    pub(super) fn serve(&mut self, mut take: impl FnMut(Asked) -> Result<&'static str, String>) {
        for (asked, requests) in
            [(Asked::Reset, &mut self.reset), (Asked::Cancel, &mut self.cancel)]
        {
            while let Some(request) = requests.next() {
                let done = take(asked);
                let success = done.is_ok();
                let message = done.map_or_else(|reason| reason, str::to_owned);
                requests.answer(request, Trigger::Response { success, message });
            }
        }
    }
}
