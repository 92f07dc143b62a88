//! Client: runs a command at a server and represents it on this machine.

mod check;
mod config;
mod fetch;
mod relay;
mod stop;
mod words;

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use atas_console::arguments::{Arguments, Command, Recordings, RemoteAction};
use atas_console::{Exit, ExitError, Interrupt, Output};

use crate::frame::Kind;
use crate::link::{Link, LinkError};
use crate::message::{Reply, Request, Work};
use crate::server::local_reason;
use config::Target;
use relay::{End, Streams};

/// Longest time to connect and to get the first reply. Design choice: several round trips around
/// the earth, with a lost packet.
const CONNECT: Duration = Duration::from_secs(5);

/// Runs the command of `--remote`.
pub(crate) fn run(
    arguments: &Arguments,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let find = || Target::find(&arguments.remote);
    let words = || words::without_selection(std::env::args_os().skip(1));
    match &arguments.command {
        Command::Remote {
            action: RemoteAction::Check { count },
        } => return check::check(&find()?, *count, output),
        Command::Estop(_) => return stop::stop(&arguments.remote, words()?, output),
        Command::Recordings {
            action:
                Recordings::Fetch {
                    name,
                    out,
                    folder: None,
                    stdout: false,
                },
        } => return fetch::fetch(&find()?, name, out.as_deref(), interrupt, output),
        _ => {}
    }
    if let Some(why) = local_reason(arguments) {
        return Err(ExitError::with_code(Exit::Usage, why));
    }
    let target = find()?;
    let end = relay::run(&target, words()?, Streams::standard(), interrupt)?;
    exit(&end, &target)
}

/// Ends this process as the command ended.
fn exit(end: &End, target: &Target) -> anyhow::Result<()> {
    match end {
        End::Code(code) => std::process::exit((*code).into()),
        End::OutputClosed => Ok(()),
        End::Killed(signal) => Err(anyhow::anyhow!(
            "signal {signal} ended the command at {}",
            target.label
        )),
    }
}

/// Connects and completes the handshake.
fn connect(target: &Target, until: Instant) -> Result<Link, LinkError> {
    let socket = connect_socket(&target.address, until)?;
    let mut link = Link::connect(socket, &target.tls, target.name.clone())?;
    link.handshake(until)?;
    Ok(link)
}

/// Connects to the first address that answers.
fn connect_socket(address: &str, until: Instant) -> io::Result<TcpStream> {
    let mut last = io::Error::new(io::ErrorKind::NotFound, "the name has no address");
    for address in address.to_socket_addrs()? {
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            break;
        }
        match TcpStream::connect_timeout(&address, left) {
            Ok(socket) => return Ok(socket),
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// Connects, sends the request and returns the first reply.
fn request(target: &Target, work: Work, until: Instant) -> Result<(Link, Reply), LinkError> {
    let mut link = connect(target, until)?;
    let bytes = serde_json::to_vec(&Request::new(work)).map_err(io::Error::from)?;
    link.send(Kind::Request, &bytes)?;
    let reply = read_reply(&link.wait_frame(until)?.payload)?;
    Ok((link, reply))
}

fn read_reply(payload: &[u8]) -> Result<Reply, LinkError> {
    Ok(serde_json::from_slice(payload).map_err(io::Error::from)?)
}

/// Error of a connection that could not begin.
fn connect_error(target: &Target, error: &LinkError) -> anyhow::Error {
    let exit = match error {
        LinkError::Tls(_) => Exit::Refused,
        _ => Exit::NoDaemon,
    };
    let label = &target.label;
    let sentence = format!("could not connect to {label}: {error}");
    ExitError::with_code(exit, sentence)
}

/// Error of a reply other than the expected one.
fn unexpected(reply: Reply) -> anyhow::Error {
    match reply {
        Reply::Refused { exit, reason } | Reply::Failed { exit, reason } => {
            let known = Exit::ALL.into_iter().find(|known| known.code() == exit);
            ExitError::with_code(known.unwrap_or(Exit::Failed), reason)
        }
        other => anyhow::anyhow!(
            "unexpected reply {other:?}; install the same version of ATAS on both machines"
        ),
    }
}
