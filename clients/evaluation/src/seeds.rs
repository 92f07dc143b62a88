//! Which seeds are for tuning and which for judging: a number that was tuned on a seed proves nothing on it.
//!
//! Every seed is another member of every family. What is chosen by trying, in the modules as in the baselines, is tried on
//! [`TUNING`]; figures that are quoted come from [`JUDGED_FROM`] on, which is where an evaluation begins by itself.

use core::ops::RangeInclusive;

/// Seeds that anything may be tuned on.
pub const TUNING: RangeInclusive<u64> = 1..=20_000;
/// The first seed that nothing may be tuned on.
pub const JUDGED_FROM: u64 = *TUNING.end() + 1;

/// What an evaluation over these seeds is good for.
#[must_use]
pub fn purpose(first: u64, count: u64) -> &'static str {
    let last = first.saturating_add(count.saturating_sub(1));
    match (first >= JUDGED_FROM, last >= JUDGED_FROM) {
        (true, _) => "judging",
        (false, false) => "tuning",
        (false, true) => "tuning and judging",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_tuned_seed_is_enough_to_spoil_a_judgement() {
        let check = |first, count, expected| assert_eq!(purpose(first, count), expected);
        check(1, 20_000, "tuning");
        check(1, 20_001, "tuning and judging");
        check(20_000, 1, "tuning");
        check(20_001, 1_000, "judging");
        check(u64::MAX, u64::MAX, "judging");
    }
}
