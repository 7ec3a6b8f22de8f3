//! Stamps and `now` → which sightings are of the present, and how old the last one is.

use super::{Doubt, FilterSettings, seconds_since};
use crate::time::{Span, Stamp};

/// What to do with a sighting, by its stamp alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Admission {
    /// Later than all before.
    Take,
    /// The stream's clock was set back, long enough ago: begin again.
    Restart,
    /// Leave it.
    Ignore(Doubt),
}

/// What is known of the stream's time.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Clock {
    newest: Option<Stamp>,
    /// Of a run of stamps older than the newest: the first and the last.
    behind: Option<[Stamp; 2]>,
}

impl Clock {
    /// Judges a stamp; one that is taken is the newest from now on.
    pub(super) fn admit(
        &mut self,
        stamp: Stamp,
        now: Stamp,
        settings: &FilterSettings,
    ) -> Admission {
        let ahead = stamp - now;
        if ahead.seconds().abs() > settings.clock_tolerance {
            return Admission::Ignore(Doubt::FarFromNow(ahead));
        }
        match self.newest {
            Some(newest) if stamp == newest => return Admission::Ignore(Doubt::OutOfOrder),
            Some(newest) if stamp < newest => {
                let run = match self.behind {
                    Some([first, last]) if last < stamp => [first, stamp],
                    // The same message again says nothing new.
                    Some(run) if run[1] == stamp => run,
                    _ => [stamp, stamp],
                };
                self.behind = Some(run);
                if seconds_since(stamp, run[0]) < settings.settle {
                    return Admission::Ignore(Doubt::OutOfOrder);
                }
                *self = Self { newest: Some(stamp), behind: None };
                return Admission::Restart;
            }
            _ => {}
        }
        *self = Self { newest: Some(stamp), behind: None };
        Admission::Take
    }
}

/// When something happened by `now`, which may itself run back.
#[derive(Debug, Clone, Copy)]
pub(super) struct Receipt(Stamp);

impl Receipt {
    pub(super) fn new(now: Stamp) -> Self {
        Self(now)
    }

    /// How long ago: where `now` ran back, counted anew from there.
    pub(super) fn age(&mut self, now: Stamp) -> Span {
        self.0 = self.0.min(now);
        now - self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stamps and receipts in milliseconds, and what becomes of them.
    #[track_caller]
    fn check(steps: &[(i64, i64, Admission)]) {
        let (mut clock, settings) = (Clock::default(), FilterSettings::default());
        for (at, &(stamp, now, expected)) in steps.iter().enumerate() {
            let [stamp, now] = [stamp, now].map(|ms| Stamp(ms * 1_000_000));
            assert_eq!(clock.admit(stamp, now, &settings), expected, "step {at}");
        }
    }

    #[test]
    fn stamps_that_do_not_rise_are_left_out() {
        use Admission::{Ignore, Take};
        let late = Ignore(Doubt::OutOfOrder);
        check(&[(0, 0, Take), (0, 10, late), (40, 40, Take), (20, 45, late), (50, 50, Take)]);
        let far = |ms: i64| Ignore(Doubt::FarFromNow(Span(ms * 1_000_000)));
        check(&[(0, 0, Take), (900, 20, far(880)), (-900, 20, far(-920)), (40, 40, Take)]);
    }

    #[test]
    fn a_clock_set_back_is_followed_after_a_while() {
        let late = Admission::Ignore(Doubt::OutOfOrder);
        let mut steps = vec![(90_000, 90_000, Admission::Take)];
        steps.extend((0..10).map(|k| (k * 50, k * 50, late)));
        steps.extend([(500, 500, Admission::Restart), (550, 550, Admission::Take)]);
        check(&steps);
    }

    #[test]
    fn now_may_run_back() {
        let mut receipt = Receipt::new(Stamp(1_000));
        assert_eq!(receipt.age(Stamp(1_500)), Span(500));
        assert_eq!(receipt.age(Stamp(200)), Span(0));
        assert_eq!(receipt.age(Stamp(300)), Span(100));
    }
}
