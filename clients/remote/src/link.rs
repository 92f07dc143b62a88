//! Connection with TLS and frames. It never blocks: callers wait with `poll` and a deadline.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustls::pki_types::ServerName;
use rustls::{ClientConfig, ClientConnection, Connection, ServerConfig, ServerConnection};

use crate::frame::{CLIENT_MAX, Decoder, Frame, FrameError, Kind, SERVER_MAX, encode};

/// Longest wait for the end of a connection after the last message. Design choice: a peer reads the
/// reason of a rejection meanwhile.
const FAREWELL: Duration = Duration::from_millis(500);
/// Signs of life per longest silence. Design choice: three may be late or lost.
const SIGNS: u32 = 4;

/// Failure of a connection.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LinkError {
    /// The peer closed the connection.
    #[error("the other side closed the connection")]
    Closed,
    /// No answer within the limit.
    #[error("no answer within {:.1} s", .0.as_secs_f64())]
    Silent(Duration),
    /// The peer violated the protocol of frames.
    #[error("invalid data: {0}")]
    Frame(#[from] FrameError),
    /// TLS rejected the peer, or the peer rejected this side.
    #[error("{}", crate::tls::error_text(.0))]
    Tls(#[from] rustls::Error),
    /// The kernel reports a failure.
    #[error("{0}")]
    Io(#[from] io::Error),
}

/// Connection with one peer.
pub(crate) struct Link {
    tls: Connection,
    socket: TcpStream,
    decoder: Decoder,
    heard: Instant,
    sent: Instant,
    has_ended: bool,
}

impl Link {
    /// Begins the client's side.
    pub(crate) fn connect(
        socket: TcpStream,
        config: &Arc<ClientConfig>,
        name: ServerName<'static>,
    ) -> Result<Self, LinkError> {
        let tls = ClientConnection::new(Arc::clone(config), name)?;
        Self::new(socket, tls.into(), SERVER_MAX)
    }

    /// Begins the server's side.
    pub(crate) fn accept(socket: TcpStream, config: &Arc<ServerConfig>) -> Result<Self, LinkError> {
        let tls = ServerConnection::new(Arc::clone(config))?;
        Self::new(socket, tls.into(), CLIENT_MAX)
    }

    fn new(socket: TcpStream, tls: Connection, limit: usize) -> Result<Self, LinkError> {
        socket.set_nonblocking(true)?;
        socket.set_nodelay(true)?;
        Ok(Self {
            tls,
            socket,
            decoder: Decoder::new(limit),
            heard: Instant::now(),
            sent: Instant::now(),
            has_ended: false,
        })
    }

    /// Returns the TLS state, for certificates.
    pub(crate) fn tls(&self) -> &Connection {
        &self.tls
    }

    /// Completes the handshake.
    pub(crate) fn handshake(&mut self, until: Instant) -> Result<(), LinkError> {
        let begin = Instant::now();
        loop {
            self.flush()?;
            if !self.tls.is_handshaking() {
                return Ok(());
            }
            self.wait_until(until, begin)?;
            self.receive()?;
        }
    }

    /// Waits for the next frame.
    pub(crate) fn wait_frame(&mut self, until: Instant) -> Result<Frame, LinkError> {
        let begin = Instant::now();
        loop {
            if let Some(frame) = self.next_frame()? {
                return Ok(frame);
            }
            self.wait_until(until, begin)?;
            self.flush()?;
            self.receive()?;
        }
    }

    fn wait_until(&self, until: Instant, begin: Instant) -> Result<(), LinkError> {
        if self.has_ended {
            return Err(LinkError::Closed);
        }
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(LinkError::Silent(begin.elapsed()));
        }
        let mut events = [PollFd::new(&self.socket, self.events(true))];
        wait(&mut events, left)?;
        Ok(())
    }

    /// Events to wait for; without `reading`, the peer must wait.
    pub(crate) fn events(&self, reading: bool) -> PollFlags {
        let mut events = PollFlags::empty();
        events.set(PollFlags::IN, reading && !self.has_ended);
        events.set(PollFlags::OUT, self.tls.wants_write());
        events
    }

    /// Sends a frame, as far as the socket has space. Send pieces of output only without
    /// [`Self::has_backlog`].
    pub(crate) fn send(&mut self, kind: Kind, payload: &[u8]) -> Result<(), LinkError> {
        self.tls.writer().write_all(&encode(kind, payload))?;
        self.sent = Instant::now();
        self.flush()
    }

    /// Returns true while sent data waits for space in the socket.
    pub(crate) fn has_backlog(&self) -> bool {
        self.tls.wants_write()
    }

    /// Writes waiting data.
    pub(crate) fn flush(&mut self) -> Result<(), LinkError> {
        while self.tls.wants_write() {
            match self.tls.write_tls(&mut self.socket) {
                Ok(0) => return Err(LinkError::Closed),
                Ok(_) => {}
                Err(error) if is_temporary(&error) => return Ok(()),
                Err(error) => return Err(closed_or(error)),
            }
        }
        Ok(())
    }

    /// Reads what has arrived, up to the size of one frame.
    pub(crate) fn receive(&mut self) -> Result<(), LinkError> {
        while self.decoder.has_space() && !self.has_ended {
            match self.tls.read_tls(&mut self.socket) {
                Ok(0) => self.has_ended = true,
                Ok(_) => self.decrypt()?,
                Err(error) if is_temporary(&error) => return Ok(()),
                Err(error) => return Err(closed_or(error)),
            }
        }
        Ok(())
    }

    fn decrypt(&mut self) -> Result<(), LinkError> {
        let state = match self.tls.process_new_packets() {
            Ok(state) => state,
            Err(error) => {
                // Sends the alert that names the reason.
                let _ = self.flush();
                return Err(error.into());
            }
        };
        let mut plain = vec![0; state.plaintext_bytes_to_read()];
        self.tls.reader().read_exact(&mut plain)?;
        if !plain.is_empty() {
            self.heard = Instant::now();
        }
        self.decoder.push(&plain);
        self.has_ended |= state.peer_has_closed();
        Ok(())
    }

    /// Returns the next received frame.
    pub(crate) fn next_frame(&mut self) -> Result<Option<Frame>, LinkError> {
        match self.decoder.next_frame()? {
            None if self.has_ended => Err(LinkError::Closed),
            frame => Ok(frame),
        }
    }

    /// Sends a sign of life when it is due. Waiting data is a sign of life as well.
    pub(crate) fn keep_alive(&mut self, silence: Duration) -> Result<(), LinkError> {
        if self.sent.elapsed() >= silence / SIGNS && !self.has_backlog() {
            self.send(Kind::Alive, &[])?;
        }
        Ok(())
    }

    /// Fails if nothing has arrived for this time.
    pub(crate) fn check_silence(&self, silence: Duration) -> Result<(), LinkError> {
        if self.heard.elapsed() > silence {
            return Err(LinkError::Silent(silence));
        }
        Ok(())
    }

    /// Restarts the measurement of silence, after a time without reading.
    pub(crate) fn pardon_silence(&mut self) {
        self.heard = Instant::now();
    }

    /// Ends the connection. The peer reads the last message before the socket closes.
    pub(crate) fn close(mut self) {
        let until = Instant::now() + FAREWELL;
        self.tls.send_close_notify();
        while self.has_backlog() && self.flush().is_ok() {
            let mut events = [PollFd::new(&self.socket, PollFlags::OUT)];
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() || wait(&mut events, left).is_err() {
                return;
            }
        }
        // Unread data would make the kernel discard the message.
        let _ = self.socket.shutdown(Shutdown::Write);
        let mut rest = [0; 4096];
        loop {
            match self.socket.read(&mut rest) {
                Ok(1..) => {}
                Err(error) if is_temporary(&error) => {}
                _ => return,
            }
            let mut events = [PollFd::new(&self.socket, PollFlags::IN)];
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() || wait(&mut events, left).is_err() {
                return;
            }
        }
    }
}

impl AsFd for Link {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}

/// Time between two checks of silence and signs of life.
pub(crate) fn check_period(silence: Duration) -> Duration {
    silence / (2 * SIGNS)
}

/// Waits for events, at most the given time. A signal ends the wait.
pub(crate) fn wait(events: &mut [PollFd<'_>], most: Duration) -> io::Result<()> {
    let most = Timespec::try_from(most).unwrap_or(Timespec {
        tv_sec: 1,
        tv_nsec: 0,
    });
    match poll(events, Some(&most)) {
        Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
        Err(error) => Err(error.into()),
    }
}

fn is_temporary(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted
    )
}

fn closed_or(error: io::Error) -> LinkError {
    match error.kind() {
        io::ErrorKind::ConnectionReset | io::ErrorKind::BrokenPipe => LinkError::Closed,
        _ => error.into(),
    }
}
