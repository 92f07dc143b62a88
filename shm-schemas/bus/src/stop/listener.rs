//! The daemon's side of the stop socket.

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

/// Time limit for a tick to take a stop; afterwards the answer is `WAITING`. Design choice: twenty
/// ticks at 1 kHz.
const TAKEN_TIMEOUT: Duration = Duration::from_millis(20);
/// Poll interval while waiting for the tick.
const POLL: Duration = Duration::from_micros(200);

/// Receives stops in a dedicated thread.
///
/// ```no_run
/// # fn f(owner: &shm_bus::OwnerLock) -> Result<(), shm_bus::BusError> {
/// let listener = std::sync::Arc::new(shm_bus::stop::Listener::open(owner)?);
/// let signal = listener.signal(); // for the tick: pending(), stop, take()
/// let server = std::sync::Arc::clone(&listener);
/// let thread = std::thread::spawn(move || server.serve(|stop| { /* log it without blocking */ }));
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

/// A received stop that the tick has been notified of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReceivedStop {
    /// Number, from 1.
    pub number: u64,
    /// Process id of the sender; 0 if the kernel did not report it.
    pub pid: u32,
    /// Reason given by the sender; empty if none.
    pub reason: Text<96>,
    /// Result: taken by a tick, or still waiting.
    pub outcome: StopOutcome,
}

struct Datagram {
    request: Option<StopRequest>,
    pid: u32,
    sender: Option<SocketAddrAny>,
}

impl Listener {
    /// Opens the bus's stop socket and replaces an old one. The owner lock guarantees that no other
    /// process uses it.
    ///
    /// # Errors
    /// [`BusError::Io`] if the socket cannot be created.
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
            socket: made().map_err(BusError::io("create the stop socket", &path))?,
            path,
            signal: Arc::default(),
            writer_epoch: writer_epoch(),
            closed: AtomicBool::new(false),
        })
    }

    /// The signal that the tick polls.
    #[must_use]
    pub fn signal(&self) -> Arc<Signal> {
        Arc::clone(&self.signal)
    }

    /// Signals every stop to the tick, answers it, then calls `on_stop`. Returns after
    /// [`Listener::close`].
    ///
    /// `on_stop` must not block: it delays the next stop.
    pub fn serve(&self, mut incoming: impl FnMut(ReceivedStop)) {
        while !self.closed.load(Ordering::Acquire) {
            // A receive error leaves nothing to hand over.
            let Ok(Some(datagram)) = self.receive() else {
                continue;
            };
            let (received_ns, number) = (now_ns(), self.signal.raise());
            let outcome = self.wait_until_taken(number);
            self.answer(&datagram, number, received_ns, outcome);
            incoming(ReceivedStop {
                number,
                pid: datagram.pid,
                reason: datagram.request.map_or(Text::default(), |r| r.reason),
                outcome,
            });
        }
    }

    /// Ends [`Listener::serve`] from any thread.
    pub fn close(&self) {
        self.closed.store(true, Ordering::Release);
        // Wakes the thread; a failure needs no action.
        let _ = self.socket.shutdown(Shutdown::Both);
    }

    /// The next datagram; `None` if it comes from another user.
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
            if begin.elapsed() >= TAKEN_TIMEOUT {
                return StopOutcome::WAITING;
            }
            std::thread::sleep(POLL);
        }
        StopOutcome::STOPPED
    }

    /// Sends the answer without waiting; it is lost if the client does not read it.
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
        // A file that remains is removed by the next owner.
        let _ = fs::remove_file(&self.path);
    }
}
