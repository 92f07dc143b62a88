//! Range checks of values that a scene or a client gives.

/// Scene value outside its allowed range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("scene rejected: {what} is {value}, needs {lower} to {upper}; correct it")]
pub struct OutOfRange {
    /// Name of the value, with its unit.
    pub what: &'static str,
    /// Rejected value.
    pub value: f64,
    /// Lowest allowed value.
    pub lower: f64,
    /// Highest allowed value.
    pub upper: f64,
}

/// Rejects a value outside `lower` to `upper`, and NaN.
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
