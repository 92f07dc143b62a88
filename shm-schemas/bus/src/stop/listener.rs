//! The daemon's side.

use std::fs::{self, Permissions};
use std::io::{self, IoSliceMut};
use std::mem::MaybeUninit;
use std::net::Shutdown;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::UnixDatagram;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendFlags, SocketAddrAny, recvmsg,
    sendto, sockopt::set_socket_passcred,
};
use shm_schemas::{Stamp, StopAnswer, StopOutcome, StopRequest, Text};
use zerocopy::{FromZeros, IntoBytes};

use super::STOP_SOCKET;
use super::signal::Signal;
use crate::clock::{now_ns, writer_epoch};
use crate::error::BusError;
use crate::owner::OwnerLock;
use crate::user::uid;

/// How long a tick may take to take a stop before the answer says that it waits. Ours: twenty ticks.
const TAKEN_WITHIN: Duration = Duration::from_millis(20);
/// How often to look whether a tick took it.
const POLL: Duration = Duration::from_micros(200);

/// Receives stops, in a thread that does nothing else.
///
/// ```no_run
/// # fn f(owner: &shm_bus::OwnerLock) -> Result<(), shm_bus::BusError> {
/// let listener = std::sync::Arc::new(shm_bus::stop::Listener::open(owner)?);
/// let signal = listener.signal(); // for the tick: pending(), stop, take()
/// let server = std::sync::Arc::clone(&listener);
/// let thread = std::thread::spawn(move || server.serve(|heard| { /* tell the log, without waiting */ }));
/// listener.close();
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct Listener {
    socket: UnixDatagram,
    path: PathBuf,
    signal: Arc<Signal>,
    writer_epoch: u64,
    closed: AtomicBool,
}

/// A stop that was received, and is with the tick already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heard {
    /// Its number, from 1.
    pub number: u64,
    /// Process id of who asked; 0 if the kernel did not tell.
    pub pid: u32,
    /// Why; empty if it did not say.
    pub reason: Text<96>,
    /// Whether a tick took it.
    pub outcome: StopOutcome,
}

struct Datagram {
    request: Option<StopRequest>,
    pid: u32,
    sender: Option<SocketAddrAny>,
}

impl Listener {
    /// Opens the bus's stop socket. Only the owner of the bus can: so nobody else has it, and what is there is old.
    ///
    /// # Errors
    /// [`BusError::Io`] if the socket cannot be made.
    pub fn open(owner: &OwnerLock) -> Result<Self, BusError> {
        let path = owner.folder.path.join(STOP_SOCKET);
        let made = || -> io::Result<UnixDatagram> {
            match fs::remove_file(&path) {
                Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
                _ => {}
            }
            let socket = UnixDatagram::bind(&path)?;
            fs::set_permissions(&path, Permissions::from_mode(0o600))?;
            set_socket_passcred(&socket, true)?;
            Ok(socket)
        };
        Ok(Self {
            socket: made().map_err(BusError::io("make the stop socket", &path))?,
            path,
            signal: Arc::default(),
            writer_epoch: writer_epoch(),
            closed: AtomicBool::new(false),
        })
    }

    /// What the tick looks at.
    #[must_use]
    pub fn signal(&self) -> Arc<Signal> {
        Arc::clone(&self.signal)
    }

    /// Hands every stop to the tick, answers it, and then tells `heard`; until [`Listener::close`].
    ///
    /// `heard` must not wait: while it does, the next stop is handed over late.
    pub fn serve(&self, mut heard: impl FnMut(Heard)) {
        while !self.closed.load(Ordering::Acquire) {
            // A failure leaves nothing to hand over; it is the next datagram's turn.
            let Ok(Some(datagram)) = self.receive() else {
                continue;
            };
            let (received_ns, number) = (now_ns(), self.signal.raise());
            let outcome = self.wait_until_taken(number);
            self.answer(&datagram, number, received_ns, outcome);
            heard(Heard {
                number,
                pid: datagram.pid,
                reason: datagram.request.map_or(Text::default(), |r| r.reason),
                outcome,
            });
        }
    }

    /// Ends [`Listener::serve`] in whatever thread it runs.
    pub fn close(&self) {
        self.closed.store(true, Ordering::Release);
        // Wakes the thread up; there is nothing to do if it fails.
        let _ = self.socket.shutdown(Shutdown::Both);
    }

    /// The next datagram; `None` for one of another user.
    fn receive(&self) -> io::Result<Option<Datagram>> {
        let mut request = StopRequest::new_zeroed();
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmCredentials(1))];
        let mut control = RecvAncillaryBuffer::new(&mut space);
        let (received, whole) = {
            let buffer = &mut [IoSliceMut::new(request.as_mut_bytes())];
            let received = recvmsg(&self.socket, buffer, &mut control, RecvFlags::empty())?;
            let whole = received.bytes == size_of::<StopRequest>();
            (received, whole)
        };
        let credentials = control.drain().find_map(|message| match message {
            RecvAncillaryMessage::ScmCredentials(credentials) => Some(credentials),
            _ => None,
        });
        let Some(credentials) = credentials else {
            return Ok(None);
        };
        let user = credentials.uid.as_raw();
        Ok((user == uid() || user == 0).then(|| Datagram {
            request: whole.then_some(request),
            pid: credentials.pid.as_raw_nonzero().get().unsigned_abs(),
            sender: received.address,
        }))
    }

    fn wait_until_taken(&self, number: u64) -> StopOutcome {
        let begin = Instant::now();
        while !self.signal.is_taken(number) {
            if begin.elapsed() >= TAKEN_WITHIN {
                return StopOutcome::WAITING;
            }
            std::thread::sleep(POLL);
        }
        StopOutcome::STOPPED
    }

    /// Never waits: a client that does not read its answer loses it.
    fn answer(&self, to: &Datagram, number: u64, received_ns: u64, outcome: StopOutcome) {
        let Some(sender) = &to.sender else { return };
        let answer = StopAnswer {
            stamp: Stamp {
                sequence: number,
                captured_ns: received_ns,
                writer_epoch: self.writer_epoch,
            },
            outcome,
            pid: std::process::id(),
        };
        let flags = SendFlags::DONTWAIT | SendFlags::NOSIGNAL;
        let _ = sendto(&self.socket, answer.as_bytes(), flags, sender);
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        // The next owner removes it otherwise.
        let _ = fs::remove_file(&self.path);
    }
}
