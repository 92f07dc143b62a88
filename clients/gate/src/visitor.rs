//! The caller's side: a command whose bus is another user's is run by the gate, and this process stands for it.

use std::io::{self, Write};
use std::os::fd::{AsFd, OwnedFd};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use atas_console::arguments::{Access, Command};
use atas_console::{Ended, Exit};
use rustix::net::sockopt::{Timeout, set_socket_timeout};
use rustix::net::{
    AddressFamily, RecvFlags, SendFlags, SocketAddrUnix, SocketFlags, SocketType, connect, recv,
    send, socket_with,
};
use rustix::termios::{OptionalActions, Termios, tcgetattr, tcsetattr};
use shm_bus::{Bus, BusError};
use signal_hook::consts::SIGTSTP;
use signal_hook::iterator::Signals;

use crate::message::{self, Reply, Request};
use crate::missing;

/// How long the gate may take to begin (ours: many times what it takes; systemd may have to start it).
const BEGIN: Duration = Duration::from_secs(5);
/// How long to ask again while all places of this user are taken, and the first pause, which doubles up to the longest: a
/// crowd that asks again at once would be in its own way. Ours.
const BUSY: Duration = Duration::from_secs(5);
const PAUSES: [Duration; 2] = [Duration::from_millis(10), Duration::from_millis(320)];

/// Where the command's bus is another user's, hands it over to the gate and ends this process with its exit code. Returns if
/// the command runs as whoever calls it.
///
/// # Errors
/// Why the gate cannot be reached or refuses, with what is missing.
pub fn pass(command: &Command) -> anyhow::Result<()> {
    let (bus, kept) = match command.access() {
        Access::Caller => return Ok(()),
        Access::Right(_, bus) => (bus, None),
        Access::Owner(bus, why) => (bus, Some(why)),
    };
    let found = Bus::find(bus);
    let Err(elsewhere @ BusError::OtherUser { bus, place, .. }) = &found else {
        // Here, nowhere, or not fit to be used: the command itself says so.
        return Ok(());
    };
    if let Some(why) = kept {
        let memory = place.file_name().unwrap_or_default().to_string_lossy();
        if !memory.starts_with(&format!("{bus}_")) {
            // Of the other user's bus there is but the folder: the command may make its own, or await one.
            return Ok(());
        }
        let sentence =
            format!("{elsewhere}; the gate does not run this command for others because it {why}");
        return Err(Ended::with(Exit::NoDaemon, sentence));
    }
    let path = missing::socket();
    let closed = |error: &io::Error| {
        let missing = missing::sentence(&path, error);
        Ended::with(Exit::NoDaemon, format!("{elsewhere}; {missing}"))
    };
    let request = request()?;
    let terminal = tcgetattr(io::stdin()).ok();
    let (asked, mut pause) = (Instant::now(), PAUSES[0]);
    loop {
        let socket = knock(&path).map_err(|error| closed(&error))?;
        let (stdin, stdout, stderr) = (io::stdin(), io::stdout(), io::stderr());
        // A gate whose places are taken answers before it is asked; the answer says so.
        let sent = message::ask(
            &socket,
            &request,
            [stdin.as_fd(), stdout.as_fd(), stderr.as_fd()],
        );
        if sent.is_err_and(|error| error.kind() == io::ErrorKind::ArgumentListTooLong) {
            let sentence = "could not pass the gate because the command line is too long";
            return Err(Ended::with(Exit::Usage, sentence));
        }
        match hear(&socket) {
            Ok(Some(Reply::Busy(_))) if asked.elapsed() < BUSY => {
                std::thread::sleep(pause);
                pause = PAUSES[1].min(2 * pause);
            }
            Ok(Some(Reply::Started)) => {
                set_socket_timeout(&socket, Timeout::Recv, None)
                    .context("could not wait for the gate")?;
                stand_for(socket, terminal)
            }
            Ok(Some(answer)) => return Err(refusal(answer)),
            Ok(None) => return Err(closed(&io::ErrorKind::ConnectionReset.into())),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                let silent = format!("it did not answer within {BEGIN:?}");
                return Err(closed(&io::Error::new(io::ErrorKind::TimedOut, silent)));
            }
            Err(error) => return Err(closed(&error)),
        }
    }
}

/// This command line, and what the gate takes of this environment.
fn request() -> anyhow::Result<Request> {
    let word = |word: std::ffi::OsString| {
        word.into_string().map_err(|word| {
            anyhow!(
                "could not pass the gate because {} is not UTF-8",
                word.display()
            )
        })
    };
    let variable = |name: &&str| Some(((*name).to_owned(), std::env::var(name).ok()?));
    Ok(Request {
        arguments: std::env::args_os()
            .skip(1)
            .map(word)
            .collect::<Result<_, _>>()?,
        environment: message::WORDS
            .iter()
            .filter_map(variable)
            .filter(|(name, value)| Request::takes(name, value))
            .collect(),
    })
}

fn knock(path: &Path) -> io::Result<OwnedFd> {
    let socket = socket_with(
        AddressFamily::UNIX,
        SocketType::SEQPACKET,
        SocketFlags::CLOEXEC,
        None,
    )?;
    set_socket_timeout(&socket, Timeout::Send, Some(BEGIN))?;
    set_socket_timeout(&socket, Timeout::Recv, Some(BEGIN))?;
    connect(&socket, &SocketAddrUnix::new(path)?)?;
    Ok(socket)
}

/// The gate's next word; `None` if it is gone.
fn hear(socket: &OwnedFd) -> io::Result<Option<Reply>> {
    let mut packet = [0; 4096];
    let mut receive =
        || rustix::io::retry_on_intr(|| recv(socket, &mut packet, RecvFlags::empty()));
    // Whoever goes without having read everything resets the connection; what it said before is heard after that.
    let (_, bytes) = match receive() {
        Err(rustix::io::Errno::CONNRESET) => receive()?,
        received => received?,
    };
    if bytes == 0 {
        return Ok(None);
    }
    Ok(Some(serde_json::from_slice(&packet[..bytes])?))
}

fn refusal(reply: Reply) -> anyhow::Error {
    match reply {
        Reply::Refused(sentence) => Ended::with(Exit::Refused, sentence),
        Reply::Busy(places) => Ended::with(
            Exit::Refused,
            format!(
                "could not begin because this user runs {places} commands through the gate already; end one (a stop always gets through)"
            ),
        ),
        other => anyhow!(
            "could not understand the gate, which said {other:?}; install `atas` and `atas-gate` of one version"
        ),
    }
}

/// Passes signals on until the command ends, and ends as it ended.
fn stand_for(socket: OwnedFd, terminal: Option<Termios>) -> ! {
    let socket = Arc::new(socket);
    if let Err(error) = relay(Arc::clone(&socket)) {
        tracing::warn!("could not listen to signals because of: {error}");
    }
    let (code, lost) = match hear(&socket) {
        Ok(Some(Reply::Ended(code))) => (i32::from(code), None),
        // The shells' convention.
        Ok(Some(Reply::Killed(signal))) => (
            128 + signal,
            Some(format!("signal {signal} ended the command at the gate")),
        ),
        _ => {
            let why = "could not hear the end of the command because the gate is gone; see `journalctl -u atas-gate`";
            (Exit::NoDaemon as i32, Some(why.to_owned()))
        }
    };
    if let Some(why) = lost {
        restore(terminal);
        let _ = writeln!(io::stderr(), "atas: {why}");
    }
    std::process::exit(code)
}

/// Signals to this process are the command's, but for Ctrl-Z, which is nobody's.
fn relay(socket: Arc<OwnedFd>) -> io::Result<()> {
    let numbers = message::SIGNALS.map(rustix::process::Signal::as_raw);
    let mut signals = Signals::new(numbers.iter().chain(&[SIGTSTP]))?;
    std::thread::Builder::new()
        .name("signals".into())
        .spawn(move || {
            for signal in signals.forever().filter(|signal| *signal != SIGTSTP) {
                // Whoever is gone needs no signal.
                let _ = send(&*socket, &[signal as u8], SendFlags::NOSIGNAL);
            }
        })?;
    Ok(())
}

/// Gives the terminal back after a command that could not: as it was, out of the second screen, with a cursor.
fn restore(terminal: Option<Termios>) {
    let Some(before) = terminal else { return };
    let changed = tcgetattr(io::stdin()).is_ok_and(|now| now.local_modes != before.local_modes);
    if changed {
        let _ = tcsetattr(io::stdin(), OptionalActions::Now, &before);
        let _ = io::stdout().write_all(b"\x1b[?1049l\x1b[?25h");
        let _ = io::stdout().flush();
    }
}
