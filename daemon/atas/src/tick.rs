//! Time is an argument: the core never reads a clock.

use crate::limits::STALL_PERIODS;
use shm_schemas::{Cause, Reason};

/// One tick of the control loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

/// Notices that the loop stood still. After a long sleep (SIGSTOP, a suspended machine) the world may be another one:
/// the first tick back must hold.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct StallWatch {
    step_s: f64,
    last_ns: Option<u64>,
    still_s: f64,
}

impl StallWatch {
    /// A watch over ticks of this period.
    pub(crate) fn new(step_s: f64) -> Self {
        Self {
            step_s,
            last_ns: None,
            still_s: 0.0,
        }
    }

    /// Whether the one before is so long ago that its command has expired, and the robot has stopped by itself; a slow tick may
    /// miss one.
    pub(crate) fn outlasts(&self, valid_s: f64) -> bool {
        self.still_s > valid_s.max(STALL_PERIODS * self.step_s)
    }

    /// A tick begins: what to hold for if the one before is longer ago than allowed.
    pub(crate) fn begin(&mut self, tick: Tick, allowed_s: f64) -> Reason {
        let last_ns = self.last_ns.replace(tick.now_ns).unwrap_or(tick.now_ns);
        let still_s = seconds_between(last_ns, tick.now_ns);
        self.still_s = still_s;
        let allowed_s = allowed_s.max(STALL_PERIODS * self.step_s);
        if still_s > allowed_s {
            Reason::limit(Cause::LOOP_STALLED, still_s * 1e9, allowed_s * 1e9)
        } else {
            Reason::default()
        }
    }
}

/// Stages of a tick, in order; their durations are [`shm_schemas::TickReport::stage_ns`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Joint state, orders.
    Intake,
    /// Frames, both hands.
    Perception,
    /// Mode, modules, arbitration.
    Modules,
    /// Inverse kinematics, both hands.
    Kinematics,
    /// The last gate.
    Safety,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_expired_command_is_a_stop_unless_ticks_are_slow() {
        let check = |step_s: f64, valid_s: f64, still_ns: u64, stops: bool| {
            let mut watch = StallWatch::new(step_s);
            for now_ns in [7_000_000_000, 7_000_000_000 + still_ns] {
                watch.begin(Tick { index: 0, now_ns }, 0.02);
            }
            assert_eq!(watch.outlasts(valid_s), stops, "{still_ns} ns");
        };
        check(0.001, 0.005, 1_000_000, false);
        check(0.001, 0.005, 5_000_000, false);
        check(0.001, 0.005, 5_100_000, true);
        check(0.01, 0.01, 10_100_000, false);
        check(0.01, 0.01, 26_000_000, true);
    }

    #[test]
    fn only_a_long_pause_between_two_ticks_is_a_stall() {
        let check = |step_s: f64, earlier_ns: u64, later_ns: u64, stalls: bool| {
            let mut watch = StallWatch::new(step_s);
            let at = |now_ns| Tick { index: 0, now_ns };
            assert!(
                !watch.begin(at(earlier_ns), 0.02).is_some(),
                "the first tick"
            );
            assert_eq!(watch.begin(at(later_ns), 0.02).is_some(), stalls);
            assert!(!watch.begin(at(later_ns + 1), 0.02).is_some(), "once");
        };
        check(0.001, 5_000_000_000, 5_019_000_000, false);
        check(0.001, 5_000_000_000, 5_021_000_000, true);
        // Time that runs backwards is no stall.
        check(0.001, 5_000_000_000, 1_000_000_000, false);
        // At 100 Hz one missed tick is none either.
        check(0.01, 5_000_000_000, 5_024_000_000, false);
        check(0.01, 5_000_000_000, 5_026_000_000, true);
    }
}
