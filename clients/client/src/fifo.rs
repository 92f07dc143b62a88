//! Real-time scheduling for the calling thread.

use std::io;

/// Priority of the daemon's tick thread by default, and of what is compared with it.
pub const PRIORITY: i32 = 80;

/// Makes the calling thread `SCHED_FIFO`. What it starts is ordinary again.
///
/// # Errors
/// What the kernel says, usually that it is not permitted.
pub fn enter(priority: i32) -> io::Result<()> {
    let parameters = libc::sched_param {
        sched_priority: priority,
    };
    // SAFETY: the call reads `parameters`, which lives, and changes the scheduling of the calling thread, nothing else.
    // It is made raw because rustix has no wrapper.
    let result = unsafe {
        libc::syscall(
            libc::SYS_sched_setscheduler,
            0,
            libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK,
            &raw const parameters,
        )
    };
    if result == 0 {
        Ok(())
    } else {
        Err(io::Error::last_os_error())
    }
}
