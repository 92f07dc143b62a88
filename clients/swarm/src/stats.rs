//! Statistics over runs: quartiles, probabilities of orderings, bootstrap intervals.
//!
//! Implemented here because maintained statistics crates lack the bootstrap and the probability of
//! an ordering with ties, and because equal runs must give the same interval bit for bit.

use serde::Serialize;

use crate::rng::SplitMix64;

/// Returns the q-quantile of sorted values, linear between neighbours; 0 for an empty slice.
#[must_use]
pub fn quantile(sorted: &[f32], q: f64) -> f32 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return 0.0;
    };
    let place = q * last as f64;
    let (below, above) = (
        sorted[place as usize],
        sorted[(place as usize + 1).min(last)],
    );
    below + (above - below) * (place - place.floor()) as f32
}

/// Returns the values in ascending order.
#[must_use]
pub fn sorted(values: &[f32]) -> Vec<f32> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f32::total_cmp);
    sorted
}

/// Returns the median; 0 for an empty slice.
#[must_use]
pub fn median(values: &[f32]) -> f32 {
    quantile(&sorted(values), 0.5)
}

/// Returns the mean; 0 for an empty slice.
#[must_use]
pub fn mean(values: &[f32]) -> f32 {
    let sum: f64 = values.iter().map(|&value| f64::from(value)).sum();
    if values.is_empty() {
        0.0
    } else {
        (sum / values.len() as f64) as f32
    }
}

/// Returns the probability that a value of `a` exceeds one of `b`; ties count half. ½ if either is
/// empty.
#[must_use]
pub fn p_greater(a: &[f32], b: &[f32]) -> f64 {
    if a.is_empty() || b.is_empty() {
        return 0.5;
    }
    let b = sorted(b);
    let wins = |x: &f32| {
        let (below, up_to) = (b.partition_point(|y| y < x), b.partition_point(|y| y <= x));
        (below + up_to) as f64 / 2.0
    };
    a.iter().map(wins).sum::<f64>() / (a.len() * b.len()) as f64
}

/// An estimate with its 95 % percentile bootstrap interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Estimate from the original values.
    pub value: f64,
    /// Lower end: the 2.5 % quantile of the resampled estimates.
    pub low: f64,
    /// Upper end: the 97.5 % quantile.
    pub high: f64,
}

/// Resamples of a bootstrap. Design choice: at this number the ends of the interval vary by about 1
/// % of its width.
const RESAMPLES: usize = 2000;

/// Estimates a quantity of several groups of runs. Each group is resampled independently.
/// Deterministic.
pub fn bootstrap<T: Clone>(groups: &[&[T]], quantity: impl Fn(&[Vec<T>]) -> f64) -> Estimate {
    let mut rng = SplitMix64::stream(&[RESAMPLES as u64]);
    let own: Vec<Vec<T>> = groups.iter().map(|group| group.to_vec()).collect();
    let mut resampled: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            let draw = |group: &&[T]| {
                group
                    .iter()
                    .map(|_| group[rng.below(group.len())].clone())
                    .collect()
            };
            quantity(&groups.iter().map(draw).collect::<Vec<Vec<T>>>())
        })
        .collect();
    resampled.sort_by(f64::total_cmp);
    let end = |q: f64| resampled[(q * (RESAMPLES - 1) as f64).round() as usize];
    Estimate {
        value: quantity(&own),
        low: end(0.025),
        high: end(0.975),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate() {
        let rows: [(&[f32], f64, f32); 5] = [
            (&[], 0.5, 0.0),
            (&[3.0], 0.25, 3.0),
            (&[1.0, 2.0], 0.5, 1.5),
            (&[0.0, 1.0, 2.0, 3.0], 0.25, 0.75),
            (&[1.0, 5.0], 1.0, 5.0),
        ];
        for (values, q, expected) in rows {
            assert_eq!(quantile(values, q), expected, "{values:?} at {q}");
        }
    }

    #[test]
    fn p_greater_counts_ties_half() {
        let rows: [(&[f32], &[f32], f64); 5] = [
            (&[2.0], &[1.0], 1.0),
            (&[1.0], &[2.0], 0.0),
            (&[1.0], &[1.0], 0.5),
            (&[1.0, 3.0], &[2.0, 3.0], 0.375),
            (&[], &[1.0], 0.5),
        ];
        for (a, b, expected) in rows {
            assert_eq!(p_greater(a, b), expected, "{a:?} over {b:?}");
        }
    }

    #[test]
    fn bootstrap_interval_contains_mean_and_is_deterministic() {
        let values: Vec<f32> = (0..100).map(|k| k as f32).collect();
        let estimate = || bootstrap(&[&values[..]], |groups| f64::from(mean(&groups[0])));
        let Estimate { value, low, high } = estimate();
        assert_eq!(value, 49.5);
        assert!(
            (42.0..46.0).contains(&low) && (53.0..57.0).contains(&high),
            "[{low}, {high}]"
        );
        assert_eq!(estimate(), estimate());
    }
}
