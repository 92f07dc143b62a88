//! One visit: hears the request, decides, runs the command on the visitor's streams, passes signals on, tells the end.

use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::PathBuf;
use std::process::{Child, Command};

use anyhow::{Context, anyhow};
use atas_console::arguments::{Access, Arguments, Right, command};
use atas_gate::message::{self, Reply, Request, SIGNALS, STREAMS};
use clap::FromArgMatches;
use nix::unistd::{Uid, User};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{FileType, fstat};
use rustix::net::sockopt::socket_peercred;
use rustix::net::{RecvFlags, UCred, recv};
use rustix::process::{
    Pid, PidfdFlags, Signal, geteuid, getppid, kill_process_group, pidfd_open,
    set_parent_process_death_signal, setsid,
};

use crate::door::PLACES;
use crate::rights;

/// How long a visitor may take to say what it wants. Ours: it has it ready.
const REQUEST: Timespec = Timespec {
    tv_sec: 2,
    tv_nsec: 0,
};
/// Most characters of a command in the log.
const LOGGED: usize = 200;

/// Receives the visitor on standard input.
pub(crate) fn receive(config: &[PathBuf], full: bool) -> anyhow::Result<()> {
    let visitor = io::stdin()
        .as_fd()
        .try_clone_to_owned()
        .context("could not use standard input")?;
    let from = socket_peercred(&visitor).context("could not ask who the visitor is")?;
    let mut asked = [PollFd::new(&visitor, PollFlags::IN)];
    if poll(&mut asked, Some(&REQUEST)).context("could not wait for the request")? == 0 {
        tracing::warn!("{} said nothing and was sent away", Named(&from));
        return Ok(());
    }
    let answer = match prepare(&visitor, &from, config, full) {
        Ok(mut prepared) => match prepared.spawn() {
            Ok(child) => return attend(&visitor, child, prepared),
            Err(error) => Reply::Refused(format!(
                "could not start `atas` at the gate because of: {error}"
            )),
        },
        Err(answer) => answer,
    };
    if let Reply::Refused(why) = &answer {
        tracing::warn!("{} was refused: {why:?}", Named(&from));
    }
    // A visitor that is gone needs no answer.
    let _ = message::reply(&visitor, &answer);
    Ok(())
}

/// What to run, or the answer to a visitor for whom nothing is run.
fn prepare(
    visitor: &OwnedFd,
    from: &UCred,
    config: &[PathBuf],
    full: bool,
) -> Result<Command, Reply> {
    let refused = |why: String| Reply::Refused(format!("could not pass the gate because {why}"));
    let (request, streams) = message::hear(visitor).map_err(refused)?;
    let right = right(&request).map_err(refused)?;
    if full && right != Right::Stop {
        return Err(Reply::Busy(PLACES));
    }
    if !is_master(from) {
        rights::check(right, &rights::granted_by(config)).map_err(Reply::Refused)?;
    }
    if let Some((name, _)) = request
        .environment
        .iter()
        .find(|(name, value)| !Request::takes(name, value))
    {
        return Err(refused(format!(
            "{name:?} of the environment is not handed over"
        )));
    }
    if let Some(kind) = streams.iter().find_map(strange) {
        return Err(refused(format!(
            "a standard stream is {kind}, needs to be a terminal, a pipe, a file or a socket"
        )));
    }
    let line: String = request.arguments.join(" ").chars().take(LOGGED).collect();
    tracing::info!("{} may {right}: {:?}", Named(from), format!("atas {line}"));
    let command = command_of(request, streams);
    command.map_err(|error| refused(format!("of: {error}")))
}

/// The right that the command needs, by the definition of the command line.
fn right(request: &Request) -> Result<Right, String> {
    if request.arguments.iter().any(|word| word.contains('\0')) {
        return Err("a word of the command line contains a zero byte".into());
    }
    let words = std::iter::once("atas").chain(request.arguments.iter().map(String::as_str));
    let parsed = command()
        .try_get_matches_from(words)
        .and_then(|matches| Arguments::from_arg_matches(&matches));
    let arguments = parsed.map_err(|_| "the command line is none that it knows".to_owned())?;
    match arguments.command.access() {
        Access::Right(right, _) => Ok(right),
        Access::Owner(_, why) => Err(format!("this command {why}; run it as the bus's user")),
        Access::Caller => Err("this command needs nobody else's bus; run it as yourself".into()),
    }
}

/// Whether the visitor may do as it likes without the gate: the bus's user, and root.
fn is_master(from: &UCred) -> bool {
    from.uid == geteuid() || from.uid.is_root()
}

/// What a stream is, if nobody would write there in earnest: folders, disks, what is no file at all.
fn strange(stream: &OwnedFd) -> Option<String> {
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

/// `atas` beside this program, with the visitor's words and streams, and nothing else of the visitor's.
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
    // Where this user's buses are; the service's own word, not the visitor's.
    if let Some(folder) = std::env::var_os("XDG_RUNTIME_DIR") {
        command.env("XDG_RUNTIME_DIR", folder);
    }
    let gate = Pid::from_raw(std::process::id().cast_signed());
    let alone = move || {
        // A session of its own: no controlling terminal, and a group that signals reach as a whole.
        setsid()?;
        set_parent_process_death_signal(Some(Signal::KILL))?;
        // A gate that died before that would send nothing any more.
        if getppid() == gate {
            Ok(())
        } else {
            Err(io::ErrorKind::BrokenPipe.into())
        }
    };
    // SAFETY: between fork and exec this makes three system calls and neither allocates nor takes a lock.
    unsafe { command.pre_exec(alone) };
    Ok(command)
}

/// Passes the visitor's signals on until the command ends; a visitor that goes away takes the command along.
fn attend(visitor: &OwnedFd, mut child: Child, streams: Command) -> anyhow::Result<()> {
    // The streams are the command's now: whoever reads them must hear their end.
    drop(streams);
    let pid = Pid::from_child(&child);
    let ended = pidfd_open(pid, PidfdFlags::empty()).context("could not watch the command")?;
    let mut heard = message::reply(visitor, &Reply::Started).is_ok();
    while heard {
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
        heard = match signal(visitor) {
            Some(signal) => kill_process_group(pid, signal).is_ok(),
            None => false,
        };
    }
    if !heard {
        // It may have ended meanwhile.
        let _ = kill_process_group(pid, Signal::KILL);
    }
    let status = child.wait().context("could not hear the command's end")?;
    let end = match (status.code(), status.signal()) {
        (Some(code), _) => Reply::Ended(u8::try_from(code).unwrap_or(u8::MAX)),
        (None, signal) => Reply::Killed(
            signal.ok_or_else(|| anyhow!("the command neither exited nor was killed"))?,
        ),
    };
    // A visitor that is gone needs no answer.
    let _ = message::reply(visitor, &end);
    Ok(())
}

/// The next signal that the visitor passes on; `None` if it is gone, or says something else.
fn signal(visitor: &OwnedFd) -> Option<Signal> {
    let mut packet = [0; 2];
    let (_, bytes) =
        rustix::io::retry_on_intr(|| recv(visitor, &mut packet, RecvFlags::empty())).ok()?;
    let known = |signal: &&Signal| bytes == 1 && signal.as_raw() == i32::from(packet[0]);
    SIGNALS.iter().find(known).copied()
}

/// Who it is, for the log.
struct Named<'a>(&'a UCred);

impl std::fmt::Display for Named<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let uid = self.0.uid.as_raw();
        match User::from_uid(Uid::from_raw(uid)) {
            Ok(Some(user)) => write!(f, "{} (uid {uid})", user.name),
            _ => write!(f, "uid {uid}"),
        }
    }
}
