//! Clock and random number for the stamps of all payloads on the bus.

use rustix::rand::{GetRandomFlags, getrandom};
use rustix::time::{ClockId, clock_gettime};

/// Time of every [`shm_schemas::Stamp`], ns of `CLOCK_MONOTONIC`. No system call (vDSO, about 20
/// ns).
#[must_use]
pub fn now_ns() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    // Neither part is negative on `CLOCK_MONOTONIC`.
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// Random non-zero [`shm_schemas::Stamp::writer_epoch`]. Draw one at each start of a writer.
#[must_use]
pub fn writer_epoch() -> u64 {
    nonce().max(1)
}

/// Random number of the kernel; early in boot, if none is available, derived from clock and process
/// id.
pub(crate) fn nonce() -> u64 {
    let mut bytes = [0_u8; 8];
    let filled = getrandom(&mut bytes, GetRandomFlags::NONBLOCK);
    match filled {
        Ok(8) => u64::from_ne_bytes(bytes),
        _ => now_ns().rotate_left(24) ^ u64::from(std::process::id()),
    }
}

#[cfg(test)]
mod tests {
    use super::{now_ns, writer_epoch};

    #[test]
    fn clock_is_monotonic() {
        let before = now_ns();
        assert!(now_ns() >= before);
    }

    #[test]
    fn epochs_differ() {
        assert_ne!(writer_epoch(), writer_epoch());
    }
}
