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
        "could not use {name:?} as the name of a bus because {why}; \
         use 1 to 24 characters out of a-z, 0-9 and '-', and begin and end with a letter or digit"
    )]
    Name {
        /// The text, truncated.
        name: String,
        /// Violated rule.
        why: &'static str,
    },
    /// Folder accessible to other users.
    #[error(
        "could not use {path} for the bus because {why}; remove it, or set XDG_RUNTIME_DIR to a private folder"
    )]
    UnsafeRoot {
        /// Folder or file.
        path: PathBuf,
        /// Cause.
        why: String,
    },
    /// Error of the operating system.
    #[error("could not {doing} {path} because of: {source}")]
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
        "could not own the bus {bus:?} because {role} (process {pid}) has owned it for {owned_s} s; \
         stop that process, or choose another bus with --bus"
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
        "could not offer {service} because {role} (process {pid}) already does and only one may; \
         stop that process, or choose another bus with --bus"
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
    #[error(
        "could not join {service} because all {limit} places are taken; stop one of its {what}"
    )]
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
        "could not set up {what} because /dev/shm has {free_kib} KiB free and {needed_kib} KiB are needed; \
         remove files there, or mount it larger"
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
        "could not join the bus {bus:?} because process {pid} has held its start-up lock for more than {waited:?}; \
         if that process hangs or is stopped, end it"
    )]
    StartUp {
        /// Bus name.
        bus: String,
        /// Process id of the holder; 0 if unknown.
        pid: u32,
        /// Waiting time.
        waited: Duration,
    },
    /// Service and payload without a row in the table.
    #[error(
        "could not open {service} with {payload} because the table of services has no such line; correct the call"
    )]
    Unknown {
        /// Requested service.
        service: String,
        /// Requested payload.
        payload: &'static str,
    },
    /// Error of iceoryx2.
    #[error("could not open {what} on {root} because of: {why}; {cure}")]
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
    #[error("could not set up {what} because {why}")]
    Short {
        /// A service, or the bus.
        what: &'static str,
        /// Resource, amount and remedy.
        why: String,
    },
    /// No such bus.
    #[error(
        "could not find the bus {bus:?} because nobody made it (folder {folder}){unseen}; start atasd on it, or choose another bus \
         with --bus"
    )]
    Absent {
        /// Bus name.
        bus: String,
        /// Expected folder.
        folder: PathBuf,
        /// Unreadable folders that may contain it.
        unseen: Unseen,
    },
    /// The bus exists only for another user.
    #[error(
        "could not find the bus {bus:?} because this user has none (folder {folder}), and {place} is owned by user {user}; \
         run this as {user}, for example with `sudo -u {user}`, or start atasd"
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
    /// Failed send.
    #[error("could not send on {service} because {why}; restart this process")]
    Send {
        /// Service name.
        service: &'static str,
        /// Cause.
        why: &'static str,
    },
    /// Failed receive.
    #[error("could not receive from {service} because {why}; restart this process")]
    Receive {
        /// Service name.
        service: &'static str,
        /// Cause.
        why: &'static str,
    },
    /// Service without a server.
    #[error(
        "could not reach {service} because nobody serves it; is atasd running on bus {bus:?} (folder {root})?"
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
        "could not hear the end of the request because the server of {service} is gone; look at the log of atasd"
    )]
    ServerGone {
        /// Service name.
        service: &'static str,
    },
    /// Client that ended before the answer.
    #[error("could not answer a request on {service} because its client is gone; drop the request")]
    ClientGone {
        /// Service name.
        service: &'static str,
    },
    /// Answer not received in time.
    #[error(
        "could not get an answer on {service} because the daemon did not answer within {within:?}; is atasd on bus {bus:?} stuck or stopped?"
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
        "could not send on {service} because {limit} requests of this client are still open; finish or drop one"
    )]
    TooManyRequests {
        /// Service name.
        service: &'static str,
        /// Maximum number.
        limit: usize,
    },
    /// Bus in use.
    #[error("could not wipe the bus {bus:?} because it is in use by {peers}; stop them first")]
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
pub struct Unseen(pub Vec<(PathBuf, String)>);

impl fmt::Display for Unseen {
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
