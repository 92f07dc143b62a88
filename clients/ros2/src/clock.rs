//! Stamps of ROS 2 messages from the daemon's clock.

use std::time::{SystemTime, UNIX_EPOCH};

use shm_schemas::{Status, StatusFlags};

use crate::wire::standard::{Header, Time};

const NS_PER_S: u64 = 1_000_000_000;

/// Clock of the daemon, compared with the wall clock.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Clock {
    unix_over_monotonic_ns: i64,
    is_virtual: bool,
}

impl Clock {
    /// Compares both clocks now. Virtual time has no wall clock: its data have the present time.
    #[must_use]
    pub(crate) fn now(status: &Status) -> Self {
        Self {
            unix_over_monotonic_ns: unix_ns() as i64 - shm_bus::now_ns() as i64,
            is_virtual: status.flags & StatusFlags::LOCKSTEP != 0,
        }
    }

    /// Returns the wall-clock time of a stamp.
    #[must_use]
    pub(crate) fn time(&self, captured_ns: u64) -> Time {
        if self.is_virtual {
            return present();
        }
        time(captured_ns.saturating_add_signed(self.unix_over_monotonic_ns))
    }

    /// Returns the header of data with this stamp.
    #[must_use]
    pub(crate) fn header(&self, captured_ns: u64, frame: &str) -> Header {
        Header {
            stamp: self.time(captured_ns),
            frame_id: frame.to_owned(),
        }
    }
}

/// Returns the present time.
#[must_use]
pub(crate) fn present() -> Time {
    time(unix_ns())
}

fn unix_ns() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |time| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX))
}

fn time(unix_ns: u64) -> Time {
    Time {
        sec: i32::try_from(unix_ns / NS_PER_S).unwrap_or(i32::MAX),
        nanosec: (unix_ns % NS_PER_S) as u32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn present_stamp_has_present_time() {
        let check = |flags: u32, captured_ns: u64| {
            let status = Status {
                flags,
                ..Status::default()
            };
            let stamped = Clock::now(&status).time(captured_ns);
            assert!((present().sec - stamped.sec).abs() <= 1, "{stamped:?}");
        };
        check(0, shm_bus::now_ns());
        check(StatusFlags::LOCKSTEP, 5_000_000);
    }
}
