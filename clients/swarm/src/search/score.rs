//! How likely a candidate is to show what is wanted.

use serde::Serialize;

use crate::analysis::{Claim, Findings, Verdict};
use crate::stats::Estimate;

/// Half the width of a 95 % interval, in standard errors.
const STANDARD_ERRORS: f64 = 1.96;
/// The least standard error: few runs that all agree are no certainty (ours).
const LEAST_ERROR: f64 = 0.02;

/// What runs say of one wanted claim.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Judged {
    /// Which.
    pub claim: Claim,
    /// What was estimated; null if the runs say nothing of it.
    pub estimate: Option<Estimate>,
    /// The probability that it is above its border, as if its error were normal.
    pub chance: f64,
    /// Whether it holds at the 95 % level.
    pub verdict: Option<Verdict>,
}

/// What the runs of one candidate say of all that is wanted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Score {
    /// In the order in which they were asked for.
    pub claims: Vec<Judged>,
    /// The product of the chances: that all hold, as if they did not depend on each other.
    pub chance_of_all: f64,
}

impl Score {
    /// Judges the findings of one candidate.
    #[must_use]
    pub fn new(findings: &Findings, wanted: &[Claim]) -> Self {
        let judge = |&claim: &Claim| {
            let estimate = claim.estimate(findings);
            Judged {
                claim,
                estimate,
                chance: estimate.map_or(0.0, |estimate| chance(estimate, claim.border())),
                verdict: claim.verdict(findings),
            }
        };
        let claims: Vec<Judged> = wanted.iter().map(judge).collect();
        let chance_of_all = claims.iter().map(|judged| judged.chance).product();
        Self {
            claims,
            chance_of_all,
        }
    }

    /// Whether every claim holds at the 95 % level.
    #[must_use]
    pub fn all_hold(&self) -> bool {
        let holds = |judged: &Judged| judged.verdict == Some(Verdict::Reproduces);
        self.claims.iter().all(holds)
    }
}

/// The probability that a quantity is above a border.
fn chance(Estimate { value, low, high }: Estimate, border: f64) -> f64 {
    let error = ((high - low) / (2.0 * STANDARD_ERRORS)).max(LEAST_ERROR * border);
    0.5 * libm::erfc((border - value) / (error * std::f64::consts::SQRT_2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chances_are_those_of_the_normal_distribution() {
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
