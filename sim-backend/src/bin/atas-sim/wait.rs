//! Waiting for an answer on the bus: eagerly at first, because answers usually come at once, then ever more politely.

use std::time::Duration;

use shm_bus::now_ns;

use crate::failure::Failure;

/// An answer within this time is awaited without giving up the core, ns. A tick of the daemon takes about 20 µs. Ours.
const SPIN_NS: u64 = 50_000;
/// Until then the core is offered to others between looks, ns; afterwards the wait sleeps. Ours.
const YIELD_NS: u64 = 2_000_000;
/// Time between two looks of a long wait. Ours.
const NAP: Duration = Duration::from_micros(500);

/// A wait that has begun.
pub(crate) struct Wait {
    begin_ns: u64,
}

impl Wait {
    pub(crate) fn begin() -> Self {
        Self { begin_ns: now_ns() }
    }

    /// Lets time pass between two looks. In a long wait `greet` lets readers that came late have what they shall answer.
    pub(crate) fn pause(&self, greet: impl FnOnce() -> Result<(), Failure>) -> Result<(), Failure> {
        let waited_ns = now_ns() - self.begin_ns;
        if waited_ns < SPIN_NS {
            std::hint::spin_loop();
        } else if waited_ns < YIELD_NS {
            std::thread::yield_now();
        } else {
            greet()?;
            std::thread::sleep(NAP);
        }
        Ok(())
    }
}
