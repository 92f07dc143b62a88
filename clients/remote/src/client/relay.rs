//! Relay of a running command: its output to this process, Ctrl-C to the server.
//!
//! A separate thread writes the output, so that a blocked terminal or pipe does not look like a
//! lost client.

use std::io::{self, Write};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::Context;
use atas_console::{Exit, ExitError, Interrupt};
use rustix::event::PollFd;

use super::config::Target;
use super::{CONNECT, connect_error, read_reply, request, unexpected};
use crate::frame::{Frame, Kind};
use crate::link::{Link, LinkError, check_period, wait};
use crate::message::{Reply, Work};

/// Pieces of output that wait for the terminal, each of at most one frame. Design choice.
const PIECES: usize = 8;
/// Pause between two attempts to pass a piece on while the terminal is blocked.
const RETRY: Duration = Duration::from_millis(5);

/// End of a command at the server.
pub(super) enum End {
    /// Exit code.
    Code(u8),
    /// Signal.
    Killed(i32),
    /// The reader of standard output closed it; the command ends with the connection.
    OutputClosed,
}

/// Targets of the output.
pub(super) struct Streams {
    stdout: Box<dyn Write + Send>,
}

impl Streams {
    /// Standard output of this process.
    pub(super) fn standard() -> Self {
        Self {
            stdout: Box::new(io::stdout()),
        }
    }

    /// A file instead of standard output.
    pub(super) fn file(file: std::fs::File) -> Self {
        Self {
            stdout: Box::new(file),
        }
    }

    /// Writes pieces until the sender is gone. The error is that of standard output.
    fn write_all(mut self, pieces: &Receiver<Frame>) -> io::Result<()> {
        for Frame { kind, payload } in pieces {
            if kind == Kind::Stdout {
                self.stdout.write_all(&payload)?;
                self.stdout.flush()?;
            } else {
                // Without standard error, the exit code still reports the failure.
                let _ = io::stderr().write_all(&payload);
            }
        }
        Ok(())
    }
}

/// Runs `atas` with these words at the server until it ends.
pub(super) fn run(
    target: &Target,
    words: Vec<String>,
    streams: Streams,
    interrupt: &Interrupt,
) -> anyhow::Result<End> {
    let until = Instant::now() + CONNECT;
    let started = request(target, Work::Run(words), until);
    let (link, reply) = started.map_err(|error| connect_error(target, &error))?;
    let Reply::Started { silence_ms } = reply else {
        return Err(unexpected(reply));
    };
    let (sender, pieces) = sync_channel(PIECES);
    let writer = std::thread::Builder::new()
        .name("output".into())
        .spawn(move || streams.write_all(&pieces))
        .context("could not start a thread")?;
    let relay = Relay {
        link,
        sender,
        waiting: None,
        silence: Duration::from_millis(silence_ms),
        is_interrupted: false,
    };
    let end = relay.run(interrupt);
    finish(end, writer, target, silence_ms)
}

/// Waits for the writer, and forms the end of the command.
fn finish(
    end: Result<Option<Reply>, LinkError>,
    writer: JoinHandle<io::Result<()>>,
    target: &Target,
    silence_ms: u64,
) -> anyhow::Result<End> {
    let written = writer.join().unwrap_or(Ok(()));
    match written {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => return Ok(End::OutputClosed),
        written => written.context("could not write the output")?,
    }
    match end {
        Ok(Some(Reply::Ended(code))) => Ok(End::Code(code)),
        Ok(Some(Reply::Killed(signal))) => Ok(End::Killed(signal)),
        Ok(Some(reply)) => Err(unexpected(reply)),
        Ok(None) => Ok(End::OutputClosed),
        Err(error) => Err(ExitError::with_code(
            Exit::NoDaemon,
            lost_text(&target.label, &error, silence_ms),
        )),
    }
}

fn lost_text(label: &str, error: &LinkError, silence_ms: u64) -> String {
    let silence_s = silence_ms as f64 * 1e-3;
    format!(
        "lost the connection to {label}: {error}. The server ends this command within {silence_s} s \
         after the last sign of life. An attached goal then holds; another goal continues. See \
         `atas status --remote {label}`"
    )
}

struct Relay {
    link: Link,
    sender: SyncSender<Frame>,
    /// Piece that the writer could not yet take.
    waiting: Option<Frame>,
    silence: Duration,
    is_interrupted: bool,
}

impl Relay {
    /// Returns the last reply; `None` if the output is closed.
    fn run(mut self, interrupt: &Interrupt) -> Result<Option<Reply>, LinkError> {
        loop {
            if !self.pass_on() {
                return Ok(None);
            }
            while self.waiting.is_none() {
                let Some(frame) = self.link.next_frame()? else {
                    break;
                };
                match frame.kind {
                    Kind::Stdout | Kind::Stderr => self.waiting = Some(frame),
                    Kind::Reply => return read_reply(&frame.payload).map(Some),
                    _ => {}
                }
                if !self.pass_on() {
                    return Ok(None);
                }
            }
            self.wait(interrupt)?;
        }
    }

    /// Passes a waiting piece to the writer; returns false if the output is closed.
    fn pass_on(&mut self) -> bool {
        let Some(frame) = self.waiting.take() else {
            return true;
        };
        match self.sender.try_send(frame) {
            Ok(()) => true,
            Err(TrySendError::Full(frame)) => {
                self.waiting = Some(frame);
                true
            }
            Err(TrySendError::Disconnected(_)) => false,
        }
    }

    /// Waits for data, and keeps the connection alive.
    fn wait(&mut self, interrupt: &Interrupt) -> Result<(), LinkError> {
        let reading = self.waiting.is_none();
        let most = if reading {
            check_period(self.silence)
        } else {
            RETRY
        };
        let mut events = [PollFd::new(&self.link, self.link.events(reading))];
        wait(&mut events, most)?;
        self.link.flush()?;
        if reading {
            self.link.receive()?;
            self.link.check_silence(self.silence)?;
        } else {
            self.link.pardon_silence();
        }
        if interrupt.is_set() && !self.is_interrupted {
            self.is_interrupted = true;
            self.link.send(Kind::Interrupt, &[])?;
        }
        self.link.keep_alive(self.silence)
    }
}
