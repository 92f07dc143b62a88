//! The daemon's side of the stop socket.

use std::fs::{self, Permissions};
use std::io::{self, IoSliceMut};
use std::net::Shutdown;
use std::os::fd::AsRawFd;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::UnixDatagram;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use nix::cmsg_space;
use nix::sys::socket::{
    ControlMessageOwned, MsgFlags, UnixAddr, UnixCredentials, recvmsg, sendto, setsockopt,
    sockopt::PassCred,
};
use shm_schemas::{Stamp, StopAnswer, StopOutcome, StopRequest, Text};
use zerocopy::{FromZeros, IntoBytes};

use super::STOP_SOCKET;
use super::request::remove_abandoned;
use super::signal::Signal;
use crate::clock::{now_ns, writer_epoch};
use crate::error::BusError;
use crate::owner_lock::OwnerLock;
use crate::user::uid;

/// Time limit for a tick to take a stop; afterwards the answer is `WAITING`. Design choice: twenty
/// ticks at 1 kHz.
const TAKEN_TIMEOUT: Duration = Duration::from_millis(20);
/// Time limit for a status that shows a taken stop; afterwards the answer is the same. Design
/// choice: fifty rounds of the supervisor, on which a stop must not depend.
const SHOWN_TIMEOUT: Duration = Duration::from_millis(200);
/// Poll interval while stops wait for their answer.
const POLL: Duration = Duration::from_micros(200);
/// Most stops that wait for their answer; further ones stay in the socket. Design choice: more than
/// the senders of a robot; their memory is locked.
const UNANSWERED_MAX: usize = 128;

/// Receives stops in a dedicated thread.
///
/// ```no_run
/// # fn f(owner: &shm_bus::OwnerLock) -> Result<(), shm_bus::BusError> {
/// let listener = std::sync::Arc::new(shm_bus::stop::Listener::open(owner)?);
/// let signal = listener.signal(); // the tick: pending(), take(); the status: unshown(), show()
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
    /// Process id of the sender; 0 in a PID namespace that this process does not see (a container).
    pub pid: u32,
    /// Reason given by the sender; empty if none.
    pub reason: Text<96>,
    /// Result: taken by a tick, or still waiting.
    pub outcome: StopOutcome,
}

/// Received stop whose sender waits for the answer.
struct Unanswered {
    request: Option<StopRequest>,
    pid: u32,
    sender: Option<UnixAddr>,
    number: u64,
    received_ns: u64,
    since: Instant,
}

impl Listener {
    /// Opens the bus's stop socket and replaces an old one. The owner lock guarantees that no other
    /// process uses it. Removes the sockets of killed clients.
    ///
    /// # Errors
    /// [`BusError::Io`] if the socket cannot be created.
    pub fn open(owner: &OwnerLock) -> Result<Self, BusError> {
        let path = owner.folder.path.join(STOP_SOCKET);
        remove_abandoned(&owner.folder);
        let made = || -> io::Result<UnixDatagram> {
            match fs::remove_file(&path) {
                Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
                _ => {}
            }
            let socket = UnixDatagram::bind(&path)?;
            fs::set_permissions(&path, Permissions::from_mode(0o600))?;
            setsockopt(&socket, PassCred, &true)?;
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
    pub fn serve(&self, mut on_stop: impl FnMut(ReceivedStop)) {
        let mut unanswered = Vec::with_capacity(UNANSWERED_MAX);
        while !self.closed.load(Ordering::Acquire) {
            while unanswered.len() < UNANSWERED_MAX {
                // Nothing to do but wait if no stop has come, if another user sent it, or after an
                // error.
                let Ok(Some(stop)) = self.receive(unanswered.is_empty()) else {
                    break;
                };
                unanswered.push(stop);
            }
            unanswered.retain(|stop| {
                let outcome = self.outcome(stop);
                if let Some(outcome) = outcome {
                    self.answer(stop, outcome);
                    on_stop(stop.with(outcome));
                }
                outcome.is_none()
            });
            if !unanswered.is_empty() {
                std::thread::sleep(POLL);
            }
        }
    }

    /// Ends [`Listener::serve`] from any thread.
    pub fn close(&self) {
        self.closed.store(true, Ordering::Release);
        // Wakes the thread; a failure needs no action.
        let _ = self.socket.shutdown(Shutdown::Both);
    }

    /// Receives the next datagram and signals it to the tick; `None` if it comes from another user.
    fn receive(&self, waits: bool) -> io::Result<Option<Unanswered>> {
        let mut request = StopRequest::new_zeroed();
        let mut space = cmsg_space!(UnixCredentials);
        let (bytes, sender, credentials) = {
            let buffer = &mut [IoSliceMut::new(request.as_mut_bytes())];
            let flags = if waits {
                MsgFlags::empty()
            } else {
                MsgFlags::MSG_DONTWAIT
            };
            let fd = self.socket.as_raw_fd();
            let received = recvmsg::<UnixAddr>(fd, buffer, Some(&mut space), flags)?;
            let credentials = received.cmsgs()?.find_map(|message| match message {
                ControlMessageOwned::ScmCredentials(credentials) => Some(credentials),
                _ => None,
            });
            (received.bytes, received.address, credentials)
        };
        let permitted = credentials.filter(|of| of.uid() == uid() || of.uid() == 0);
        Ok(permitted.map(|credentials| Unanswered {
            request: (bytes == size_of::<StopRequest>()).then_some(request),
            pid: credentials.pid().unsigned_abs(),
            sender,
            number: self.signal.raise(),
            received_ns: now_ns(),
            since: Instant::now(),
        }))
    }

    /// Returns the outcome once the tick has taken the stop and the status shows it, so that a
    /// client that reads it after the answer sees the stop; or once a time limit has passed.
    fn outcome(&self, stop: &Unanswered) -> Option<StopOutcome> {
        let waited = stop.since.elapsed();
        if !self.signal.is_taken(stop.number) {
            return (waited >= TAKEN_TIMEOUT).then_some(StopOutcome::WAITING);
        }
        let answers = self.signal.is_shown(stop.number) || waited >= SHOWN_TIMEOUT;
        answers.then_some(StopOutcome::STOPPED)
    }

    /// Sends the answer without waiting; it is lost if the client does not read it.
    fn answer(&self, stop: &Unanswered, outcome: StopOutcome) {
        let Some(sender) = &stop.sender else { return };
        let answer = StopAnswer {
            stamp: Stamp {
                sequence: stop.number,
                captured_ns: stop.received_ns,
                writer_epoch: self.writer_epoch,
            },
            outcome,
            pid: std::process::id(),
        };
        let flags = MsgFlags::MSG_DONTWAIT | MsgFlags::MSG_NOSIGNAL;
        let _ = sendto(self.socket.as_raw_fd(), answer.as_bytes(), sender, flags);
    }
}

impl Unanswered {
    fn with(&self, outcome: StopOutcome) -> ReceivedStop {
        ReceivedStop {
            number: self.number,
            pid: self.pid,
            reason: self.request.map_or(Text::default(), |r| r.reason),
            outcome,
        }
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        // A file that remains is removed by the next owner.
        let _ = fs::remove_file(&self.path);
    }
}
