//! Separation of tuning seeds from evaluation seeds. A parameter tuned on a seed cannot be
//! evaluated on it.
//!
//! Each seed is another member of every family. Parameters of modules and baselines are chosen on
//! [`TUNING`]. Published figures use seeds from [`EVALUATION_START`] on, the default of an
//! evaluation.

use core::ops::RangeInclusive;

/// Seeds for tuning.
pub const TUNING: RangeInclusive<u64> = 1..=20_000;
/// First seed excluded from tuning.
pub const EVALUATION_START: u64 = *TUNING.end() + 1;

/// Returns the purpose of these seeds, as in reports.
#[must_use]
pub fn purpose(first: u64, count: u64) -> &'static str {
    let last = first.saturating_add(count.saturating_sub(1));
    match (first >= EVALUATION_START, last >= EVALUATION_START) {
        (true, _) => "judging",
        (false, false) => "tuning",
        (false, true) => "tuning and judging",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tuning_seeds_are_named_in_the_purpose() {
        let check = |first, count, expected| assert_eq!(purpose(first, count), expected);
        check(1, 20_000, "tuning");
        check(1, 20_001, "tuning and judging");
        check(20_000, 1, "tuning");
        check(20_001, 1_000, "judging");
        check(u64::MAX, u64::MAX, "judging");
    }
}
