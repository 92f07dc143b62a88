//! Counts and times of a port.

use std::fmt;

use hdrhistogram::Histogram;

use crate::drivers::wire::WireError;

/// Longest recorded time, ns.
const LONGEST_NS: u64 = 10_000_000_000;
/// Significant digits of times.
const DIGITS: u8 = 2;

/// Counts and times since the start.
#[derive(Clone, Debug)]
pub struct Figures {
    /// Time between the starts of two cycles, ns.
    pub period: Histogram<u64>,
    /// Duration of bulk reads, ns.
    pub read: Histogram<u64>,
    /// Duration of cycles, ns.
    pub cycle: Histogram<u64>,
    /// Missing replies.
    pub unanswered: u64,
    /// Damaged replies.
    pub damaged: u64,
    /// Requests rejected by servos.
    pub rejected: u64,
    /// Failures of the port.
    pub failures: u64,
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
            unanswered: 0,
            damaged: 0,
            rejected: 0,
            failures: 0,
            begun_ns: None,
        }
    }
}

impl Figures {
    /// Counts a failure.
    pub(super) fn count(&mut self, error: &WireError) {
        match error {
            WireError::NoReply(_) => self.unanswered += 1,
            WireError::Damaged(_) => self.damaged += 1,
            WireError::Rejected { .. } | WireError::WrongMode { .. } => self.rejected += 1,
            WireError::Port(_) => {}
        }
        self.begun_ns = None;
    }

    /// Records the times of a cycle.
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

/// Formats median, 99th percentile and maximum, ms.
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
            "{} without reply, {} damaged, {} rejected, {} port failures",
            self.unanswered, self.damaged, self.rejected, self.failures
        )
    }
}
