//! Co-occurrence of findings over the candidates of a stage.

use serde::Serialize;

use super::score::Score;
use crate::analysis::Claim;

/// Co-occurrence of two claims, each judged by its estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct CoOccurrence {
    /// First claim.
    pub one: Claim,
    /// Second claim.
    pub other: Claim,
    /// Candidates that show the first.
    pub show_one: usize,
    /// Candidates that show the second.
    pub show_other: usize,
    /// Candidates that show both.
    pub show_both: usize,
}

/// Counts every pair of claims.
#[must_use]
pub fn co_occurrences(scores: &[&Score]) -> Vec<CoOccurrence> {
    let claims = scores.first().map_or(0, |score| score.claims.len());
    let shows = |score: &Score, claim: usize| score.claims[claim].chance > 0.5;
    let count = |what: &dyn Fn(&Score) -> bool| scores.iter().filter(|score| what(score)).count();
    let pair = |(one, other): (usize, usize)| CoOccurrence {
        one: scores[0].claims[one].claim,
        other: scores[0].claims[other].claim,
        show_one: count(&|score| shows(score, one)),
        show_other: count(&|score| shows(score, other)),
        show_both: count(&|score| shows(score, one) && shows(score, other)),
    };
    let pairs = (0..claims).flat_map(|one| (one + 1..claims).map(move |other| (one, other)));
    pairs.map(pair).collect()
}
