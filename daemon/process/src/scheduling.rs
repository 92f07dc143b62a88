//! Real-time scheduling of the calling thread.
//!
//! ```text
//!  80  ticks of the daemon
//!  79  its stop thread
//!  70  a simulated robot
//!   1  the recorder
//!   0  everything else
//! ```

use std::io;

/// Default priority of the daemon's tick thread and of benchmarks that are compared with it.
pub const TICK_PRIORITY: i32 = 80;
/// Priority of a simulated robot. Like a real robot, it must not pause because of other work.
pub const ROBOT_PRIORITY: i32 = 70;

/// Sets the calling thread to `SCHED_FIFO`. Threads that it starts have normal scheduling.
///
/// # Errors
/// Error of the kernel, usually a missing permission (`RLIMIT_RTPRIO`).
pub fn enter_fifo(priority: i32) -> io::Result<()> {
    set(libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK, priority)
}

/// Sets the calling thread back to normal scheduling. Lowering the priority needs no permission, so
/// this cannot fail.
pub fn leave_fifo() {
    let _ = set(libc::SCHED_OTHER, 0);
}

fn set(policy: i32, priority: i32) -> io::Result<()> {
    let parameters = libc::sched_param {
        sched_priority: priority,
    };
    // SAFETY: the call reads `parameters`, which is alive, and changes only the scheduling of the
    // calling thread. A raw call is needed because rustix has no wrapper and the one of musl always
    // fails.
    let result = unsafe {
        libc::syscall(
            libc::SYS_sched_setscheduler,
            0,
            policy,
            &raw const parameters,
        )
    };
    if result == 0 {
        Ok(())
    } else {
        Err(io::Error::last_os_error())
    }
}
