//! Pipes to an engine with a deadline: an engine that hangs cannot block this process.

use std::io::{self, Read, Write};
use std::process::{ChildStdin, ChildStdout};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// Largest write after a pipe is ready, bytes: POSIX guarantees that such a write does not block.
const WRITE_MAX: usize = 4096;

/// Pipe with a deadline: reading or writing fails with [`io::ErrorKind::TimedOut`] after it.
#[derive(Debug)]
pub(super) struct Timed<P> {
    pipe: P,
    deadline: Instant,
}

impl<P> Timed<P> {
    /// Returns a pipe whose deadline has passed.
    pub(super) fn new(pipe: P) -> Self {
        Self {
            pipe,
            deadline: Instant::now(),
        }
    }

    pub(super) fn set_deadline(&mut self, deadline: Instant) {
        self.deadline = deadline;
    }
}

impl Read for Timed<ChildStdout> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        wait(PollFd::new(&self.pipe, PollFlags::IN), self.deadline)?;
        self.pipe.read(buffer)
    }
}

impl Write for Timed<ChildStdin> {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        wait(PollFd::new(&self.pipe, PollFlags::OUT), self.deadline)?;
        self.pipe.write(&buffer[..buffer.len().min(WRITE_MAX)])
    }

    fn flush(&mut self) -> io::Result<()> {
        self.pipe.flush()
    }
}

/// Waits until the pipe is ready or closed.
fn wait(mut pipe: PollFd<'_>, deadline: Instant) -> io::Result<()> {
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        let left = Timespec::try_from(left).map_err(io::Error::other)?;
        match poll(core::slice::from_mut(&mut pipe), Some(&left)) {
            Ok(0) => return Err(io::ErrorKind::TimedOut.into()),
            Ok(_) => return Ok(()),
            Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
    }
}

/// Returns the deadline of an exchange that begins now.
pub(super) fn deadline(limit_s: f64) -> Instant {
    Instant::now() + Duration::from_secs_f64(limit_s)
}
