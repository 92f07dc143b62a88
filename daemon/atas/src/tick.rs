//! Tick time and stall detection. The core never reads a clock.

use crate::limits::STALL_PERIODS;
use shm_schemas::Reason;

/// One tick of the control loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tick {
    /// Index from 0; a gap means missed ticks.
    pub index: u64,
    /// Time of the clock that stamps the frames, ns (`CLOCK_MONOTONIC`, or virtual in lock-step).
    pub now_ns: u64,
}

/// Returns the signed time between two stamps, s.
#[must_use]
pub(crate) fn seconds_between(earlier_ns: u64, later_ns: u64) -> f64 {
    if later_ns >= earlier_ns {
        (later_ns - earlier_ns) as f64 * 1e-9
    } else {
        -((earlier_ns - later_ns) as f64 * 1e-9)
    }
}

/// Converts to ns; negative values and NaN become 0.
#[must_use]
pub(crate) fn nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9) as u64
}

/// Detects a stalled loop. After a long pause (SIGSTOP, suspend) the scene may have changed, so the
/// first tick must hold.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct StallDetector {
    step_s: f64,
    last_ns: Option<u64>,
    gap_s: f64,
}

impl StallDetector {
    /// Creates a detector for this tick period, s.
    pub(crate) fn new(step_s: f64) -> Self {
        Self {
            step_s,
            last_ns: None,
            gap_s: 0.0,
        }
    }

    /// Returns whether the last command has expired, so that the robot has stopped; slow ticks may
    /// miss one.
    pub(crate) fn command_expired(&self, valid_s: f64) -> bool {
        self.gap_s > valid_s.max(STALL_PERIODS * self.step_s)
    }

    /// Begins a tick; returns the hold reason after a stall.
    pub(crate) fn begin(&mut self, tick: Tick, allowed_s: f64) -> Reason {
        let last_ns = self.last_ns.replace(tick.now_ns).unwrap_or(tick.now_ns);
        let still_s = seconds_between(last_ns, tick.now_ns);
        self.gap_s = still_s;
        let allowed_s = allowed_s.max(STALL_PERIODS * self.step_s);
        if still_s > allowed_s {
            Reason::LoopStalled {
                stalled_ns: still_s * 1e9,
                limit_ns: allowed_s * 1e9,
            }
        } else {
            Reason::None
        }
    }
}

/// Stages of a tick in order, timed in [`shm_schemas::TickReport::stage_ns`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Joint state and request.
    Intake,
    /// Frames of both hands.
    Perception,
    /// Mode, modules, arbitration.
    Modules,
    /// Inverse kinematics of both hands.
    Kinematics,
    /// Safety gate.
    Safety,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pause_expires_the_command_except_at_slow_ticks() {
        let check = |step_s: f64, valid_s: f64, still_ns: u64, stops: bool| {
            let mut watch = StallDetector::new(step_s);
            for now_ns in [7_000_000_000, 7_000_000_000 + still_ns] {
                watch.begin(Tick { index: 0, now_ns }, 0.02);
            }
            assert_eq!(watch.command_expired(valid_s), stops, "{still_ns} ns");
        };
        check(0.001, 0.005, 1_000_000, false);
        check(0.001, 0.005, 5_000_000, false);
        check(0.001, 0.005, 5_100_000, true);
        check(0.01, 0.01, 10_100_000, false);
        check(0.01, 0.01, 26_000_000, true);
    }

    #[test]
    fn long_pause_between_ticks_is_a_stall() {
        let check = |step_s: f64, earlier_ns: u64, later_ns: u64, stalls: bool| {
            let mut watch = StallDetector::new(step_s);
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
        // Time that runs backwards is not a stall.
        check(0.001, 5_000_000_000, 1_000_000_000, false);
        // At 100 Hz one missed tick is not a stall.
        check(0.01, 5_000_000_000, 5_024_000_000, false);
        check(0.01, 5_000_000_000, 5_026_000_000, true);
    }
}
