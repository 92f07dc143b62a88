//! Time is an argument: the core never reads a clock.

/// One tick of the control loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Tick {
    /// Counts from 0; a gap means missed ticks.
    pub index: u64,
    /// The tick's time, ns of the clock that also stamps the frames (`CLOCK_MONOTONIC`, or virtual in lock-step).
    pub now_ns: u64,
}

/// Time from `earlier` to `later`, s; negative when the order is reversed.
#[must_use]
pub(crate) fn seconds_between(earlier_ns: u64, later_ns: u64) -> f64 {
    if later_ns >= earlier_ns {
        (later_ns - earlier_ns) as f64 * 1e-9
    } else {
        -((earlier_ns - later_ns) as f64 * 1e-9)
    }
}

/// A duration in ns; what is negative or not a number becomes 0.
#[must_use]
pub(crate) fn nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9) as u64
}
