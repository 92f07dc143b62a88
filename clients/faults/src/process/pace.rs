//! Pace of a run, and the priority of the simulated robot.

use std::time::Duration;

use atas_process::scheduling;
use rustix::thread::{ClockId, clock_nanosleep_absolute};
use rustix::time::Timespec;

/// Longest wait for a process: its start, its end, an answer or a command, the effect of a reload.
/// Design choice: a busy machine needs some seconds.
pub(super) const TIMEOUT: Duration = Duration::from_secs(30);

/// Time of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// Virtual: the daemon answers every joint state. Repeatable.
    LockStep,
    /// 1 kHz by the clock.
    Clock,
}

/// Real-time priority of the simulated robot until it is dropped, if the kernel permits it. Like a
/// real robot, it must not pause because of other work.
pub(super) struct RobotPriority;

impl RobotPriority {
    pub(super) fn enter() -> Self {
        // Without the right, ticks may be late on a busy machine.
        let _ = scheduling::enter_fifo(scheduling::ROBOT_PRIORITY);
        Self
    }
}

impl Drop for RobotPriority {
    fn drop(&mut self) {
        scheduling::leave_fifo();
    }
}

/// Sleeps until a time of the monotonic clock.
pub(super) fn sleep_until(deadline_ns: u64) {
    let until = Timespec {
        tv_sec: (deadline_ns / 1_000_000_000).cast_signed(),
        tv_nsec: (deadline_ns % 1_000_000_000).cast_signed(),
    };
    // A signal ends the sleep early; the tick then begins early.
    let _ = clock_nanosleep_absolute(ClockId::Monotonic, &until);
}
