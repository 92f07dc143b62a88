//! The arithmetic of deadlines, without a clock.

use atas_core::Tick;

/// What made a tick begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Began {
    /// Its deadline; nothing was awaited.
    #[default]
    AtDeadline,
    /// What was awaited had come before the first look.
    FoundWaiting,
    /// What was awaited came while it was looked for.
    OnArrival,
    /// What was awaited had not come at the latest moment.
    InVain,
}

/// A tick that begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct TickStart {
    /// Index and time.
    pub tick: Tick,
    /// When it was due, ns.
    pub deadline_ns: u64,
    /// What made it begin.
    pub began: Began,
    /// How long after its moment it begins, ns: after the deadline; where something was awaited, after the last look that
    /// did not find it, or after the latest moment.
    pub late_ns: u64,
    /// Whether that is more than a tenth of a period.
    pub is_late: bool,
    /// Ticks missed so far.
    pub missed: u64,
    /// Lock-step only: the world settles, no order but a stop is taken.
    pub settling: bool,
}

/// Deadlines at `start + (index + 1) × period`.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    period_ns: u64,
    deadline_ns: u64,
    index: u64,
    missed: u64,
}

impl Schedule {
    /// Deadlines every `period_ns` (not 0), the first one a period after `start_ns`.
    #[must_use]
    pub fn new(start_ns: u64, period_ns: u64) -> Self {
        Self {
            period_ns,
            deadline_ns: start_ns + period_ns,
            index: 0,
            missed: 0,
        }
    }

    /// The next deadline, ns.
    #[must_use]
    pub fn deadline_ns(&self) -> u64 {
        self.deadline_ns
    }

    /// Moves the next deadline and all after it, by less than a period.
    pub fn shift(&mut self, by_ns: i64) {
        self.deadline_ns = self.deadline_ns.saturating_add_signed(by_ns);
    }

    /// Begins the next tick at `now_ns`, `late_ns` after its moment. If whole periods have passed since its deadline, this
    /// tick is the one of the latest deadline, and those before it are missed.
    pub fn begin(&mut self, now_ns: u64, began: Began, late_ns: u64) -> TickStart {
        let deadline_ns = self.deadline_ns;
        let skipped = now_ns.saturating_sub(deadline_ns) / self.period_ns;
        self.missed += skipped;
        let index = self.index + skipped;
        self.index = index + 1;
        self.deadline_ns += (skipped + 1) * self.period_ns;
        TickStart {
            tick: Tick { index, now_ns },
            deadline_ns,
            began,
            late_ns,
            is_late: late_ns > self.period_ns / 10,
            missed: self.missed,
            settling: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const START_NS: u64 = 1_000_000_007;

    fn check(delays_ns: &[u64], period_ns: u64) {
        let mut schedule = Schedule::new(START_NS, period_ns);
        let mut now_ns = START_NS;
        let mut executed: Vec<u64> = Vec::new();
        for delay_ns in delays_ns {
            let deadline_ns = schedule.deadline_ns();
            now_ns = now_ns.max(deadline_ns) + delay_ns;
            let start = schedule.begin(now_ns, Began::AtDeadline, now_ns - deadline_ns);
            assert_eq!(start.deadline_ns, deadline_ns, "the deadline waited for");
            assert_eq!(
                (schedule.deadline_ns() - START_NS) % period_ns,
                0,
                "the phase is kept"
            );
            assert!(schedule.deadline_ns() > now_ns, "nothing is caught up");
            assert!(
                executed.last().is_none_or(|last| start.tick.index > *last),
                "no tick twice"
            );
            executed.push(start.tick.index);
            assert_eq!(
                start.missed,
                start.tick.index + 1 - executed.len() as u64,
                "skips are counted"
            );
            let slot_ns = START_NS + (start.tick.index + 1) * period_ns;
            assert!(
                (slot_ns..slot_ns + period_ns).contains(&now_ns),
                "a tick runs in its own slot"
            );
        }
    }

    #[test]
    fn known_cases() {
        check(&[0, 0, 0], 1000);
        check(&[999, 0, 1], 1000);
        check(&[1000, 0], 1000);
        check(&[5_000_000_000, 0, 0], 1_000_000);
    }

    proptest! {
        #[test]
        fn never_bursts_keeps_phase_counts_skips(
            delays_ns in proptest::collection::vec(prop_oneof![0_u64..200, 0_u64..5_000_000, 0_u64..10_000_000_000], 1..200),
            period_ns in 100_000_u64..10_000_000,
        ) {
            check(&delays_ns, period_ns);
        }
    }
}
