//! Isolation of a command that runs for a foreign client.

use std::io;
use std::os::unix::process::CommandExt;
use std::process::Command;

use rustix::process::{Pid, Signal, getppid, set_parent_process_death_signal, setsid};

/// Gives the command a separate session without controlling terminal, and a process group that
/// signals reach as a whole. The kernel kills the command when the thread that starts it ends.
pub fn isolate(command: &mut Command) {
    let parent = Pid::from_raw(std::process::id().cast_signed());
    let alone = move || {
        setsid()?;
        set_parent_process_death_signal(Some(Signal::KILL))?;
        // A parent that died before this point cannot send the signal.
        if getppid() == parent {
            Ok(())
        } else {
            Err(io::ErrorKind::BrokenPipe.into())
        }
    };
    // SAFETY: between fork and exec this makes three system calls and neither allocates nor takes a
    // lock.
    unsafe { command.pre_exec(alone) };
}
