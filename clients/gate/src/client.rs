//! Client side of the gate: the gate runs a command for the bus of another user, and this process
//! represents it.

use std::io::{self, Write};
use std::os::fd::{AsFd, OwnedFd};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use atas_console::arguments::{Access, Command};
use atas_console::{Exit, ExitError};
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

/// Longest wait for the start of the command. Design choice: many times the normal duration;
/// systemd may have to start the gate.
const START_TIMEOUT: Duration = Duration::from_secs(5);
/// Longest period of retries while all connections of this user are in use. The pause doubles up to
/// a limit, so that many waiting clients do not block each other. Design choice.
const BUSY_TIMEOUT: Duration = Duration::from_secs(5);
const PAUSES: [Duration; 2] = [Duration::from_millis(10), Duration::from_millis(320)];

/// If the bus of the command belongs to another user, passes it to the gate and ends this process
/// with its exit code. Returns if the command runs as the calling user.
///
/// # Errors
/// The gate is unreachable or rejects the command; the error names the missing permission.
pub fn run_through_gate(command: &Command) -> anyhow::Result<()> {
    let (bus, kept) = match command.access() {
        Access::Caller | Access::Recordings => return Ok(()),
        Access::Right(_, bus) => (bus, None),
        Access::Owner(bus, why) => (bus, Some(why)),
    };
    let found = Bus::find(bus);
    let Err(elsewhere @ BusError::OtherUser { bus, place, .. }) = &found else {
        // The command itself handles a local, missing or unusable bus.
        return Ok(());
    };
    if let Some(why) = kept {
        let memory = place.file_name().unwrap_or_default().to_string_lossy();
        if !memory.starts_with(&format!("{bus}_")) {
            // Only the folder of the other user's bus exists: the command may create a bus or wait
            // for one.
            return Ok(());
        }
        let sentence =
            format!("{elsewhere}; the gate does not run this command for other users: it {why}");
        return Err(ExitError::with_code(Exit::NoDaemon, sentence));
    }
    let path = missing::socket();
    let closed = |error: &io::Error| {
        let missing = missing::connection_error(&path, error);
        ExitError::with_code(Exit::NoDaemon, format!("{elsewhere}; {missing}"))
    };
    let request = request()?;
    let terminal = tcgetattr(io::stdin()).ok();
    let (asked, mut pause) = (Instant::now(), PAUSES[0]);
    loop {
        let socket = connect_to_gate(&path).map_err(|error| closed(&error))?;
        let (stdin, stdout, stderr) = (io::stdin(), io::stdout(), io::stderr());
        // A gate without free connections replies before the request; the reply states this.
        let sent = message::send_request(
            &socket,
            &request,
            [stdin.as_fd(), stdout.as_fd(), stderr.as_fd()],
        );
        if sent.is_err_and(|error| error.kind() == io::ErrorKind::ArgumentListTooLong) {
            let sentence = "rejected by the gate: the command line is too long";
            return Err(ExitError::with_code(Exit::Usage, sentence));
        }
        match receive_reply(&socket) {
            Ok(Some(Reply::Busy(_))) if asked.elapsed() < BUSY_TIMEOUT => {
                std::thread::sleep(pause);
                pause = PAUSES[1].min(2 * pause);
            }
            Ok(Some(Reply::Started)) => {
                set_socket_timeout(&socket, Timeout::Recv, None)
                    .context("could not wait for the gate")?;
                represent(socket, terminal)
            }
            Ok(Some(answer)) => return Err(refusal(answer)),
            Ok(None) => return Err(closed(&io::ErrorKind::ConnectionReset.into())),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                let silent = format!("no answer within {START_TIMEOUT:?}");
                return Err(closed(&io::Error::new(io::ErrorKind::TimedOut, silent)));
            }
            Err(error) => return Err(closed(&error)),
        }
    }
}

/// Returns this command line and the permitted environment variables.
fn request() -> anyhow::Result<Request> {
    let word = |word: std::ffi::OsString| {
        word.into_string()
            .map_err(|word| anyhow!("rejected by the gate: {} is not UTF-8", word.display()))
    };
    let variable = |name: &&str| Some(((*name).to_owned(), std::env::var(name).ok()?));
    Ok(Request {
        arguments: std::env::args_os()
            .skip(1)
            .map(word)
            .collect::<Result<_, _>>()?,
        environment: message::VARIABLES
            .iter()
            .filter_map(variable)
            .filter(|(name, value)| Request::is_permitted(name, value))
            .collect(),
    })
}

fn connect_to_gate(path: &Path) -> io::Result<OwnedFd> {
    let socket = socket_with(
        AddressFamily::UNIX,
        SocketType::SEQPACKET,
        SocketFlags::CLOEXEC,
        None,
    )?;
    set_socket_timeout(&socket, Timeout::Send, Some(START_TIMEOUT))?;
    set_socket_timeout(&socket, Timeout::Recv, Some(START_TIMEOUT))?;
    connect(&socket, &SocketAddrUnix::new(path)?)?;
    Ok(socket)
}

/// Returns the gate's next reply; `None` if it is gone.
fn receive_reply(socket: &OwnedFd) -> io::Result<Option<Reply>> {
    let mut packet = [0; 4096];
    let mut receive =
        || rustix::io::retry_on_intr(|| recv(socket, &mut packet, RecvFlags::empty()));
    // An end with unread data resets the connection; earlier replies are still readable afterwards.
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
        Reply::Refused(sentence) => ExitError::with_code(Exit::Refused, sentence),
        Reply::Busy(places) => ExitError::with_code(
            Exit::Refused,
            format!(
                "could not start because this user runs {places} commands through the gate \
                 already; end one (a stop always passes)"
            ),
        ),
        other => anyhow!(
            "unknown reply of the gate: {other:?}; install `atas` and `atas-gate` of one version"
        ),
    }
}

/// Forwards signals until the command ends, and ends with its exit code.
fn represent(socket: OwnedFd, terminal: Option<Termios>) -> ! {
    let socket = Arc::new(socket);
    if let Err(error) = relay(Arc::clone(&socket)) {
        tracing::warn!("could not handle signals because of: {error}");
    }
    let (code, lost) = match receive_reply(&socket) {
        Ok(Some(Reply::Ended(code))) => (i32::from(code), None),
        // Convention of shells.
        Ok(Some(Reply::Killed(signal))) => (
            128 + signal,
            Some(format!("signal {signal} ended the command at the gate")),
        ),
        _ => {
            let why = "lost the connection to the gate; see `journalctl -u atas-gate`";
            (Exit::NoDaemon as i32, Some(why.to_owned()))
        }
    };
    if let Some(why) = lost {
        restore(terminal);
        let _ = writeln!(io::stderr(), "atas: {why}");
    }
    std::process::exit(code)
}

/// Forwards signals to the command, except Ctrl-Z.
fn relay(socket: Arc<OwnedFd>) -> io::Result<()> {
    let numbers = message::SIGNALS.map(rustix::process::Signal::as_raw);
    let mut signals = Signals::new(numbers.iter().chain(&[SIGTSTP]))?;
    std::thread::Builder::new()
        .name("signals".into())
        .spawn(move || {
            for signal in signals.forever().filter(|signal| *signal != SIGTSTP) {
                // The receiver may be gone.
                let _ = send(&*socket, &[signal as u8], SendFlags::NOSIGNAL);
            }
        })?;
    Ok(())
}

/// Restores the terminal after a killed command: its mode, the main screen, the cursor.
fn restore(terminal: Option<Termios>) {
    let Some(before) = terminal else { return };
    let changed = tcgetattr(io::stdin()).is_ok_and(|now| now.local_modes != before.local_modes);
    if changed {
        let _ = tcsetattr(io::stdin(), OptionalActions::Now, &before);
        let _ = io::stdout().write_all(b"\x1b[?1049l\x1b[?25h");
        let _ = io::stdout().flush();
    }
}
