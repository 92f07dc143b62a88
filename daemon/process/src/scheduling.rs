//! Real-time scheduling of the calling thread.
//!
//! ```text
//!  80  the daemon's ticks   79  its stop thread   70  a simulated robot   1  the recorder   0  everything else
//! ```

use std::io;

/// Priority of the daemon's tick thread by default, and of what is compared with it.
pub const TICK_PRIORITY: i32 = 80;
/// Priority of a simulated robot: a robot does not stop for other work, and neither shall its stand-in.
pub const ROBOT_PRIORITY: i32 = 70;

/// Makes the calling thread `SCHED_FIFO`. What it starts is ordinary again.
///
/// # Errors
/// What the kernel says, usually that the user lacks the right (`RLIMIT_RTPRIO`).
pub fn enter_fifo(priority: i32) -> io::Result<()> {
    set(libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK, priority)
}

/// Makes the calling thread an ordinary one again. It asks for less, so it is never refused.
pub fn leave_fifo() {
    let _ = set(libc::SCHED_OTHER, 0);
}

fn set(policy: i32, priority: i32) -> io::Result<()> {
    let parameters = libc::sched_param {
        sched_priority: priority,
    };
    // SAFETY: the call reads `parameters`, which lives, and changes the calling thread's scheduling, nothing else. It is
    // made raw because rustix has no wrapper and musl's fails always.
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
