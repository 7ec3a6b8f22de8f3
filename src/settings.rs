//! Numbers among settings, each with what it may be: one table for code and for parameter files.

/// A number among settings and its bounds, both included.
#[derive(Debug)]
pub struct Setting<'a> {
    /// Its key in a parameter file.
    pub key: &'static str,
    /// The number.
    pub number: Number<'a>,
    /// The least it may be.
    pub low: f64,
    /// The most it may be.
    pub high: f64,
}

/// Where the number stands.
#[derive(Debug)]
pub enum Number<'a> {
    /// Any number.
    Real(&'a mut f64),
    /// A whole number.
    Count(&'a mut usize),
}

/// A setting is out of its bounds, or no number.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{key} is {value}, not {low} to {high}")]
pub struct OutOfBounds {
    /// Its key.
    pub key: &'static str,
    /// What it is.
    pub value: f64,
    /// The least it may be.
    pub low: f64,
    /// The most it may be.
    pub high: f64,
}

/// A real number's row of a table.
pub(crate) fn real<'a>(key: &'static str, value: &'a mut f64, low: f64, high: f64) -> Setting<'a> {
    Setting { key, number: Number::Real(value), low, high }
}

/// A whole number's row of a table.
pub(crate) fn count<'a>(
    key: &'static str,
    value: &'a mut usize,
    low: usize,
    high: usize,
) -> Setting<'a> {
    Setting { key, number: Number::Count(value), low: low as f64, high: high as f64 }
}

/// Whether all numbers are within their bounds.
///
/// # Errors
/// [`OutOfBounds`] names the first that is not.
pub(crate) fn check<'a>(
    settings: impl IntoIterator<Item = Setting<'a>>,
) -> Result<(), OutOfBounds> {
    for Setting { key, number, low, high } in settings {
        let value = match number {
            Number::Real(value) => *value,
            Number::Count(value) => *value as f64,
        };
        if !(low..=high).contains(&value) {
            return Err(OutOfBounds { key, value, low, high });
        }
    }
    Ok(())
}
