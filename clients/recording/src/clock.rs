//! Conversion from the sensors' clock to the wall clock.

use std::collections::BTreeMap;
use std::time::{SystemTime, UNIX_EPOCH};

/// Metadata key of the wall clock minus the machine's monotonic clock, ns.
const UNIX_OVER_MONOTONIC: &str = "unix_over_monotonic_ns";
/// Metadata key of the second in which the file was begun.
const BEGUN: &str = "file_begun_unix_s";

/// Offset from sensor time to wall-clock time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clock {
    unix_over_monotonic_ns: Option<i64>,
    begun_unix_ns: i64,
    offset_ns: i64,
}

impl Clock {
    /// Returns the clock data that a recorder stores in each file.
    pub(crate) fn now() -> [(&'static str, String); 2] {
        let unix = SystemTime::now().duration_since(UNIX_EPOCH);
        let unix_ns = unix.map_or(0, |time| time.as_nanos() as i64);
        let over_ns = unix_ns - shm_bus::now_ns() as i64;
        [
            (UNIX_OVER_MONOTONIC, over_ns.to_string()),
            (BEGUN, (unix_ns / 1_000_000_000).to_string()),
        ]
    }

    /// Creates the clock of this machine in real time.
    #[must_use]
    pub fn of_this_machine() -> Self {
        let mut clock = Self::default();
        let noted = Self::now().map(|(key, value)| (key.to_owned(), value));
        clock.read_metadata(&noted.into());
        clock.set_offset(0, false);
        clock
    }

    /// Reads the clock data of the first file; later files of the run keep its clock.
    pub(crate) fn read_metadata(&mut self, noted: &BTreeMap<String, String>) {
        let number = |key: &str| noted.get(key)?.parse::<i64>().ok();
        if self.begun_unix_ns == 0 {
            self.unix_over_monotonic_ns = number(UNIX_OVER_MONOTONIC);
            self.begun_unix_ns = number(BEGUN).unwrap_or(0).saturating_mul(1_000_000_000);
        }
    }

    /// Sets the offset from the first tick. Virtual time has no wall clock: there, and without
    /// stored data, the first tick is placed at the beginning of the file.
    pub(crate) fn set_offset(&mut self, first_ns: u64, is_virtual: bool) {
        let noted = self.unix_over_monotonic_ns.filter(|_| !is_virtual);
        let first_ns = i64::try_from(first_ns).unwrap_or(i64::MAX);
        self.offset_ns = noted.unwrap_or(self.begun_unix_ns.saturating_sub(first_ns));
    }

    /// Converts sensor time to wall-clock time, ns since 1970.
    #[must_use]
    pub fn unix_ns(&self, captured_ns: u64) -> u64 {
        captured_ns.saturating_add_signed(self.offset_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wall_clock_time_follows_from_metadata() {
        let check = |noted: &[(&str, &str)], first_ns, is_virtual, expected_ns| {
            let noted = noted
                .iter()
                .map(|(k, v)| ((*k).to_owned(), (*v).to_owned()));
            let mut clock = Clock::default();
            clock.read_metadata(&noted.collect());
            clock.set_offset(first_ns, is_virtual);
            assert_eq!(clock.unix_ns(first_ns + 7), expected_ns);
        };
        let both = [(UNIX_OVER_MONOTONIC, "1000000000000"), (BEGUN, "1002")];
        check(&both, 2_000_000_005, false, 1_002_000_000_012);
        check(&both, 5, true, 1_002_000_000_007);
        check(&both[1..], 2_000_000_005, false, 1_002_000_000_007);
        check(&[], 5, false, 7);
        check(&[(BEGUN, "never")], 5, false, 7);
    }
}
