//! Server near the daemon: accepts connections and serves each in a thread.
//!
//! The main thread only accepts and counts. A connection that has not proved its certificate waits
//! in a bounded list, from which newer connections displace it.

mod admission;
mod command;
mod config;
mod connection;
mod decision;

use std::io;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use atas_console::{Exit, ExitError, Interrupt};
use rustix::event::{PollFd, PollFlags};

use crate::{link, tls};
use admission::Admission;
use config::Config;

pub(crate) use config::{is_client_name, toml_error};
pub(crate) use decision::local_reason;

/// Longest time until the server notices a signal.
const POLL: Duration = Duration::from_millis(100);
/// Pause after a failure of the machine (no descriptors, no memory), which would repeat at once.
const PAUSE: Duration = Duration::from_millis(50);

/// State that all connections share.
pub(crate) struct Server {
    /// File of the configuration; each connection reads it again.
    file: PathBuf,
    /// Configuration at the start.
    config: Config,
    tls: Arc<rustls::ServerConfig>,
    admission: Admission,
}

/// Serves until a signal. The end of the process kills all commands.
pub(crate) fn serve(file: &Path, interrupt: &Interrupt) -> anyhow::Result<()> {
    let config = Config::read(file)?;
    let listener = listen(config.listen)?;
    let address = listener.local_addr().unwrap_or(config.listen);
    let server = Arc::new(Server {
        file: file.to_owned(),
        tls: tls::server(config::files(&config.tls()))?,
        admission: Admission::new(config.connections),
        config,
    });
    tracing::info!(
        "serves bus {} to clients with a certificate on {address}",
        server.config.bus
    );
    while !interrupt.is_set() {
        let mut events = [PollFd::new(&listener, PollFlags::IN)];
        link::wait(&mut events, POLL).context("could not wait for connections")?;
        match listener.accept() {
            Ok((socket, peer)) => start(&server, socket, peer),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
            Err(error) => {
                tracing::warn!("could not accept a connection because of: {error}");
                std::thread::sleep(PAUSE);
            }
        }
    }
    tracing::info!("ends; the commands of its clients end with it");
    Ok(())
}

fn listen(address: SocketAddr) -> anyhow::Result<TcpListener> {
    let listener = TcpListener::bind(address).map_err(|error| {
        let exit = match error.kind() {
            io::ErrorKind::AddrInUse => Exit::InUse,
            _ => Exit::Failed,
        };
        ExitError::with_code(exit, format!("could not listen on {address}: {error}"))
    })?;
    listener
        .set_nonblocking(true)
        .context("could not prepare the socket")?;
    Ok(listener)
}

/// Starts the thread of a connection.
fn start(server: &Arc<Server>, socket: TcpStream, peer: SocketAddr) {
    let entry = match server.admission.enter(&socket, peer) {
        Ok(entry) => entry,
        Err(error) => {
            tracing::warn!("could not admit {peer} because of: {error}");
            return;
        }
    };
    let shared = Arc::clone(server);
    let thread = std::thread::Builder::new()
        .name("connection".into())
        .spawn(move || connection::serve(&shared, socket, peer, entry));
    if let Err(error) = thread {
        tracing::warn!("could not serve {peer} because of: {error}");
    }
}
