//! How long before a deadline to wake up and spin, and to begin what must end before it.

/// Least margin, ns: reading the clock once more costs nothing against it. Ours.
const LEAST_NS: u64 = 5_000;
/// How the margin moves after a wake-up that came later, or earlier, than it covers. It settles where one wake-up in
/// `1 + UP / DOWN` = 201 comes later: the 99.5th percentile, whatever the machine's outliers are. Ours.
const UP_NS: u64 = 2_000;
const DOWN_NS: u64 = 10;

/// A margin that follows the wake-up latency of the machine.
#[derive(Clone, Copy, Debug)]
pub struct SpinMargin {
    margin_ns: u64,
    max_ns: u64,
}

impl SpinMargin {
    /// Begins at the cap, because the first ticks shall be on time as well. A cap of 0 switches spinning off.
    #[must_use]
    pub fn new(max_ns: u64) -> Self {
        Self::from(max_ns, max_ns)
    }

    /// Begins at a margin, or at the cap if that is less.
    #[must_use]
    pub fn from(margin_ns: u64, max_ns: u64) -> Self {
        Self {
            margin_ns: margin_ns.min(max_ns),
            max_ns,
        }
    }

    /// The margin, ns.
    #[must_use]
    pub fn ns(&self) -> u64 {
        self.margin_ns
    }

    /// Its cap, ns.
    #[must_use]
    pub fn max_ns(&self) -> u64 {
        self.max_ns
    }

    /// Learns how late a sleep ended, ns.
    pub fn observe(&mut self, late_ns: u64) {
        let wanted_ns = if late_ns > self.margin_ns {
            self.margin_ns + UP_NS
        } else {
            self.margin_ns.saturating_sub(DOWN_NS).max(LEAST_NS)
        };
        self.margin_ns = wanted_ns.min(self.max_ns);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settled_ns(late_ns: impl Fn(u64) -> u64, max_ns: u64) -> u64 {
        let mut margin = SpinMargin::new(max_ns);
        (0..100_000).for_each(|i| margin.observe(late_ns(i)));
        margin.ns()
    }

    #[test]
    fn follows_the_machine_and_stays_below_its_cap() {
        let near = |ns: u64, goal_ns: u64| ns.abs_diff(goal_ns) <= 3_000;
        assert!(near(settled_ns(|_| 40_000, 100_000), 40_000));
        // One outlier in a thousand does not matter.
        assert!(near(
            settled_ns(|i| if i % 1000 == 0 { 8_000_000 } else { 20_000 }, 100_000),
            20_000
        ));
        assert_eq!(settled_ns(|_| 5_000_000, 100_000), 100_000);
        assert_eq!(settled_ns(|_| 5_000_000, 0), 0);
        assert_eq!(settled_ns(|_| 0, 100_000), LEAST_NS);
    }
}
