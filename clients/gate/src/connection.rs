//! Connection: receives the request, decides, runs the command on the client's streams, forwards
//! signals, reports the end.

use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::process::ExitStatusExt;
use std::path::PathBuf;
use std::process::{Child, Command};

use anyhow::{Context, anyhow};
use atas_console::arguments::Right;
use atas_gate::message::{self, Reply, Request, SIGNALS, STREAMS};
use nix::sys::socket::{UnixCredentials, getsockopt, sockopt::PeerCredentials};
use nix::unistd::{Uid, User};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{FileType, fstat};
use rustix::net::{RecvFlags, recv};
use rustix::process::{Pid, PidfdFlags, Signal, geteuid, kill_process_group, pidfd_open};

use crate::permissions;
use crate::server::CONNECTIONS_PER_USER;

/// Longest wait for the request. Design choice: a client sends it at once.
const REQUEST: Timespec = Timespec {
    tv_sec: 2,
    tv_nsec: 0,
};
/// Longest command text in the log, characters.
const LOGGED: usize = 200;

/// Serves the client on standard input.
pub(crate) fn serve(config: &[PathBuf], full: bool) -> anyhow::Result<()> {
    let visitor = io::stdin()
        .as_fd()
        .try_clone_to_owned()
        .context("could not use standard input")?;
    let from = getsockopt(&visitor, PeerCredentials).context("could not identify the client")?;
    let mut asked = [PollFd::new(&visitor, PollFlags::IN)];
    if poll(&mut asked, Some(&REQUEST)).context("could not wait for the request")? == 0 {
        tracing::warn!("{} sent no request and was disconnected", Identity(&from));
        return Ok(());
    }
    let answer = match prepare(&visitor, &from, config, full) {
        Ok(mut prepared) => match prepared.spawn() {
            Ok(child) => return supervise(&visitor, child, prepared),
            Err(error) => Reply::Refused(format!(
                "could not start `atas` at the gate because of: {error}"
            )),
        },
        Err(answer) => answer,
    };
    if let Reply::Refused(why) = &answer {
        tracing::warn!("{} was refused: {why:?}", Identity(&from));
    }
    // The client may be gone.
    let _ = message::reply(&visitor, &answer);
    Ok(())
}

/// Returns the command to run, or the reply to a rejected client.
fn prepare(
    visitor: &OwnedFd,
    from: &UnixCredentials,
    config: &[PathBuf],
    full: bool,
) -> Result<Command, Reply> {
    let refused = |why: String| Reply::Refused(format!("rejected by the gate: {why}"));
    let (request, streams) = message::receive_request(visitor).map_err(refused)?;
    let right = request.right().map_err(refused)?;
    if full && right != Right::Stop {
        return Err(Reply::Busy(CONNECTIONS_PER_USER));
    }
    if !needs_no_gate(from) {
        permissions::check(right, &permissions::read_permission(config)).map_err(Reply::Refused)?;
    }
    if let Some((name, _)) = request
        .environment
        .iter()
        .find(|(name, value)| !Request::is_permitted(name, value))
    {
        return Err(refused(format!(
            "environment variable {name:?} is not permitted"
        )));
    }
    if let Some(kind) = streams.iter().find_map(invalid_kind) {
        return Err(refused(format!(
            "a standard stream is {kind}, needs to be a terminal, a pipe, a file or a socket"
        )));
    }
    let line: String = request.arguments.join(" ").chars().take(LOGGED).collect();
    tracing::info!(
        "{} may {right}: {:?}",
        Identity(from),
        format!("atas {line}")
    );
    let command = command_of(request, streams);
    command.map_err(|error| refused(format!("of: {error}")))
}

/// Returns true if the client needs no gate: the bus's user, and root.
fn needs_no_gate(from: &UnixCredentials) -> bool {
    [geteuid().as_raw(), 0].contains(&from.uid())
}

/// Returns the kind of a stream that is no valid standard stream: a folder, a disk, or no file at
/// all.
fn invalid_kind(stream: &OwnedFd) -> Option<String> {
    let kind = match fstat(stream) {
        Ok(stat) => FileType::from_raw_mode(stat.st_mode),
        Err(error) => return Some(format!("of no kind ({error})")),
    };
    let usual = [
        FileType::RegularFile,
        FileType::Fifo,
        FileType::Socket,
        FileType::CharacterDevice,
    ];
    (!usual.contains(&kind)).then(|| format!("{kind:?}"))
}

/// Returns `atas` from the folder of this program, with the client's arguments and streams, and
/// nothing else of the client.
fn command_of(request: Request, streams: [OwnedFd; STREAMS]) -> io::Result<Command> {
    let [stdin, stdout, stderr] = streams;
    let mut command = Command::new(std::env::current_exe()?.with_file_name("atas"));
    command
        .args(request.arguments)
        .env_clear()
        .envs(request.environment)
        .current_dir("/")
        .stdin(stdin)
        .stdout(stdout)
        .stderr(stderr);
    // Folder of this user's buses: from the service's environment, not the client's.
    if let Some(folder) = std::env::var_os("XDG_RUNTIME_DIR") {
        command.env("XDG_RUNTIME_DIR", folder);
    }
    atas_gate::isolate(&mut command);
    Ok(command)
}

/// Forwards the client's signals until the command ends. If the client disconnects, the command is
/// killed.
fn supervise(visitor: &OwnedFd, mut child: Child, streams: Command) -> anyhow::Result<()> {
    // The streams belong to the command: their readers must see the end of file.
    drop(streams);
    let pid = Pid::from_child(&child);
    let ended = pidfd_open(pid, PidfdFlags::empty()).context("could not watch the command")?;
    let mut received = message::reply(visitor, &Reply::Started).is_ok();
    while received {
        let mut events = [
            PollFd::new(&ended, PollFlags::IN),
            PollFd::new(visitor, PollFlags::IN),
        ];
        match poll(&mut events, None) {
            Err(rustix::io::Errno::INTR) => continue,
            waited => waited.context("could not wait for the command")?,
        };
        if !events[0].revents().is_empty() {
            break;
        }
        received = match signal(visitor) {
            Some(signal) => kill_process_group(pid, signal).is_ok(),
            None => false,
        };
    }
    if !received {
        // It may have ended meanwhile.
        let _ = kill_process_group(pid, Signal::KILL);
    }
    let status = child
        .wait()
        .context("could not read the exit status of the command")?;
    let end = match (status.code(), status.signal()) {
        (Some(code), _) => Reply::Ended(u8::try_from(code).unwrap_or(u8::MAX)),
        (None, signal) => Reply::Killed(
            signal.ok_or_else(|| anyhow!("the command neither exited nor was killed"))?,
        ),
    };
    // The client may be gone.
    let _ = message::reply(visitor, &end);
    Ok(())
}

/// Returns the next signal from the client; `None` if it disconnected or sent something else.
fn signal(visitor: &OwnedFd) -> Option<Signal> {
    let mut packet = [0; 2];
    let (_, bytes) =
        rustix::io::retry_on_intr(|| recv(visitor, &mut packet, RecvFlags::empty())).ok()?;
    let known = |signal: &&Signal| bytes == 1 && signal.as_raw() == i32::from(packet[0]);
    SIGNALS.iter().find(known).copied()
}

/// Identity of the client, for the log.
struct Identity<'a>(&'a UnixCredentials);

impl std::fmt::Display for Identity<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let uid = self.0.uid();
        match User::from_uid(Uid::from_raw(uid)) {
            Ok(Some(user)) => write!(f, "{} (uid {uid})", user.name),
            _ => write!(f, "uid {uid}"),
        }
    }
}
