//! What can go wrong on the bus, in sentences: could not X because Y; do C.

use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

/// Why the bus could not do what it was asked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BusError {
    /// The text is not a bus name.
    #[error(
        "could not use {name:?} as the name of a bus because {why}; \
         use 1 to 24 characters out of a-z, 0-9 and '-', and begin and end with a letter or digit"
    )]
    Name {
        /// The text, cut to a readable length.
        name: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// The folder of the bus could be under someone else's control.
    #[error(
        "could not use {path} for the bus because {why}; remove it, or set XDG_RUNTIME_DIR to a private folder"
    )]
    UnsafeRoot {
        /// The folder.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// The operating system refused.
    #[error("could not {doing} {path} because of: {source}")]
    Io {
        /// What was attempted.
        doing: &'static str,
        /// On which file or folder.
        path: PathBuf,
        /// The operating system's answer.
        source: std::io::Error,
    },
    /// A daemon already owns this bus.
    #[error(
        "could not own the bus {bus:?} because {role} (process {pid}) has owned it for {owned_s} s; \
         stop that process, or choose another bus with --bus"
    )]
    Owned {
        /// The bus.
        bus: String,
        /// Role of the owner.
        role: String,
        /// Process id of the owner; 0 if it could not be read.
        pid: u32,
        /// For how long, s.
        owned_s: u64,
    },
    /// Another process is publishing or serving where only one may.
    #[error(
        "could not offer {service} because {role} (process {pid}) already does and only one may; \
         stop that process, or choose another bus with --bus"
    )]
    Taken {
        /// The service.
        service: &'static str,
        /// Role of the process that has it.
        role: String,
        /// Its process id; 0 if it could not be found.
        pid: u32,
    },
    /// All places at a service are taken.
    #[error(
        "could not join {service} because all {limit} places are taken; stop one of its {what}"
    )]
    Full {
        /// The service.
        service: &'static str,
        /// Kind of peers that have the places.
        what: &'static str,
        /// How many places there are.
        limit: usize,
    },
    /// `/dev/shm` has not enough room. Without this refusal the kernel would kill the process (SIGBUS).
    #[error(
        "could not set up {what} because /dev/shm has {free_kib} KiB free and {needed_kib} KiB are needed; \
         remove files there, or mount it larger"
    )]
    NoSpace {
        /// What was to be set up.
        what: &'static str,
        /// Free, KiB.
        free_kib: u64,
        /// Needed, KiB.
        needed_kib: u64,
    },
    /// Another process has been setting something up on this bus for too long.
    #[error(
        "could not join the bus {bus:?} because process {pid} has held its start-up lock for more than {waited:?}; \
         if that process hangs or is stopped, end it"
    )]
    StartUp {
        /// The bus.
        bus: String,
        /// Process id of the holder; 0 if it could not be read.
        pid: u32,
        /// How long this process waited.
        waited: Duration,
    },
    /// The name is not in the table of services, or with another payload.
    #[error(
        "could not open {service} with {payload} because the table of services has no such line; correct the call"
    )]
    Unknown {
        /// The name asked for.
        service: String,
        /// The payload asked for.
        payload: &'static str,
    },
    /// iceoryx2 could not join or create.
    #[error("could not open {what} on {root} because of: {why}; {cure}")]
    Open {
        /// A service, or the bus itself.
        what: &'static str,
        /// The folder of the bus.
        root: PathBuf,
        /// iceoryx2's answer.
        why: String,
        /// What to do.
        cure: &'static str,
    },
    /// The machine or this process has too little of something.
    #[error("could not set up {what} because {why}")]
    Short {
        /// What was to be set up.
        what: &'static str,
        /// Of what, how much there is, and what to do.
        why: String,
    },
    /// There is no such bus.
    #[error(
        "could not find the bus {bus:?} because nobody made it (folder {folder}){unseen}; start atasd on it, or choose another bus \
         with --bus"
    )]
    Absent {
        /// The bus.
        bus: String,
        /// Where its folder would be.
        folder: PathBuf,
        /// Where it may be all the same.
        unseen: Unseen,
    },
    /// This user has no such bus, but another user has one of this name.
    #[error(
        "could not find the bus {bus:?} because this user has none (folder {folder}), and {place} is owned by user {user}; \
         run this as {user}, for example with `sudo -u {user}`, or start atasd"
    )]
    OtherUser {
        /// The bus.
        bus: String,
        /// Where its folder would be.
        folder: PathBuf,
        /// What the other user has.
        place: PathBuf,
        /// Name of the other user.
        user: String,
    },
    /// A payload could not be sent.
    #[error("could not send on {service} because {why}; restart this process")]
    Send {
        /// The service.
        service: &'static str,
        /// What happened.
        why: &'static str,
    },
    /// A payload could not be received.
    #[error("could not receive from {service} because {why}; restart this process")]
    Receive {
        /// The service.
        service: &'static str,
        /// What happened.
        why: &'static str,
    },
    /// Nobody serves.
    #[error(
        "could not reach {service} because nobody serves it; is atasd running on bus {bus:?} (folder {root})?"
    )]
    NoServer {
        /// The service.
        service: &'static str,
        /// The bus.
        bus: String,
        /// Its folder.
        root: PathBuf,
    },
    /// The server went away before the end.
    #[error(
        "could not hear the end of the request because the server of {service} is gone; look at the log of atasd"
    )]
    ServerGone {
        /// The service.
        service: &'static str,
    },
    /// The client went away before the answer.
    #[error("could not answer a request on {service} because its client is gone; drop the request")]
    ClientGone {
        /// The service.
        service: &'static str,
    },
    /// The server did not answer in time.
    #[error(
        "could not get an answer on {service} because the daemon did not answer within {within:?}; is atasd on bus {bus:?} stuck or stopped?"
    )]
    NoAnswer {
        /// The service.
        service: &'static str,
        /// How long the client waited.
        within: Duration,
        /// The bus.
        bus: String,
    },
    /// The client has too many open requests.
    #[error(
        "could not send on {service} because {limit} requests of this client are still open; finish or drop one"
    )]
    TooManyRequests {
        /// The service.
        service: &'static str,
        /// How many may be open.
        limit: usize,
    },
    /// The bus is still in use.
    #[error("could not wipe the bus {bus:?} because it is in use by {peers}; stop them first")]
    InUse {
        /// The bus.
        bus: String,
        /// Role and process id of those that use it.
        peers: String,
    },
}

/// Folders of other users that may hold a bus, for all that this user may see, with the users' names. Prints as the end of a
/// sentence that says that nobody has it.
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
    /// For `map_err` on calls to the operating system.
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
