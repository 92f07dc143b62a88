//! What killed processes leave behind, and how it goes away.
//!
//! * **Dead nodes** hold places at services: [`crate::clean`] removes them.
//! * **Half-made files**: a process killed between creating and finishing a file leaves it empty or unreadable.
//!   iceoryx2 0.10 waits for such a file to be finished, for an empty shared memory without end. [`sweep`] removes
//!   them. It runs under the start-up lock, so nobody of ours can be making them.
//! * **Half-made services**: a description without its shared memory, or one whose last user died while removing it.
//!   They are recognised by the error they give: [`crate::member::Member::open_despite_remains`] has them removed and
//!   makes them again.
//! * **Nobody left**: the first process on a bus begins on clean ground: [`clear`].

use std::fs::{self, Metadata};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::prelude::{MessagingPattern, ServiceName, ipc};
use iceoryx2::service::Service;
use iceoryx2::service::service_hash::ServiceHash;

use crate::folder::entries;
use crate::lock::{OWNER_LOCK, STARTUP_LOCK};
use crate::place::{PREFIX, Place};
use crate::stop::STOP_SOCKET;

/// A file that is still unfinished after this time has no maker. Processes of ours are excluded by the lock; this is
/// for peers in other languages, which finish a file within some 100 µs. Ours.
const UNFINISHED: Duration = Duration::from_millis(20);

/// Removes half-made files. Call under the start-up lock only.
pub(crate) fn sweep(place: &Place) {
    let suspects: Vec<PathBuf> = half_made(place).collect();
    if suspects.is_empty() {
        return;
    }
    std::thread::sleep(UNFINISHED);
    for path in half_made(place).filter(|path| suspects.contains(path)) {
        tracing::warn!(bus = %place.bus(), file = %path.display(), "removing what a killed process left half-made");
        remove(&path);
    }
}

fn half_made(place: &Place) -> impl Iterator<Item = PathBuf> {
    let services = entries(&place.root().join("services"));
    let unfinished = |(path, meta): (PathBuf, Metadata)| is_half_made(&meta).then_some(path);
    place.shared_memory().chain(services).filter_map(unfinished)
}

/// iceoryx2 gives a file its size before its content and the owner's right to read when it is finished.
fn is_half_made(meta: &Metadata) -> bool {
    meta.is_file() && (meta.len() == 0 || meta.mode() & 0o400 == 0)
}

/// What belongs to the bus and not to a life of it: the daemon holds some of it before it joins.
const LASTING: [&str; 4] = [OWNER_LOCK, STARTUP_LOCK, PREFIX, STOP_SOCKET];

/// Removes everything but what is [`LASTING`]; returns how many entries. Call under the start-up lock, when nobody is
/// alive.
pub(crate) fn clear(place: &Place) -> usize {
    let lasts = |path: &Path| LASTING.iter().any(|name| path.ends_with(name));
    let files = entries(place.root())
        .map(|(path, _)| path)
        .filter(|path| !lasts(path));
    let memory = place.shared_memory().map(|(path, _)| path);
    files.chain(memory).filter(|path| remove(path)).count()
}

/// Removes a file or a folder with all that is in it; links are not followed.
pub(crate) fn remove(path: &Path) -> bool {
    let removed = match fs::symlink_metadata(path) {
        Ok(meta) if meta.is_dir() => fs::remove_dir_all(path),
        _ => fs::remove_file(path),
    };
    if let Err(error) = &removed {
        tracing::warn!(file = %path.display(), %error, "could not remove");
    }
    removed.is_ok()
}

/// Removes the description of a service that nobody can open. Call under the start-up lock only.
pub(crate) fn forget_service(place: &Place, service: &str, pattern: MessagingPattern) {
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
