//! Histogram of durations over the last seconds.

use std::time::{Duration, Instant};

/// Upper edges of the bins, ns; the last bin has none. Steps of 1, 2, 5, from a microsecond to ten
/// milliseconds (ten ticks).
pub const EDGES_NS: [u64; 13] = [
    1_000, 2_000, 5_000, 10_000, 20_000, 50_000, 100_000, 200_000, 500_000, 1_000_000, 2_000_000,
    5_000_000, 10_000_000,
];
/// Number of bins.
pub const BINS: usize = EDGES_NS.len() + 1;
/// Shortest time that a duration stays in the histogram; the longest is twice this. Design choice.
const WINDOW: Duration = Duration::from_secs(5);

/// Counts per bin.
///
/// ```
/// use atas_client::histogram::Histogram;
///
/// let mut wake = Histogram::default();
/// wake.add(500);
/// assert_eq!(wake.counts()[0], 1, "below one microsecond");
/// ```
#[derive(Clone, Debug)]
pub struct Histogram {
    now: [u64; BINS],
    before: [u64; BINS],
    turned: Instant,
}

impl Default for Histogram {
    fn default() -> Self {
        Self {
            now: [0; BINS],
            before: [0; BINS],
            turned: Instant::now(),
        }
    }
}

impl Histogram {
    /// Counts a duration.
    pub fn add(&mut self, ns: u64) {
        if self.turned.elapsed() > WINDOW {
            self.before = std::mem::replace(&mut self.now, [0; BINS]);
            self.turned = Instant::now();
        }
        self.now[bin(ns)] += 1;
    }

    /// Returns the counts of all bins.
    #[must_use]
    pub fn counts(&self) -> [u64; BINS] {
        std::array::from_fn(|bin| self.now[bin] + self.before[bin])
    }
}

fn bin(ns: u64) -> usize {
    EDGES_NS.partition_point(|edge| *edge <= ns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn duration_counts_below_the_next_edge() {
        let check = |ns, expected| assert_eq!(bin(ns), expected, "{ns}");
        check(0, 0);
        check(999, 0);
        check(1_000, 1);
        check(9_999_999, BINS - 2);
        check(10_000_000, BINS - 1);
        check(u64::MAX, BINS - 1);
    }
}
