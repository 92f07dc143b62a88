//! Detection of stopped ticks. A daemon whose tick thread is frozen keeps publishing its last
//! state; a suspended process publishes nothing.

use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

use atas_process::stat::Stat;
use shm_bus::{BusName, Owner};
use shm_schemas::{Status, StatusFlags};

/// Age of the newest snapshot at which ticks count as stopped. Snapshots arrive every 20 ms, and a
/// shared machine may pause a core for about 10 ms. Design choice.
const STOPPED_AGE: Duration = Duration::from_millis(200);

/// Returns the time since the last tick if the ticks have stopped. Virtual time may pause for any
/// duration.
#[must_use]
pub fn standstill(status: &Status, now_ns: u64) -> Option<Duration> {
    let is_virtual = status.flags & StatusFlags::LOCKSTEP != 0;
    let age = Duration::from_nanos(now_ns.saturating_sub(status.stamp.captured_ns));
    (!is_virtual && age >= STOPPED_AGE).then_some(age)
}

/// Owner of a bus whose process is suspended by Ctrl-Z, a debugger or a freezer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stopped(pub Owner);

impl Stopped {
    /// Returns the owner of a bus if it is suspended.
    #[must_use]
    pub fn owner(bus: &BusName) -> Option<Self> {
        let owner = Owner::find(bus)?;
        let process = PathBuf::from(format!("/proc/{}", owner.pid));
        let is_stopped = Stat::read(&process).is_ok_and(|stat| stat.is_stopped());
        is_stopped.then_some(Self(owner))
    }
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(owner) = self;
        write!(
            f,
            "{owner}, which owns the bus, is stopped: it ticks no more, and the robot's last command has expired; `kill -CONT {pid}` \
             lets it go on, `kill -KILL {pid}` ends it",
            pid = owner.pid
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_snapshot_in_real_time_is_a_standstill() {
        let check = |flags, captured_ns, now_ns, expected_ms: Option<u64>| {
            let mut status = Status {
                flags,
                ..Status::default()
            };
            status.stamp.captured_ns = captured_ns;
            let expected = expected_ms.map(Duration::from_millis);
            assert_eq!(
                standstill(&status, now_ns),
                expected,
                "{captured_ns} {now_ns}"
            );
        };
        check(0, 1_000_000_000, 1_019_000_000, None);
        check(0, 1_000_000_000, 1_200_000_000, Some(200));
        check(0, 1_000_000_000, 3_500_000_000, Some(2_500));
        check(StatusFlags::LOCKSTEP, 0, 3_500_000_000, None);
        // A stamp in the future is not a standstill.
        check(0, u64::MAX, 0, None);
    }
}
