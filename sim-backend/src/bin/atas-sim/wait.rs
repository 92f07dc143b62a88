//! Wait for a response on the bus: spins first, then yields, then sleeps.

use std::time::Duration;

use shm_bus::now_ns;

use crate::failure::Failure;

/// Spin duration, ns. Design choice: a tick of the daemon takes about 20 µs.
const SPIN_NS: u64 = 50_000;
/// Time until sleeping instead of yielding, ns. Design choice.
const YIELD_NS: u64 = 2_000_000;
/// Sleep between two checks. Design choice.
const SLEEP: Duration = Duration::from_micros(500);

pub(crate) struct Wait {
    begin_ns: u64,
}

impl Wait {
    pub(crate) fn begin() -> Self {
        Self { begin_ns: now_ns() }
    }

    /// Pauses between two checks; a long wait also calls `connect_readers` for late readers.
    pub(crate) fn pause(
        &self,
        connect_readers: impl FnOnce() -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let waited_ns = now_ns() - self.begin_ns;
        if waited_ns < SPIN_NS {
            std::hint::spin_loop();
        } else if waited_ns < YIELD_NS {
            std::thread::yield_now();
        } else {
            connect_readers()?;
            std::thread::sleep(SLEEP);
        }
        Ok(())
    }
}
