//! Spin margin: time before a deadline at which to wake up, or to start work that must end before
//! it.

/// Minimum margin, ns, far above the cost of reading the clock. Design choice.
const MARGIN_MIN_NS: u64 = 5_000;
/// Steps of the margin after a wake-up later or earlier than it covers, ns. It converges to the
/// 99.5th percentile: one wake-up in `1 + UP / DOWN` = 201 is later. Design choice.
const UP_NS: u64 = 2_000;
const DOWN_NS: u64 = 10;

/// Margin that adapts to the machine's wake-up latency.
#[derive(Clone, Copy, Debug)]
pub struct SpinMargin {
    margin_ns: u64,
    max_ns: u64,
}

impl SpinMargin {
    /// Starts at the maximum, so that the first ticks are on time. A maximum of 0 disables
    /// spinning.
    #[must_use]
    pub fn new(max_ns: u64) -> Self {
        Self::starting_at(max_ns, max_ns)
    }

    /// Starts at a margin, limited to the maximum.
    #[must_use]
    pub fn starting_at(margin_ns: u64, max_ns: u64) -> Self {
        Self {
            margin_ns: margin_ns.min(max_ns),
            max_ns,
        }
    }

    /// Margin, ns.
    #[must_use]
    pub fn ns(&self) -> u64 {
        self.margin_ns
    }

    /// Maximum, ns.
    #[must_use]
    pub fn max_ns(&self) -> u64 {
        self.max_ns
    }

    /// Adapts to the delay of a wake-up, ns.
    pub fn observe(&mut self, late_ns: u64) {
        let wanted_ns = if late_ns > self.margin_ns {
            self.margin_ns + UP_NS
        } else {
            self.margin_ns.saturating_sub(DOWN_NS).max(MARGIN_MIN_NS)
        };
        self.margin_ns = wanted_ns.min(self.max_ns);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn converged_ns(late_ns: impl Fn(u64) -> u64, max_ns: u64) -> u64 {
        let mut margin = SpinMargin::new(max_ns);
        (0..100_000).for_each(|i| margin.observe(late_ns(i)));
        margin.ns()
    }

    #[test]
    fn margin_converges_below_its_maximum() {
        let near = |ns: u64, goal_ns: u64| ns.abs_diff(goal_ns) <= 3_000;
        assert!(near(converged_ns(|_| 40_000, 100_000), 40_000));
        // One outlier in a thousand has no effect.
        assert!(near(
            converged_ns(|i| if i % 1000 == 0 { 8_000_000 } else { 20_000 }, 100_000),
            20_000
        ));
        assert_eq!(converged_ns(|_| 5_000_000, 100_000), 100_000);
        assert_eq!(converged_ns(|_| 5_000_000, 0), 0);
        assert_eq!(converged_ns(|_| 0, 100_000), MARGIN_MIN_NS);
    }
}
