//! Command of a client: a child process with pipes, relayed in both directions.

use std::io::{self, Read};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, ChildStderr, ChildStdout, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process_group, pidfd_open};
use shm_bus::BusName;

use super::config::Config;
use crate::frame::Kind;
use crate::link::{Link, LinkError, check_period, wait};
use crate::message::{Reply, send_reply};

/// Bytes per piece of output.
const PIECE: usize = 16 << 10;
/// Longest wait for more output after the end of the command. Design choice: a pipe is
/// empty after microseconds.
const REST: Duration = Duration::from_secs(1);

/// Runs `atas` with these arguments for the client of the link.
pub(super) fn run(link: &mut Link, words: Vec<String>, config: &Config) -> Result<(), LinkError> {
    let silence = config.silence();
    let mut child = match spawn(words, &config.bus) {
        Ok(child) => child,
        Err(error) => {
            let reason = format!("could not start `atas` at the server because of: {error}");
            return send_reply(link, &Reply::Failed { exit: 1, reason });
        }
    };
    let silence_ms = u64::try_from(silence.as_millis()).unwrap_or(u64::MAX);
    let relayed = send_reply(link, &Reply::Started { silence_ms })
        .and_then(|()| Relay::new(&mut child)?.run(link, silence));
    if relayed.is_err() {
        // For the daemon, the client of the goal dies here. The command may have ended meanwhile.
        let _ = kill_process_group(Pid::from_child(&child), Signal::KILL);
    }
    let status = child.wait()?;
    relayed?;
    send_reply(link, &end(status))?;
    finish(link, silence)
}

/// Waits until the client has read everything and closes.
fn finish(link: &mut Link, silence: Duration) -> Result<(), LinkError> {
    loop {
        match link.next_frame() {
            Ok(Some(_)) => continue,
            Err(LinkError::Closed) => return Ok(()),
            other => other?,
        };
        let mut events = [PollFd::new(link, link.events(true))];
        wait(&mut events, check_period(silence))?;
        link.flush()?;
        match link.receive() {
            Err(LinkError::Closed) => return Ok(()),
            received => received?,
        }
        link.check_silence(silence)?;
    }
}

fn end(status: ExitStatus) -> Reply {
    match (status.code(), status.signal()) {
        (Some(code), _) => Reply::Ended(u8::try_from(code).unwrap_or(u8::MAX)),
        (None, signal) => Reply::Killed(signal.unwrap_or_default()),
    }
}

/// Starts `atas` from the folder of this program, with nothing of the client but its words.
fn spawn(words: Vec<String>, bus: &BusName) -> io::Result<Child> {
    let mut command = Command::new(std::env::current_exe()?.with_file_name("atas"));
    command
        .args(words)
        .env_clear()
        .env(BusName::ENV, bus.as_str())
        .current_dir("/")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    if let Some(folder) = std::env::var_os("XDG_RUNTIME_DIR") {
        command.env("XDG_RUNTIME_DIR", folder);
    }
    atas_gate::isolate(&mut command);
    command.spawn()
}

/// Relay between a command and its client.
struct Relay {
    pid: Pid,
    ended: OwnedFd,
    stdout: Option<ChildStdout>,
    stderr: Option<ChildStderr>,
    ended_at: Option<Instant>,
}

impl Relay {
    fn new(child: &mut Child) -> io::Result<Self> {
        let pid = Pid::from_child(child);
        Ok(Self {
            pid,
            ended: pidfd_open(pid, PidfdFlags::empty())?,
            stdout: child.stdout.take(),
            stderr: child.stderr.take(),
            ended_at: None,
        })
    }

    /// Relays until the command has ended and its output is sent.
    fn run(mut self, link: &mut Link, silence: Duration) -> Result<(), LinkError> {
        while !self.has_finished() {
            let ready = self.poll(link, check_period(silence))?;
            link.flush()?;
            link.receive()?;
            self.forward_signals(link)?;
            link.check_silence(silence)?;
            // A client that does not read makes the command wait at its pipe, not this server.
            if !link.has_backlog() && ready.stdout {
                forward(&mut self.stdout, Kind::Stdout, link)?;
            }
            if !link.has_backlog() && ready.stderr {
                forward(&mut self.stderr, Kind::Stderr, link)?;
            }
            // The rest of the output waits for the client as well.
            if ready.ended || self.ended_at.is_some() && link.has_backlog() {
                self.ended_at = Some(Instant::now());
            }
            link.keep_alive(silence)?;
        }
        Ok(())
    }

    fn has_finished(&self) -> bool {
        let is_drained = self.stdout.is_none() && self.stderr.is_none();
        self.ended_at
            .is_some_and(|ended_at| is_drained || ended_at.elapsed() > REST)
    }

    /// Waits for the client, the end of the command, and its output if the client has space.
    fn poll(&self, link: &Link, most: Duration) -> io::Result<Ready> {
        let has_space = !link.has_backlog();
        // An ended command or a closed pipe would end each wait at once.
        let ended = self.ended_at.is_none().then(|| self.ended.as_fd());
        let stdout = self.stdout.as_ref().map(AsFd::as_fd);
        let stderr = self.stderr.as_ref().map(AsFd::as_fd);
        let mut events = vec![PollFd::new(link, link.events(true))];
        let ended = add(&mut events, ended);
        let stdout = add(&mut events, stdout.filter(|_| has_space));
        let stderr = add(&mut events, stderr.filter(|_| has_space));
        wait(&mut events, most)?;
        let is_ready =
            |index: Option<usize>| index.is_some_and(|index| !events[index].revents().is_empty());
        Ok(Ready {
            ended: is_ready(ended),
            stdout: is_ready(stdout),
            stderr: is_ready(stderr),
        })
    }

    /// Passes Ctrl-C of the client on.
    fn forward_signals(&self, link: &mut Link) -> Result<(), LinkError> {
        while let Some(frame) = link.next_frame()? {
            match frame.kind {
                Kind::Alive => {}
                // The command may have ended meanwhile.
                Kind::Interrupt => {
                    let _ = kill_process_group(self.pid, Signal::INT);
                }
                kind => {
                    let why = format!("unexpected frame of kind {kind:?}");
                    return Err(io::Error::other(why).into());
                }
            }
        }
        Ok(())
    }
}

/// Readable descriptors.
struct Ready {
    ended: bool,
    stdout: bool,
    stderr: bool,
}

/// Adds a descriptor, if there is one, and returns its index.
fn add<'a>(events: &mut Vec<PollFd<'a>>, stream: Option<BorrowedFd<'a>>) -> Option<usize> {
    events.push(PollFd::from_borrowed_fd(stream?, PollFlags::IN));
    Some(events.len() - 1)
}

/// Sends one piece of a readable stream; closes it at its end.
fn forward(stream: &mut Option<impl Read>, kind: Kind, link: &mut Link) -> Result<(), LinkError> {
    let Some(pipe) = stream else { return Ok(()) };
    let mut piece = [0; PIECE];
    match pipe.read(&mut piece) {
        Ok(0) => *stream = None,
        Ok(bytes) => link.send(kind, &piece[..bytes])?,
        Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
        Err(error) => return Err(error.into()),
    }
    Ok(())
}
