//! One connection: handshake, request, decision, command.

use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use anyhow::anyhow;
use atas_console::arguments::Right;
use atas_console::{Exit, estop, exit_of};
use rustls::Connection;

use super::admission::{Entry, PER_CLIENT, Place};
use super::config::Config;
use super::decision::decide;
use super::{Server, command};
use crate::frame::Kind;
use crate::link::{Link, LinkError};
use crate::message::{ClientRight, Reply, Request, Work, send_reply};
use crate::tls;

/// Longest time from the first byte to the complete request. Design choice: several round trips
/// around the earth, with a lost packet.
const REQUEST: Duration = Duration::from_secs(5);
/// Pause between two attempts to get a place for a stop.
const STOP_POLL: Duration = Duration::from_millis(5);
/// Longest command text in the log, characters.
const LOGGED: usize = 200;

/// Rejection: exit code of the client, and reason.
type Refusal = (Exit, String);

/// Client after its handshake.
struct Client {
    name: String,
    right: ClientRight,
    config: Config,
    /// Reason to permit a stop only.
    stop_only: Option<String>,
}

/// Serves a connection to its end.
pub(super) fn serve(server: &Server, socket: TcpStream, peer: SocketAddr, entry: Entry) {
    let mut link = match Link::accept(socket, &server.tls) {
        Ok(link) => link,
        Err(error) => return tracing::warn!("{peer} was refused: {error}"),
    };
    let until = Instant::now() + REQUEST;
    if let Err(error) = link.handshake(until) {
        tracing::warn!("{peer} was refused: {error}");
        // The client reads the reason meanwhile.
        return link.close();
    }
    let served = converse(server, &mut link, peer, entry, until);
    match served {
        Ok(()) => link.close(),
        Err(error) => tracing::warn!("{peer}: {error}"),
    }
}

/// Answers the request. The error is a failure of the connection.
fn converse(
    server: &Server,
    link: &mut Link,
    peer: SocketAddr,
    entry: Entry,
    until: Instant,
) -> Result<(), LinkError> {
    let client = identify(server, link);
    let client = match client {
        Ok(client) => client,
        Err(refusal) => {
            // Reads the request first, so that the client reads the reply.
            link.wait_frame(until)?;
            return refuse(link, peer, "unknown client", refusal);
        }
    };
    let frame = link.wait_frame(until)?;
    let request = match frame.kind {
        Kind::Request => Request::parse(&frame.payload),
        kind => Err(format!("a frame of kind {kind:?} came before the request")),
    };
    let done = request
        .map_err(|why| (Exit::Refused, why))
        .and_then(|request| prepare(server, &client, request.work, until));
    drop(entry);
    match done {
        Err(refusal) => refuse(link, peer, &client.name, refusal),
        Ok((work, _place)) => {
            tracing::info!("{} ({peer}) {}", client.name, work.text());
            work.execute(link, &client)
        }
    }
}

fn refuse(
    link: &mut Link,
    peer: SocketAddr,
    name: &str,
    (exit, reason): Refusal,
) -> Result<(), LinkError> {
    tracing::warn!("{name} ({peer}) was refused: {reason}");
    let (exit, reason) = (exit.code(), format!("rejected by the server: {reason}"));
    send_reply(link, &Reply::Refused { exit, reason })
}

/// Returns the client of the certificate, with its present right.
fn identify(server: &Server, link: &Link) -> Result<Client, Refusal> {
    let names = match link.tls() {
        Connection::Server(tls) => tls.peer_certificates().and_then(<[_]>::first),
        Connection::Client(_) => None,
    };
    let names = names.map(tls::names).unwrap_or_default();
    // A changed right takes effect at once. Without a valid file, the former clients may stop.
    let (config, stop_only) = match Config::read(&server.file) {
        Ok(config) => (config, None),
        Err(error) => (server.config.clone(), Some(error.to_string())),
    };
    let Some((name, right)) = config.client(&names) else {
        let names = names.join(", ");
        let reason = format!(
            "the server's configuration does not list client {names:?}; add it under [clients]"
        );
        return Err((Exit::Refused, reason));
    };
    Ok(Client {
        name: name.to_owned(),
        right,
        stop_only,
        config,
    })
}

/// Work that was permitted.
enum Permitted {
    Check,
    Stop,
    Command(Vec<String>),
}

/// Checks right and place of a request.
fn prepare(
    server: &Server,
    client: &Client,
    work: Work,
    until: Instant,
) -> Result<(Permitted, Place), Refusal> {
    let refused = |why: String| (Exit::Refused, why);
    let words = match work {
        Work::Check => {
            let place = server.admission.place(&client.name);
            return place
                .map(|place| (Permitted::Check, place))
                .ok_or_else(|| refused(full_text(client)));
        }
        Work::Run(words) => words,
    };
    let decision =
        decide(words, &client.config.bus, client.config.recordings()).map_err(refused)?;
    check_right(client, decision.right).map_err(refused)?;
    if decision.right == Right::Stop {
        let place = wait_for_stop_place(server, until).map_err(refused)?;
        return Ok((Permitted::Stop, place));
    }
    let place = server.admission.place(&client.name);
    let place = place.ok_or_else(|| refused(full_text(client)))?;
    Ok((Permitted::Command(decision.arguments), place))
}

/// Waits for one of the places for stops: each of them is in use for a moment only.
fn wait_for_stop_place(server: &Server, until: Instant) -> Result<Place, String> {
    loop {
        if let Some(place) = server.admission.stop_place() {
            return Ok(place);
        }
        if Instant::now() >= until {
            return Err("too many stops are in progress; each of them stops the robot".into());
        }
        std::thread::sleep(STOP_POLL);
    }
}

fn check_right(client: &Client, needed: Right) -> Result<(), String> {
    if let Some(why) = client.stop_only.as_ref().filter(|_| needed != Right::Stop) {
        return Err(format!("{why}; until it is corrected, only a stop passes"));
    }
    let granted = client.right.right();
    if granted < needed {
        let name = &client.name;
        return Err(format!(
            "client {name} has the right \"{granted}\", this command needs \"{needed}\"; the \
             server's configuration sets it under [clients]"
        ));
    }
    Ok(())
}

fn full_text(client: &Client) -> String {
    format!(
        "could not start because all connections are in use: {} of all clients, or {PER_CLIENT} of \
         this client; end a command (a stop always passes)",
        client.config.connections
    )
}

impl Permitted {
    /// Text for the log.
    fn text(&self) -> String {
        match self {
            Self::Check => "checks the connection".into(),
            Self::Stop => "stops the robot".into(),
            Self::Command(words) => {
                let line: String = words.join(" ").chars().take(LOGGED).collect();
                format!("runs {:?}", format!("atas {line}"))
            }
        }
    }

    fn execute(self, link: &mut Link, client: &Client) -> Result<(), LinkError> {
        match self {
            Self::Check => check(link, client),
            Self::Stop => {
                let done = match estop::stop(&client.config.bus) {
                    Ok(channel) => Reply::Stopped(channel.name().to_owned()),
                    Err(error) => Reply::Failed {
                        exit: exit_of(&error).code(),
                        reason: format!("{error:#}"),
                    },
                };
                send_reply(link, &done)
            }
            Self::Command(words) => command::run(link, words, &client.config),
        }
    }
}

/// Reports the right, then sends echoes back until the client closes.
fn check(link: &mut Link, client: &Client) -> Result<(), LinkError> {
    let checked = Reply::Checked {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        client: client.name.clone(),
        right: client.right.right().to_string(),
    };
    send_reply(link, &checked)?;
    let silence = client.config.silence();
    loop {
        match link.wait_frame(Instant::now() + silence) {
            Ok(frame) if frame.kind == Kind::Echo && !link.has_backlog() => {
                link.send(Kind::Echo, &frame.payload)?;
            }
            Ok(frame) => {
                let text = anyhow!("unexpected frame of kind {:?}", frame.kind);
                return Err(std::io::Error::other(text).into());
            }
            Err(LinkError::Closed) => return Ok(()),
            Err(error) => return Err(error),
        }
    }
}
