//! Bytes → lines that say something, their words and numbers; angles by their unit.

use super::super::detect::without_mark;
use super::super::error::{Reason, Violations, shortened};
use super::super::field;

/// Every line that is neither blank nor a comment, with its number, without blanks at its ends.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = (u64, &[u8])> {
    let lines = without_mark(bytes).split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    (1..).zip(lines).filter(|(_, line)| !line.is_empty() && !line.starts_with(b"#"))
}

/// How a file counts angles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum AngleUnit {
    Degrees,
    Radians,
}

impl AngleUnit {
    pub(super) fn to_radians(self, angle: f64) -> f64 {
        match self {
            Self::Degrees => angle.to_radians(),
            Self::Radians => angle,
        }
    }
}

/// As many finite numbers as there are names, unless something is wrong, which is noted.
pub(super) fn numbers<const N: usize>(
    text: &str,
    names: [&str; N],
    line: u64,
    violations: &mut Violations,
) -> Option<[f64; N]> {
    let words = text.split_ascii_whitespace();
    let got = words.clone().count();
    if got != N {
        violations.add(line, Reason::FieldCount { expected: N, got });
        return None;
    }
    let mut values = [0.0; N];
    let mut good = true;
    for ((word, name), value) in words.zip(names).zip(&mut values) {
        match field::number(word, || name.into()) {
            Ok(number) => *value = number,
            Err(reason) => {
                violations.add(line, reason);
                good = false;
            }
        }
    }
    good.then_some(values)
}

/// The one word of `text`, unless there are none or several, which is noted.
pub(super) fn one_word<'a>(
    text: &'a str,
    line: u64,
    violations: &mut Violations,
) -> Option<&'a str> {
    let mut words = text.split_ascii_whitespace();
    let word = words.next();
    let got = usize::from(word.is_some()) + words.count();
    if got != 1 {
        violations.add(line, Reason::FieldCount { expected: 1, got });
    }
    word.filter(|_| got == 1)
}

/// A line's first word and what follows it.
pub(super) fn first_word(text: &str) -> (&str, &str) {
    text.split_once(|letter: char| letter.is_ascii_whitespace()).unwrap_or((text, ""))
}

/// A word that is none of those that may stand there.
pub(super) fn unknown(what: &'static str, word: &str, known: &'static str) -> Reason {
    Reason::UnknownWord { what, word: shortened(word), known }
}
