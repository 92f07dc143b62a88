//! Errors of the bus: failed action, cause, remedy.

use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

/// Error of a bus operation.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BusError {
    /// Invalid bus name.
    #[error(
        "could not use {name:?} as a bus name: {why}; use 1 to 24 characters out of a-z, 0-9 and \
         '-', with a letter or digit first and last"
    )]
    Name {
        /// The text, truncated.
        name: String,
        /// Violated rule.
        why: &'static str,
    },
    /// Folder accessible to other users.
    #[error(
        "could not use {path} for the bus: {why}; remove it, or set XDG_RUNTIME_DIR to a private \
         folder"
    )]
    UnsafeRoot {
        /// Folder or file.
        path: PathBuf,
        /// Cause.
        why: String,
    },
    /// Error of the operating system.
    #[error("could not {doing} {path}: {source}")]
    Io {
        /// Attempted action.
        doing: &'static str,
        /// File or folder.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// Bus owned by another daemon.
    #[error(
        "could not take the bus {bus:?}: {role} (process {pid}) has owned it for {owned_s} s; stop \
         that process or choose another bus with --bus"
    )]
    Owned {
        /// Bus name.
        bus: String,
        /// Role of the owner.
        role: String,
        /// Process id of the owner; 0 if unknown.
        pid: u32,
        /// Duration of the ownership, s.
        owned_s: u64,
    },
    /// Service whose only writer or server is another process.
    #[error(
        "could not offer {service}: {role} (process {pid}) already does and only one process may; \
         stop that process or choose another bus with --bus"
    )]
    Taken {
        /// Service name.
        service: &'static str,
        /// Role of that process.
        role: String,
        /// Its process id; 0 if unknown.
        pid: u32,
    },
    /// Service without a free slot.
    #[error("could not join {service}: all {limit} slots are taken; stop one of its {what}")]
    Full {
        /// Service name.
        service: &'static str,
        /// Kind of peers.
        what: &'static str,
        /// Number of slots.
        limit: usize,
    },
    /// Too little space in `/dev/shm`; a later access would kill the process (SIGBUS).
    #[error(
        "could not set up {what}: /dev/shm has {free_kib} KiB free and {needed_kib} KiB are \
         needed; remove files there or mount it larger"
    )]
    NoSpace {
        /// A service, or the bus.
        what: &'static str,
        /// Free, KiB.
        free_kib: u64,
        /// Needed, KiB.
        needed_kib: u64,
    },
    /// Start-up lock held too long by another process.
    #[error(
        "could not join the bus {bus:?}: process {pid} has held its start-up lock for more than \
         {waited:?}; end that process if it hangs or is suspended"
    )]
    StartupBlocked {
        /// Bus name.
        bus: String,
        /// Process id of the holder; 0 if unknown.
        pid: u32,
        /// Waiting time.
        waited: Duration,
    },
    /// Service and payload without a row in the table.
    #[error(
        "could not open {service} with {payload}: the table of services has no such row; correct \
         the call"
    )]
    Unknown {
        /// Requested service.
        service: String,
        /// Requested payload.
        payload: &'static str,
    },
    /// Error of iceoryx2.
    #[error("could not open {what} on {root}: {why}; {cure}")]
    Open {
        /// A service, or the bus.
        what: &'static str,
        /// Folder of the bus.
        root: PathBuf,
        /// iceoryx2's error.
        why: String,
        /// Remedy.
        cure: &'static str,
    },
    /// Exhausted resource.
    #[error("could not set up {what}: {why}")]
    Shortage {
        /// A service, or the bus.
        what: &'static str,
        /// Resource, amount and remedy.
        why: String,
    },
    /// No such bus.
    #[error(
        "could not find the bus {bus:?}: folder {folder} does not exist{unseen}; start atasd on \
         this bus or choose another one with --bus"
    )]
    Absent {
        /// Bus name.
        bus: String,
        /// Expected folder.
        folder: PathBuf,
        /// Unreadable folders that may contain it.
        unseen: HiddenFolders,
    },
    /// The bus exists only for another user.
    #[error(
        "could not find the bus {bus:?}: this user has none (folder {folder}), but user {user} \
         owns {place}; run this as {user}, for example with `sudo -u {user}`, or start atasd"
    )]
    OtherUser {
        /// Bus name.
        bus: String,
        /// Expected folder.
        folder: PathBuf,
        /// Path of the other user's bus.
        place: PathBuf,
        /// Other user.
        user: String,
    },
    /// Bus of another ABI.
    #[error(
        "could not join the bus {bus:?}: it was created by {creator} and is in use by {peers}, \
         this program is {program}; install the same version of both, then restart them"
    )]
    OtherVersion {
        /// Bus name.
        bus: String,
        /// Version of the program that created the bus.
        creator: String,
        /// Roles and process ids of the peers.
        peers: String,
        /// Version of this program.
        program: String,
    },
    /// Failed send.
    #[error("could not send on {service}: {why}; restart this process")]
    Send {
        /// Service name.
        service: &'static str,
        /// Cause.
        why: &'static str,
    },
    /// Failed receive.
    #[error("could not receive from {service}: {why}; restart this process")]
    Receive {
        /// Service name.
        service: &'static str,
        /// Cause.
        why: &'static str,
    },
    /// Service without a server.
    #[error(
        "could not reach {service}: no process serves it on bus {bus:?} (folder {root}); start \
         atasd on this bus or choose another one with --bus"
    )]
    NoServer {
        /// Service name.
        service: &'static str,
        /// Bus name.
        bus: String,
        /// Its folder.
        root: PathBuf,
    },
    /// Server that ended before the request was complete.
    #[error(
        "could not complete the request: the server of {service} ended; check the log of atasd"
    )]
    ServerGone {
        /// Service name.
        service: &'static str,
    },
    /// Client that ended before the answer.
    #[error("could not answer a request on {service}: its client ended; drop the request")]
    ClientGone {
        /// Service name.
        service: &'static str,
    },
    /// Answer not received in time.
    #[error(
        "could not get an answer on {service}: the daemon did not answer within {within:?}; check \
         whether atasd on bus {bus:?} hangs or is suspended"
    )]
    NoAnswer {
        /// Service name.
        service: &'static str,
        /// Waiting time.
        within: Duration,
        /// Bus name.
        bus: String,
    },
    /// Too many open requests of one client.
    #[error(
        "could not send on {service}: {limit} requests of this client are still open; finish or \
         drop one"
    )]
    TooManyRequests {
        /// Service name.
        service: &'static str,
        /// Maximum number.
        limit: usize,
    },
    /// Bus in use.
    #[error("could not wipe the bus {bus:?}: it is in use by {peers}; stop them first")]
    InUse {
        /// Bus name.
        bus: String,
        /// Roles and process ids of the peers.
        peers: String,
    },
}

/// Folders of other users that may contain a bus but that this user may not read, with the users'
/// names. Prints as part of [`BusError::Absent`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HiddenFolders(pub Vec<(PathBuf, String)>);

impl fmt::Display for HiddenFolders {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place =
            |(folder, user): &(PathBuf, String)| format!("{} of user {user}", folder.display());
        let places: Vec<String> = self.0.iter().map(place).collect();
        match places.as_slice() {
            [] => Ok(()),
            _ => write!(
                f,
                ", unless it is in {}, which this user may not see",
                places.join(" or ")
            ),
        }
    }
}

impl BusError {
    /// Returns true if another process already uses the bus or the service.
    #[must_use]
    pub fn is_in_use(&self) -> bool {
        matches!(self, Self::Owned { .. } | Self::Taken { .. })
    }

    /// Error constructor for `map_err` on calls to the operating system.
    pub(crate) fn io(
        doing: &'static str,
        path: &std::path::Path,
    ) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::Io {
            doing,
            path: path.to_owned(),
            source,
        }
    }
}
