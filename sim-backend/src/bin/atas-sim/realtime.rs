//! Real-time scheduling, if the kernel grants it: a robot does not stop for other work, and neither shall its stand-in.

use std::io;

/// Below the daemon's tick (80), above everything that is not real-time.
const PRIORITY: i32 = 70;

/// Puts the calling thread under `SCHED_FIFO`.
///
/// # Errors
/// What the kernel says, usually that the user lacks the right (`RLIMIT_RTPRIO`).
pub(crate) fn enter() -> io::Result<()> {
    let parameters = libc::sched_param {
        sched_priority: PRIORITY,
    };
    // SAFETY: the call reads one valid parameter struct and changes only how this thread is scheduled.
    let result = unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &raw const parameters) };
    if result == 0 {
        Ok(())
    } else {
        Err(io::Error::last_os_error())
    }
}
