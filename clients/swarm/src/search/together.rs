//! Which findings come together, and which exclude each other.

use serde::Serialize;

use super::score::Score;
use crate::analysis::Claim;

/// Two claims over the candidates of a stage, each by its estimate alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Together {
    /// One.
    pub one: Claim,
    /// The other.
    pub other: Claim,
    /// Candidates that show the one.
    pub show_one: usize,
    /// Candidates that show the other.
    pub show_other: usize,
    /// Candidates that show both.
    pub show_both: usize,
}

/// Counts every pair of claims.
#[must_use]
pub fn together(scores: &[&Score]) -> Vec<Together> {
    let claims = scores.first().map_or(0, |score| score.claims.len());
    let shows = |score: &Score, claim: usize| score.claims[claim].chance > 0.5;
    let count = |what: &dyn Fn(&Score) -> bool| scores.iter().filter(|score| what(score)).count();
    let pair = |(one, other): (usize, usize)| Together {
        one: scores[0].claims[one].claim,
        other: scores[0].claims[other].claim,
        show_one: count(&|score| shows(score, one)),
        show_other: count(&|score| shows(score, other)),
        show_both: count(&|score| shows(score, one) && shows(score, other)),
    };
    let pairs = (0..claims).flat_map(|one| (one + 1..claims).map(move |other| (one, other)));
    pairs.map(pair).collect()
}
