//! Probability that a candidate shows the wanted claims.

use serde::Serialize;

use crate::analysis::{Claim, Findings, Verdict};
use crate::stats::Estimate;

/// Half the width of a 95 % interval in standard errors.
const STANDARD_ERRORS: f64 = 1.96;
/// Lower limit of the standard error, relative to the border. Design choice: few runs that all
/// agree give no certainty.
const STANDARD_ERROR_MIN: f64 = 0.02;

/// Result of one wanted claim.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClaimScore {
    /// Claim.
    pub claim: Claim,
    /// Estimated quantity; null if the runs give no estimate.
    pub estimate: Option<Estimate>,
    /// Probability that the quantity is above its border, with a normal error.
    pub chance: f64,
    /// Verdict at the 95 % level.
    pub verdict: Option<Verdict>,
}

/// Results of all wanted claims for one candidate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Score {
    /// Claims in the requested order.
    pub claims: Vec<ClaimScore>,
    /// Probability that all hold: the product of the single ones, assuming independence.
    pub chance_of_all: f64,
}

impl Score {
    /// Evaluates the findings of one candidate.
    #[must_use]
    pub fn new(findings: &Findings, wanted: &[Claim]) -> Self {
        let judge = |&claim: &Claim| {
            let estimate = claim.estimate(findings);
            ClaimScore {
                claim,
                estimate,
                chance: estimate.map_or(0.0, |estimate| chance(estimate, claim.border())),
                verdict: claim.verdict(findings),
            }
        };
        let claims: Vec<ClaimScore> = wanted.iter().map(judge).collect();
        let chance_of_all = claims.iter().map(|judged| judged.chance).product();
        Self {
            claims,
            chance_of_all,
        }
    }

    /// Returns whether every claim holds at the 95 % level.
    #[must_use]
    pub fn all_hold(&self) -> bool {
        let holds = |judged: &ClaimScore| judged.verdict == Some(Verdict::Reproduces);
        self.claims.iter().all(holds)
    }
}

/// Returns the probability that a quantity is above a border.
fn chance(Estimate { value, low, high }: Estimate, border: f64) -> f64 {
    let error = ((high - low) / (2.0 * STANDARD_ERRORS)).max(STANDARD_ERROR_MIN * border);
    0.5 * libm::erfc((border - value) / (error * std::f64::consts::SQRT_2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chance_follows_the_normal_distribution() {
        let rows = [
            ((0.5, 0.4, 0.6), 0.5, 0.5),
            ((0.6, 0.502, 0.698), 0.5, 0.977),
            ((0.4, 0.302, 0.498), 0.5, 0.023),
            ((1.0, 1.0, 1.0), 0.5, 1.0),
            ((0.0, 0.0, 0.0), 0.5, 0.0),
        ];
        for ((value, low, high), border, expected) in rows {
            let found = chance(Estimate { value, low, high }, border);
            assert!(
                (found - expected).abs() < 1e-3,
                "{value} over {border}: {found}"
            );
        }
    }
}
