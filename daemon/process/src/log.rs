//! Log output to standard error that never blocks the caller.
//!
//! ```text
//!  any thread ── line ─▶ bounded queue ─▶ writer thread ─▶ standard error
//! ```
//!
//! * **In:** `tracing` events. **Out:** lines on standard error.
//! * **Invariants:** a stalled reader, a full disk or a closed pipe loses lines, but never blocks
//!   or ends the process. Lost lines are counted, and the next successful write reports the count.
//! * **Not included:** the tick of the daemon, which writes records that the supervisor turns into
//!   lines. `tracing-appender` is not used because the daemon would have to lock its 2 MiB thread
//!   stack.

use std::io::{self, IsTerminal as _, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use crate::fatal_signals;
use crossbeam::channel::{Receiver, Sender, bounded};
use tracing_subscriber::EnvFilter;
pub use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::fmt::MakeWriter;

/// Format of the log lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogFormat {
    /// Plain text; coloured on a terminal unless `NO_COLOR` is set.
    Human,
    /// One JSON object per line.
    Json,
}

/// Capacity of the queue, lines. Design choice: some seconds of output of a daemon in trouble.
const QUEUE_LINES: usize = 512;
/// Stack size of the writer thread, bytes. Kept small because the daemon locks its memory.
const STACK_BYTES: usize = 64 << 10;
/// Longest time that the process waits at exit for the last lines to be written.
const FLUSH_TIMEOUT: Duration = Duration::from_millis(200);
/// Poll interval of that wait.
const FLUSH_POLL: Duration = Duration::from_millis(1);

/// Handle of the running log. Dropping it waits for the last lines to be written, at most
/// `FLUSH_TIMEOUT`.
#[derive(Debug)]
pub struct Log {
    lines: Option<Sender<Vec<u8>>>,
    writer: JoinHandle<()>,
}

/// Starts the log at this level, or at the levels of `RUST_LOG`, and installs the handlers of
/// [`fatal_signals`]. Call once per process.
///
/// # Errors
/// [`io::Error`] if the writer thread cannot start or the kernel refuses a signal handler.
pub fn start(format: LogFormat, level: LevelFilter) -> io::Result<Log> {
    fatal_signals::install(format == LogFormat::Json)?;
    let (send, receive) = bounded(QUEUE_LINES);
    let lost = Arc::<AtomicU64>::default();
    let counted = Arc::clone(&lost);
    let writer = Builder::new()
        .name("log".to_owned())
        .stack_size(STACK_BYTES)
        .spawn(move || write_all(&receive, &counted, &mut io::stderr()))?;
    let queue = Queue {
        lines: send.clone(),
        lost,
    };
    let filter = EnvFilter::builder()
        .with_default_directive(level.into())
        .from_env_lossy();
    let log = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(queue)
        // Errors of the log cannot be written to the log.
        .log_internal_errors(false);
    let colours = io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    match format {
        LogFormat::Human => log.with_ansi(colours).with_target(false).init(),
        LogFormat::Json => log.json().init(),
    }
    Ok(Log {
        lines: Some(send),
        writer,
    })
}

impl Drop for Log {
    fn drop(&mut self) {
        let Some(lines) = self.lines.take() else {
            return;
        };
        let begin = Instant::now();
        // An empty line marks the end of the queue. A full queue has no active reader, so the wait
        // is skipped.
        if lines.try_send(Vec::new()).is_ok() {
            while !self.writer.is_finished() && begin.elapsed() < FLUSH_TIMEOUT {
                std::thread::sleep(FLUSH_POLL);
            }
        }
    }
}

/// Creates one [`Line`] per event.
#[derive(Clone, Debug)]
struct Queue {
    lines: Sender<Vec<u8>>,
    lost: Arc<AtomicU64>,
}

impl<'a> MakeWriter<'a> for Queue {
    type Writer = Line<'a>;

    fn make_writer(&'a self) -> Line<'a> {
        Line {
            queue: self,
            text: Vec::new(),
        }
    }
}

/// One log line, queued when dropped.
struct Line<'a> {
    queue: &'a Queue,
    text: Vec<u8>,
}

impl Write for Line<'_> {
    fn write(&mut self, part: &[u8]) -> io::Result<usize> {
        self.text.extend_from_slice(part);
        Ok(part.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Drop for Line<'_> {
    fn drop(&mut self) {
        let text = std::mem::take(&mut self.text);
        if !text.is_empty() && self.queue.lines.try_send(text).is_err() {
            self.queue.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// Writes lines until an empty line arrives. Lines that cannot be written are counted as lost.
fn write_all(lines: &Receiver<Vec<u8>>, lost: &AtomicU64, out: &mut impl Write) {
    for line in lines {
        if line.is_empty() {
            return;
        }
        let before = lost.swap(0, Ordering::Relaxed);
        if before > 0 {
            let reported = writeln!(out, "{before} log lines lost: standard error was not read");
            if reported.is_err() {
                lost.fetch_add(before, Ordering::Relaxed);
            }
        }
        if out.write_all(&line).is_err() {
            lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pipe that fails the first `refuses` writes.
    struct Pipe {
        refuses: usize,
        text: Vec<u8>,
    }

    impl Write for Pipe {
        fn write(&mut self, part: &[u8]) -> io::Result<usize> {
            if self.refuses > 0 {
                self.refuses -= 1;
                return Err(io::ErrorKind::BrokenPipe.into());
            }
            self.text.write(part)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn broken_pipe_loses_and_counts_lines() {
        let (send, receive) = bounded(8);
        for line in ["one\n", "two\n", "three\n", ""] {
            send.send(line.into()).expect("room");
        }
        let lost = AtomicU64::new(0);
        let mut pipe = Pipe {
            refuses: 1,
            text: Vec::new(),
        };
        write_all(&receive, &lost, &mut pipe);
        let text = String::from_utf8(pipe.text).expect("text");
        assert_eq!(
            text,
            "1 log lines lost: standard error was not read\ntwo\nthree\n"
        );
    }

    #[test]
    fn full_queue_drops_lines_without_blocking() {
        let (lines, _unread) = bounded(2);
        let queue = Queue {
            lines,
            lost: Arc::default(),
        };
        for _ in 0..5 {
            queue
                .make_writer()
                .write_all(b"line\n")
                .expect("never fails");
        }
        assert_eq!(queue.lost.load(Ordering::Relaxed), 3);
    }
}
