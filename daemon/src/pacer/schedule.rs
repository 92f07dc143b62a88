//! Arithmetic of deadlines, without a clock.

use atas_core::Tick;

/// Reason for the start of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum StartReason {
    /// Deadline; nothing was awaited.
    #[default]
    AtDeadline,
    /// The awaited payloads had arrived before the first poll.
    AlreadyArrived,
    /// The awaited payloads arrived during polling.
    OnArrival,
    /// The awaited payloads had not arrived at the time limit.
    TimedOut,
}

/// Start of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct TickStart {
    /// Index and time.
    pub tick: Tick,
    /// Deadline, ns.
    pub deadline_ns: u64,
    /// Reason for the start.
    pub reason: StartReason,
    /// Delay, ns: after the deadline; with awaited payloads, after the last unsuccessful poll or
    /// the time limit.
    pub late_ns: u64,
    /// True if the delay exceeds a tenth of a period.
    pub is_late: bool,
    /// Number of missed ticks so far.
    pub missed: u64,
    /// Lock-step only: the world is settling, and only stops are executed.
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
    /// Deadlines every `period_ns` (not 0), the first one period after `start_ns`.
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

    /// Shifts the next and all later deadlines, by less than a period.
    pub fn shift(&mut self, by_ns: i64) {
        self.deadline_ns = self.deadline_ns.saturating_add_signed(by_ns);
    }

    /// Starts the next tick at `now_ns` with this delay. If whole periods have passed since its
    /// deadline, it takes the latest deadline, and the earlier ones count as missed.
    pub fn begin(&mut self, now_ns: u64, began: StartReason, late_ns: u64) -> TickStart {
        let deadline_ns = self.deadline_ns;
        let skipped = now_ns.saturating_sub(deadline_ns) / self.period_ns;
        self.missed += skipped;
        let index = self.index + skipped;
        self.index = index + 1;
        self.deadline_ns += (skipped + 1) * self.period_ns;
        TickStart {
            tick: Tick { index, now_ns },
            deadline_ns,
            reason: began,
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
            let start = schedule.begin(now_ns, StartReason::AtDeadline, now_ns - deadline_ns);
            assert_eq!(
                start.deadline_ns, deadline_ns,
                "the deadline is the awaited one"
            );
            assert_eq!(
                (schedule.deadline_ns() - START_NS) % period_ns,
                0,
                "the phase is kept"
            );
            assert!(schedule.deadline_ns() > now_ns, "no tick is made up");
            assert!(
                executed.last().is_none_or(|last| start.tick.index > *last),
                "no index twice"
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
    fn schedule_handles_known_delays() {
        check(&[0, 0, 0], 1000);
        check(&[999, 0, 1], 1000);
        check(&[1000, 0], 1000);
        check(&[5_000_000_000, 0, 0], 1_000_000);
    }

    proptest! {
        #[test]
        fn schedule_keeps_phase_and_counts_skips(
            delays_ns in proptest::collection::vec(prop_oneof![0_u64..200, 0_u64..5_000_000, 0_u64..10_000_000_000], 1..200),
            period_ns in 100_000_u64..10_000_000,
        ) {
            check(&delays_ns, period_ns);
        }
    }
}
