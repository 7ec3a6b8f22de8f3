//! What has to hold of a trial's figures.

use std::collections::BTreeMap;

use handover_mesh::safety::HoldReason;
use serde_json::{Value, json};

use super::fields::Fields;
use super::{Change, Figure};

/// A figure's bound, itself included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// Not more.
    Most(f64),
    /// Not less.
    Least(f64),
}

/// What has to hold: at least one thing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bounds {
    /// Figures and their bounds, in the figures' order.
    pub limits: Vec<(Figure, Limit)>,
    /// Reasons to hold that each have to occur.
    pub expected: Vec<HoldReason>,
    /// Reasons to hold that may occur besides; `None`: any.
    pub allowed: Option<Vec<HoldReason>>,
}

/// A bound and whether it held.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// The bound's key in the scenario.
    pub key: String,
    /// The bound.
    pub bound: Value,
    /// What it bounds; null if that is undefined.
    pub value: Value,
    /// Whether it held: what is undefined holds nothing.
    pub is_held: bool,
}

impl Limit {
    /// The end of its key.
    fn ending(self) -> &'static str {
        match self {
            Self::Most(_) => "most",
            Self::Least(_) => "least",
        }
    }

    fn bound(self) -> f64 {
        match self {
            Self::Most(bound) | Self::Least(bound) => bound,
        }
    }

    fn admits(self, value: f64) -> bool {
        match self {
            Self::Most(bound) => value <= bound,
            Self::Least(bound) => value >= bound,
        }
    }
}

impl Bounds {
    /// Every key below `bounds`.
    pub(super) fn from_fields(fields: &mut Fields, partner: Change) -> Self {
        let mut limits = Vec::new();
        for figure in Figure::ALL {
            for limit in [Limit::Most, Limit::Least] {
                let key = format!("bounds.{}_{}", figure.key(), limit(0.0).ending());
                let Some(bound) = fields.limit(&key, -1e6, 1e6) else { continue };
                if figure.needs_contact() && matches!(partner, Change::Withdrawal { .. }) {
                    fields.blame(key, "cannot hold: who withdraws makes no contact");
                }
                limits.push((figure, limit(bound)));
            }
        }
        let reasons = HoldReason::ALL.map(|reason| (reason.name(), reason));
        let expected = fields.choices("bounds.holds_expected", &reasons).unwrap_or_default();
        let allowed = fields.choices("bounds.holds_allowed", &reasons);
        let is_empty = limits.is_empty() && expected.is_empty() && allowed.is_none();
        // Bounds that are there but wrong are not missing.
        if is_empty && !fields.is_faulty("bounds") {
            fields.blame("bounds", "are missing: a trial that cannot fail shows nothing");
        }
        Self { limits, expected, allowed }
    }

    /// Every bound beside what was found.
    ///
    /// - `figure`: a figure's value; `None`: undefined.
    /// - `holds`: in how many ticks there was each reason to hold.
    pub fn judge(
        &self,
        figure: impl Fn(Figure) -> Option<f64>,
        holds: &BTreeMap<HoldReason, usize>,
    ) -> Vec<Verdict> {
        let limits = self.limits.iter().map(|(bounded, limit)| {
            let value = figure(*bounded);
            Verdict {
                key: format!("{}_{}", bounded.key(), limit.ending()),
                bound: json!(limit.bound()),
                value: json!(value),
                is_held: value.is_some_and(|value| limit.admits(value)),
            }
        });
        let names = |reasons: &[HoldReason]| -> Vec<&str> {
            reasons.iter().map(|reason| reason.name()).collect()
        };
        let found: Vec<HoldReason> = holds.keys().copied().collect();
        let verdict = |key: &str, bound: &[HoldReason], is_held| Verdict {
            key: key.to_owned(),
            bound: json!(names(bound)),
            value: json!(names(&found)),
            is_held,
        };
        let expected = (!self.expected.is_empty()).then(|| {
            let all = self.expected.iter().all(|reason| found.contains(reason));
            verdict("holds_expected", &self.expected, all)
        });
        let allowed = self.allowed.as_ref().map(|allowed| {
            let known = |reason| allowed.contains(reason) || self.expected.contains(reason);
            verdict("holds_allowed", allowed, found.iter().all(known))
        });
        limits.chain(expected).chain(allowed).collect()
    }
}
