//! Numbers that a scene or a client gives, and the ranges that they must lie in.

/// A number that no scene may have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("could not set the scene because {what} was {value}, needs {lower} to {upper}; correct it")]
pub struct OutOfRange {
    /// What the number is, with its unit.
    pub what: &'static str,
    /// The number.
    pub value: f64,
    /// The lowest value allowed.
    pub lower: f64,
    /// The highest value allowed.
    pub upper: f64,
}

/// NaN lies in no range.
pub(crate) fn in_range(
    what: &'static str,
    value: f64,
    lower: f64,
    upper: f64,
) -> Result<(), OutOfRange> {
    if value >= lower && value <= upper {
        return Ok(());
    }
    Err(OutOfRange {
        what,
        value,
        lower,
        upper,
    })
}
