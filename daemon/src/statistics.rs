//! Timing distributions of the ticks.

use hdrhistogram::Histogram;
use shm_schemas::{Percentiles, Status};

use crate::link::TickRecord;

/// Upper bound of the histograms, ns; longer durations count as this. Design choice: longer than
/// any stall except a suspend.
const DURATION_MAX_NS: u64 = 10_000_000_000;
/// Resolution: 1 % with 20 KiB per distribution.
const SIGNIFICANT_FIGURES: u8 = 2;

/// Distributions of [`Status`] since the start.
#[derive(Debug)]
pub struct TickStatistics {
    wake: Histogram<u64>,
    frame_age: Histogram<u64>,
    tick: Histogram<u64>,
    sensor_to_command: Histogram<u64>,
}

impl TickStatistics {
    /// Empty distributions. Never `None`, because the bounds are valid.
    #[must_use]
    pub fn new() -> Option<Self> {
        let empty = || Histogram::new_with_bounds(1, DURATION_MAX_NS, SIGNIFICANT_FIGURES).ok();
        Some(Self {
            wake: empty()?,
            frame_age: empty()?,
            tick: empty()?,
            sensor_to_command: empty()?,
        })
    }

    /// Adds a tick.
    pub fn record(&mut self, record: &TickRecord) {
        self.wake
            .saturating_record(u64::from(record.report.wake_late_ns));
        self.tick.saturating_record(u64::from(record.body_ns));
        if record.frame_age_ns != u64::MAX {
            self.frame_age.saturating_record(record.frame_age_ns);
            self.sensor_to_command
                .saturating_record(u64::from(record.report.sensor_to_command_ns));
        }
    }

    /// Writes the percentiles into a status.
    pub fn write(&self, status: &mut Status) {
        status.wake = percentiles(&self.wake);
        status.frame_age = percentiles(&self.frame_age);
        status.tick = percentiles(&self.tick);
        status.sensor_to_command = percentiles(&self.sensor_to_command);
    }
}

fn percentiles(histogram: &Histogram<u64>) -> Percentiles {
    Percentiles {
        p50_ns: histogram.value_at_quantile(0.5),
        p99_ns: histogram.value_at_quantile(0.99),
        p999_ns: histogram.value_at_quantile(0.999),
        max_ns: histogram.max(),
        count: histogram.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::TickReport;

    #[test]
    fn percentiles_are_within_one_percent() {
        let mut figures = TickStatistics::new().expect("valid bounds");
        for i in 1..=1000_u32 {
            let report = TickReport {
                wake_late_ns: i * 1000,
                ..TickReport::default()
            };
            figures.record(&TickRecord {
                report,
                frame_age_ns: u64::MAX,
                ..TickRecord::default()
            });
        }
        let mut status = Status::default();
        figures.write(&mut status);
        let near = |ns: u64, want_ns: u64| ns.abs_diff(want_ns) <= want_ns / 100;
        assert!(near(status.wake.p50_ns, 500_000), "{:?}", status.wake);
        assert!(near(status.wake.p99_ns, 990_000) && near(status.wake.max_ns, 1_000_000));
        assert_eq!((status.wake.count, status.frame_age.count), (1000, 0));
    }
}
