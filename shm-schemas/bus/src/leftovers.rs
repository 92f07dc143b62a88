//! Removal of the files that killed processes leave behind.
//!
//! * **Dead nodes** keep slots of services: [`crate::clean`] removes them.
//! * **Unfinished files**: a process killed while it creates a file leaves it empty or unreadable.
//!   iceoryx2 0.10 waits for its completion, for empty shared memory without end.
//!   [`remove_unfinished`] removes them under the start-up lock, so no process of the bus can be
//!   creating them.
//! * **Unfinished services**: a description without its shared memory, or one whose last user died
//!   while removing it. They are recognised by their error;
//!   [`crate::member::Member::open_with_recovery`] removes and recreates them.
//! * **Empty bus**: the first process on a bus removes everything: [`remove_all`].

use std::fs::{self, Metadata};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::prelude::{MessagingPattern, ServiceName, ipc};
use iceoryx2::service::Service;
use iceoryx2::service::service_hash::ServiceHash;

use crate::end::END_RECORD;
use crate::folder::entries;
use crate::location::{Location, PREFIX, VERSION_FILE};
use crate::lock::{OWNER_LOCK, STARTUP_LOCK};
use crate::stop::{CLIENT_SOCKET, STOP_SOCKET};

/// Time after which an unfinished file counts as abandoned. The lock excludes Rust processes; peers
/// in other languages finish a file within about 100 µs. Design choice.
const UNFINISHED_WAIT: Duration = Duration::from_millis(20);

/// Removes unfinished files. Call under the start-up lock only.
pub(crate) fn remove_unfinished(place: &Location) {
    let suspects: Vec<PathBuf> = unfinished_files(place).collect();
    if suspects.is_empty() {
        return;
    }
    std::thread::sleep(UNFINISHED_WAIT);
    for path in unfinished_files(place).filter(|path| suspects.contains(path)) {
        tracing::warn!(bus = %place.bus(), file = %path.display(), "removing an unfinished file of \
            a killed process");
        remove(&path);
    }
}

fn unfinished_files(place: &Location) -> impl Iterator<Item = PathBuf> {
    let services = entries(&place.root().join("services"));
    let unfinished = |(path, meta): (PathBuf, Metadata)| is_unfinished(&meta).then_some(path);
    place.shared_memory().chain(services).filter_map(unfinished)
}

/// iceoryx2 sets the size before the content, and the owner's read permission at the end.
fn is_unfinished(meta: &Metadata) -> bool {
    meta.is_file() && (meta.len() == 0 || meta.mode() & 0o400 == 0)
}

/// Files that survive a restart of the bus: the daemon opens some of them before it joins.
const PERSISTENT: [&str; 6] = [
    OWNER_LOCK,
    END_RECORD,
    STARTUP_LOCK,
    PREFIX,
    VERSION_FILE,
    STOP_SOCKET,
];

/// Removes everything except [`PERSISTENT`] and client sockets; returns the number of entries.
/// Call under the start-up lock, when no peer is alive.
pub(crate) fn remove_all(place: &Location) -> usize {
    // A client may wait for the answer to its stop.
    let is_client = |path: &Path| {
        let name = path.file_name().unwrap_or_default().as_encoded_bytes();
        name.starts_with(CLIENT_SOCKET.as_bytes())
    };
    let lasts = |path: &Path| is_client(path) || PERSISTENT.iter().any(|name| path.ends_with(name));
    let files = entries(place.root())
        .map(|(path, _)| path)
        .filter(|path| !lasts(path));
    let memory = place.shared_memory().map(|(path, _)| path);
    files.chain(memory).filter(|path| remove(path)).count()
}

/// Removes a file, or a folder with its content; links are not followed.
pub(crate) fn remove(path: &Path) -> bool {
    let removed = match fs::symlink_metadata(path) {
        Ok(meta) if meta.is_dir() => fs::remove_dir_all(path),
        _ => fs::remove_file(path),
    };
    if let Err(error) = &removed {
        tracing::warn!(file = %path.display(), %error, "could not remove a file");
    }
    removed.is_ok()
}

/// Removes the description of a service that no process can open. Call under the start-up lock
/// only.
pub(crate) fn remove_service(place: &Location, service: &str, pattern: MessagingPattern) {
    type Hasher = <ipc::Service as Service>::ServiceNameHasher;
    let Ok(name) = ServiceName::new(service) else {
        return;
    };
    let file = format!(
        "{}{}.service",
        place.prefix,
        ServiceHash::new::<Hasher>(&name, pattern)
    );
    remove(&place.root().join("services").join(file));
}
