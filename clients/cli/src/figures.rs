//! Figures of measured durations.

use shm_schemas::Percentiles;

/// Percentiles of sorted durations: the smallest one that so large a share does not exceed.
pub(crate) fn percentiles(sorted_ns: &[u64]) -> Percentiles {
    let at = |share: f64| {
        let rank = (share * sorted_ns.len() as f64).ceil() as usize;
        sorted_ns.get(rank.max(1) - 1).copied().unwrap_or(0)
    };
    Percentiles {
        p50_ns: at(0.5),
        p99_ns: at(0.99),
        p999_ns: at(0.999),
        max_ns: at(1.0),
        count: sorted_ns.len() as u64,
    }
}

/// Percentiles of durations in any order.
pub(crate) fn of(mut durations_ns: Vec<u64>) -> Percentiles {
    durations_ns.sort_unstable();
    percentiles(&durations_ns)
}

/// The middle of some numbers, the lower one of two; `None` of none.
pub(crate) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.retain(|value| value.is_finite());
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_ranks() {
        let check = |durations: &[u64], expected: [u64; 5]| {
            let Percentiles {
                p50_ns,
                p99_ns,
                p999_ns,
                max_ns,
                count,
            } = of(durations.to_vec());
            assert_eq!([p50_ns, p99_ns, p999_ns, max_ns, count], expected);
        };
        check(&[], [0; 5]);
        check(&[7], [7, 7, 7, 7, 1]);
        check(&[4, 2, 3, 1], [2, 4, 4, 4, 4]);
        let thousand: Vec<u64> = (1..=1000).collect();
        check(&thousand, [500, 990, 999, 1000, 1000]);
    }

    #[test]
    fn medians_are_values() {
        let check = |values: &[f64], expected| assert_eq!(median(values.to_vec()), expected);
        check(&[], None);
        check(&[f64::NAN], None);
        check(&[3.0, 1.0, 2.0], Some(2.0));
        check(&[4.0, 1.0, 2.0, 3.0], Some(2.0));
    }
}
