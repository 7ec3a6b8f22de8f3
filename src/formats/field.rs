//! The text of one field → a number, or why it is none.

use super::error::{Reason, shortened};
use crate::time::Stamp;

/// Farther than any room, in metres; as millimetres it is one step away.
pub(crate) const FARTHEST: f64 = 1e3;
const NANOSECONDS_PER_SECOND: i128 = 1_000_000_000;

/// A frame's number. `name` is only asked for if there is something wrong.
pub(super) fn frame_number(text: &str, name: impl FnOnce() -> String) -> Result<u64, Reason> {
    let text = text.trim();
    text.parse().map_err(|_| Reason::NotAFrameNumber { field: name(), value: shortened(text) })
}

/// A finite number.
pub(super) fn number(text: &str, name: impl FnOnce() -> String) -> Result<f64, Reason> {
    let text = text.trim();
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(Reason::NotFinite { field: name(), value: shortened(text) }),
        Err(_) => Err(Reason::NotANumber { field: name(), value: shortened(text) }),
    }
}

/// `metres`, if a room can be that large.
pub(super) fn within_reach(metres: f64, name: impl FnOnce() -> String) -> Result<f64, Reason> {
    if metres.abs() <= FARTHEST {
        Ok(metres)
    } else {
        Err(Reason::TooFar { field: name(), metres })
    }
}

/// Seconds as a stamp: exact for plain decimals with up to nine places, else the nearest.
pub(super) fn stamp(text: &str, name: impl Fn() -> String) -> Result<Stamp, Reason> {
    let text = text.trim();
    if let Some(stamp) = plain_decimal(text) {
        return Ok(stamp);
    }
    let seconds = number(text, &name)?;
    Stamp::from_seconds(seconds)
        .ok_or_else(|| Reason::TimeOutOfRange { field: name(), value: shortened(text) })
}

/// `-12.000000001` without going through a float, which holds no such number.
fn plain_decimal(text: &str) -> Option<Stamp> {
    let (negative, digits) = text.strip_prefix('-').map_or((false, text), |rest| (true, rest));
    let (whole, part) = digits.split_once('.').unwrap_or((digits, "0"));
    let plain = |digits: &str, most: usize| {
        (1..=most).contains(&digits.len()) && digits.bytes().all(|byte| byte.is_ascii_digit())
    };
    if !plain(whole, 10) || !plain(part, 9) {
        return None;
    }
    let whole: i128 = whole.parse().ok()?;
    let part: i128 = format!("{part:0<9}").parse().ok()?;
    let total = whole * NANOSECONDS_PER_SECOND + part;
    i64::try_from(if negative { -total } else { total }).ok().map(Stamp)
}

/// The shortest decimal that [`stamp`] reads back as the same stamp.
pub(super) fn stamp_text(stamp: Stamp) -> String {
    let sign = if stamp.0 < 0 { "-" } else { "" };
    let (whole, part) =
        (stamp.0.unsigned_abs() / 1_000_000_000, stamp.0.unsigned_abs() % 1_000_000_000);
    if part == 0 {
        return format!("{sign}{whole}");
    }
    let part = format!("{part:09}");
    format!("{sign}{whole}.{}", part.trim_end_matches('0'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_survive_their_text() {
        for ns in
            [0, 1, -1, 33_333_333, -1_500_000_000, 1_700_000_000_123_456_789, i64::MAX, i64::MIN]
        {
            assert_eq!(stamp(&stamp_text(Stamp(ns)), String::new), Ok(Stamp(ns)), "{ns}");
        }
        assert_eq!(stamp_text(Stamp(-500_000_000)), "-0.5");
        assert_eq!(stamp(" 1e-1 ", String::new), Ok(Stamp(100_000_000)));
        assert_eq!(stamp("0.12345678949", String::new), Ok(Stamp(123_456_789)));
    }

    #[test]
    fn what_is_no_time_says_why() {
        let reason = |text| stamp(text, || "time_s".into()).unwrap_err().to_string();
        assert_eq!(reason("abc"), "field 'time_s': 'abc' is not a number");
        assert_eq!(reason("NaN"), "field 'time_s': 'NaN' is not finite");
        assert_eq!(reason("99999999999"), "field 'time_s': '99999999999' s is beyond ±292 years");
        assert_eq!(reason(""), "field 'time_s': '' is not a number");
    }
}
