//! Rates of a binary classification.

use serde::Serialize;

/// Rates at one threshold, and the area under the curve over all thresholds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rates {
    /// Mean of sensitivity and specificity.
    pub balanced_accuracy: f64,
    /// Share of negatives (stable contacts, soft objects) that are classified as negative.
    pub specificity: f64,
    /// Share of positives that are classified as positive.
    pub sensitivity: f64,
    /// Area under the receiver operating characteristic.
    pub auc: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scored {
    pub(super) score: f64,
    pub(super) decision: bool,
    pub(super) truth: bool,
}

impl Rates {
    /// Computes the rates; `None` unless both classes exist.
    pub(super) fn from_cases(cases: &[Scored]) -> Option<Self> {
        let share = |class: bool| {
            let of: Vec<_> = cases.iter().filter(|case| case.truth == class).collect();
            let right = of.iter().filter(|case| case.decision == class).count();
            (!of.is_empty()).then(|| right as f64 / of.len() as f64)
        };
        let (sensitivity, specificity) = (share(true)?, share(false)?);
        Some(Self {
            balanced_accuracy: 0.5 * (sensitivity + specificity),
            specificity,
            sensitivity,
            auc: auc(cases.iter().map(|case| (case.score, case.truth)))?,
        })
    }
}

/// Returns the probability that a positive scores higher than a negative; ties count half (Mann and
/// Whitney 1947). `None` unless both classes exist. NaN counts as the lowest score.
#[must_use]
pub fn auc(cases: impl Iterator<Item = (f64, bool)>) -> Option<f64> {
    let mut cases: Vec<(f64, bool)> = cases
        .map(|(score, is)| {
            let score = if score.is_nan() {
                f64::NEG_INFINITY
            } else {
                score
            };
            (score, is)
        })
        .collect();
    cases.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut negatives, mut positives, mut won) = (0.0, 0.0, 0.0);
    for tied in cases.chunk_by(|a, b| a.0 == b.0) {
        let up = tied.iter().filter(|(_, is)| *is).count() as f64;
        let down = tied.len() as f64 - up;
        won += up * (negatives + 0.5 * down);
        negatives += down;
        positives += up;
    }
    (negatives > 0.0 && positives > 0.0).then(|| won / (negatives * positives))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn auc_matches_known_values() {
        let check = |cases: &[(f64, bool)], expected: Option<f64>| {
            assert_eq!(auc(cases.iter().copied()), expected, "{cases:?}");
        };
        check(&[], None);
        check(&[(1.0, true), (2.0, true)], None);
        check(&[(1.0, false), (2.0, true)], Some(1.0));
        check(&[(2.0, false), (1.0, true)], Some(0.0));
        check(&[(1.0, false), (1.0, true)], Some(0.5));
        check(&[(f64::NAN, true), (f64::NAN, false)], Some(0.5));
        // scikit-learn's example of roc_auc_score.
        check(
            &[(0.1, false), (0.4, false), (0.35, true), (0.8, true)],
            Some(0.75),
        );
    }

    #[test]
    fn rates_need_both_classes() {
        let case = |message, is| Scored {
            score: 0.0,
            decision: message,
            truth: is,
        };
        assert_eq!(Rates::from_cases(&[case(true, true)]), None);
        let rates = Rates::from_cases(&[
            case(true, true),
            case(true, true),
            case(false, true),
            case(true, true),
            case(false, false),
            case(true, false),
        ])
        .expect("both classes");
        assert_eq!((rates.sensitivity, rates.specificity), (0.75, 0.5));
        assert_eq!(rates.balanced_accuracy, 0.625);
    }
}
