//! Percentiles of measured durations.

use shm_schemas::Percentiles;

/// Returns percentiles of sorted durations: the smallest duration that a given fraction does not
/// exceed.
#[must_use]
pub fn from_sorted(sorted_ns: &[u64]) -> Percentiles {
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

/// Returns percentiles of durations in any order.
///
/// ```
/// let figures = atas_client::percentiles::from_unsorted((1..=100).rev().collect());
/// assert_eq!((figures.p50_ns, figures.max_ns), (50, 100));
/// ```
#[must_use]
pub fn from_unsorted(mut durations_ns: Vec<u64>) -> Percentiles {
    durations_ns.sort_unstable();
    from_sorted(&durations_ns)
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
            } = from_unsorted(durations.to_vec());
            assert_eq!([p50_ns, p99_ns, p999_ns, max_ns, count], expected);
        };
        check(&[], [0; 5]);
        check(&[7], [7, 7, 7, 7, 1]);
        check(&[4, 2, 3, 1], [2, 4, 4, 4, 4]);
        let thousand: Vec<u64> = (1..=1000).collect();
        check(&thousand, [500, 990, 999, 1000, 1000]);
    }
}
