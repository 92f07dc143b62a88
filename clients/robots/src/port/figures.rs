//! What a port counted and timed.

use std::fmt;

use hdrhistogram::Histogram;

use crate::drivers::wire::WireError;

/// Longest time that is told apart, ns.
const LONGEST_NS: u64 = 10_000_000_000;
/// Digits that times are told with.
const DIGITS: u8 = 2;

/// Counts and times since the start.
#[derive(Clone, Debug)]
pub struct Figures {
    /// From the begin of one cycle to the begin of the next, ns.
    pub period: Histogram<u64>,
    /// Bulk reads, ns.
    pub read: Histogram<u64>,
    /// Whole cycles, ns.
    pub cycle: Histogram<u64>,
    /// Answers that did not come.
    pub silent: u64,
    /// Answers that were damaged.
    pub damaged: u64,
    /// What servos refused.
    pub refused: u64,
    /// Times that the port was lost.
    pub troubles: u64,
    begun_ns: Option<u64>,
}

impl Default for Figures {
    fn default() -> Self {
        let times = || {
            Histogram::new_with_max(LONGEST_NS, DIGITS)
                .unwrap_or_else(|error| unreachable!("the bounds are constants: {error}"))
        };
        Self {
            period: times(),
            read: times(),
            cycle: times(),
            silent: 0,
            damaged: 0,
            refused: 0,
            troubles: 0,
            begun_ns: None,
        }
    }
}

impl Figures {
    /// Counts a failure.
    pub(super) fn count(&mut self, error: &WireError) {
        match error {
            WireError::Silent(_) => self.silent += 1,
            WireError::Damaged(_) => self.damaged += 1,
            WireError::Refused { .. } | WireError::OtherMode { .. } => self.refused += 1,
            WireError::Port(_) => {}
        }
        self.begun_ns = None;
    }

    /// Times a cycle.
    pub(super) fn time(&mut self, begun_ns: u64, read_ns: u64, ended_ns: u64) {
        self.read
            .saturating_record(read_ns.saturating_sub(begun_ns));
        self.cycle
            .saturating_record(ended_ns.saturating_sub(begun_ns));
        if let Some(before_ns) = self.begun_ns.replace(begun_ns) {
            self.period
                .saturating_record(begun_ns.saturating_sub(before_ns));
        }
    }
}

/// Median, 99th percentile and longest, ms.
fn times(times: &Histogram<u64>) -> String {
    let ms = |ns: u64| ns as f64 * 1e-6;
    let [p50, p99] = [0.5, 0.99].map(|quantile| ms(times.value_at_quantile(quantile)));
    format!("{p50:.2} ms (p99 {p99:.2}, max {:.2})", ms(times.max()))
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rate_hz = 1e9 / self.period.mean().max(1.0);
        let (period, read) = (times(&self.period), times(&self.read));
        if self.period.is_empty() {
            write!(f, "no cycles; ")?;
        } else {
            write!(
                f,
                "{rate_hz:.0} Hz: a cycle every {period}, reading {read}; "
            )?;
        }
        write!(
            f,
            "{} silent, {} damaged, {} refused, {} times lost",
            self.silent, self.damaged, self.refused, self.troubles
        )
    }
}
