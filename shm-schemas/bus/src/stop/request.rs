//! The client's side of the stop socket.

use std::ffi::OsStr;
use std::fs::{self, Permissions};
use std::io;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::net::{AddressFamily, SocketAddrUnix, SocketType, bind, socket};
use shm_schemas::{Stamp, StopAnswer, StopRequest, Text};
use zerocopy::{FromZeros, IntoBytes};

use super::{CLIENT_SOCKET, STOP_SOCKET};
use crate::clock::{nonce, now_ns};
use crate::error::BusError;
use crate::folder::{Folder, entries_named};
use crate::leftovers;
use crate::name::BusName;

/// Requests the daemon of a bus to stop at once and to stay stopped, and waits for its answer.
///
/// Takes no lock, joins no bus, cleans nothing up.
///
/// # Errors
/// [`BusError::Absent`], [`BusError::OtherUser`] or [`BusError::NoServer`] if no daemon of this
/// user runs on the bus; [`BusError::NoAnswer`] if it did not answer within `within`. The stop then
/// stays in the socket and takes effect when the daemon runs again.
pub fn request(bus: &BusName, reason: &str, within: Duration) -> Result<StopAnswer, BusError> {
    let begin = Instant::now();
    let folder = Folder::for_bus(bus)?;
    folder.find()?;
    let client = Client::open(&folder)?;
    client.send(reason, begin, within)?;
    client.answer(begin, within)
}

/// Removes the sockets of killed clients.
pub(super) fn remove_abandoned(folder: &Folder) {
    let is_client = |name: &OsStr| {
        name.as_encoded_bytes()
            .starts_with(CLIENT_SOCKET.as_bytes())
    };
    for (path, _) in entries_named(&folder.path, is_client) {
        let tried = UnixDatagram::unbound().and_then(|socket| socket.connect(&path));
        if tried.is_err_and(|error| error.kind() == io::ErrorKind::ConnectionRefused) {
            leftovers::remove(&path);
        }
    }
}

struct Client<'a> {
    socket: UnixDatagram,
    folder: &'a Folder,
    /// Its file, for the answer; `None` if the folder is full: then the socket has an address
    /// without a file.
    path: Option<PathBuf>,
}

impl<'a> Client<'a> {
    fn open(folder: &'a Folder) -> Result<Self, BusError> {
        let own = folder
            .path
            .join(format!("{CLIENT_SOCKET}{:08x}", nonce() as u32));
        let (socket, path) = match bind_at(&own) {
            Ok(socket) => (socket, Some(own)),
            Err(_) => {
                let nameless =
                    bind_unnamed().map_err(BusError::io("create a socket beside", &own))?;
                (nameless, None)
            }
        };
        let client = Self {
            socket,
            folder,
            path,
        };
        let to = folder.path.join(STOP_SOCKET);
        match client.socket.connect(&to) {
            Ok(()) => Ok(client),
            Err(e) if has_no_listener(&e) => Err(client.no_daemon_error()),
            Err(e) => Err(BusError::io("reach", &to)(e)),
        }
    }

    fn send(&self, reason: &str, begin: Instant, within: Duration) -> Result<(), BusError> {
        let request = StopRequest {
            stamp: Stamp {
                sequence: 0,
                captured_ns: now_ns(),
                writer_epoch: 0,
            },
            reason: Text::new(reason),
        };
        self.set_timeouts(begin, within)?;
        match self.socket.send(request.as_bytes()) {
            Ok(_) => Ok(()),
            Err(e) if has_no_listener(&e) => Err(self.no_daemon_error()),
            Err(e) if timed_out(&e) => Err(self.no_answer_error(within)),
            Err(e) => Err(BusError::io("send a stop to", &self.folder.path)(e)),
        }
    }

    fn answer(&self, begin: Instant, within: Duration) -> Result<StopAnswer, BusError> {
        let mut answer = StopAnswer::new_zeroed();
        self.set_timeouts(begin, within)?;
        match self.socket.recv(answer.as_mut_bytes()) {
            Ok(bytes) if bytes == size_of::<StopAnswer>() => Ok(answer),
            Ok(_) => Err(BusError::Receive {
                service: STOP_SOCKET,
                why: "the daemon has another version; it received the stop",
            }),
            Err(e) if timed_out(&e) => Err(self.no_answer_error(within)),
            // The daemon ended before it read the stop.
            Err(e) if has_no_listener(&e) => Err(self.no_daemon_error()),
            Err(e) => Err(BusError::io(
                "receive the stop answer from",
                &self.folder.path,
            )(e)),
        }
    }

    /// Sets the socket timeouts to the remaining time, at least 1 ms.
    fn set_timeouts(&self, begin: Instant, within: Duration) -> Result<(), BusError> {
        let left = within.saturating_sub(begin.elapsed());
        let left = Some(left.max(Duration::from_millis(1)));
        let set = self.socket.set_write_timeout(left);
        set.and_then(|()| self.socket.set_read_timeout(left))
            .map_err(BusError::io(
                "set a timeout on the stop socket in",
                &self.folder.path,
            ))
    }

    fn no_daemon_error(&self) -> BusError {
        BusError::NoServer {
            service: STOP_SOCKET,
            bus: self.folder.bus.to_string(),
            root: self.folder.path.clone(),
        }
    }

    fn no_answer_error(&self, within: Duration) -> BusError {
        BusError::NoAnswer {
            service: STOP_SOCKET,
            within,
            bus: self.folder.bus.to_string(),
        }
    }
}

impl Drop for Client<'_> {
    fn drop(&mut self) {
        if let Some(path) = &self.path {
            // The next daemon removes a file that remains.
            let _ = fs::remove_file(path);
        }
    }
}

/// The folder is private. The mode lets the daemon answer a client of root.
fn bind_at(path: &Path) -> io::Result<UnixDatagram> {
    let socket = UnixDatagram::bind(path)?;
    fs::set_permissions(path, Permissions::from_mode(0o666))?;
    Ok(socket)
}

/// The kernel chooses an address without a file (`unix(7)`, autobind). Only the connected peer can
/// write to it.
fn bind_unnamed() -> io::Result<UnixDatagram> {
    let socket = socket(AddressFamily::UNIX, SocketType::DGRAM, None)?;
    bind(&socket, &SocketAddrUnix::new_unnamed())?;
    Ok(socket.into())
}

/// No socket there, or no process has it open.
fn has_no_listener(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::NotFound | io::ErrorKind::ConnectionRefused | io::ErrorKind::ConnectionReset
    )
}

fn timed_out(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut
    )
}
