//! Resource checks: find the real cause when iceoryx2 returns `InternalError` for an error of the
//! operating system.

use std::fs::File;
use std::io;
use std::path::Path;

use rustix::fs::StatVfs;
use rustix::process::{Resource, getrlimit};

use crate::error::BusError;
use crate::folder::SHM;
use crate::location::Location;
use crate::user::User;

/// Free space in `/dev/shm` beyond the payloads, for connections, service descriptions and other
/// processes. Design choice.
const RESERVE_BYTES: u64 = 4 << 20;
/// Descriptors that opening a service may need; a publisher needs one per reader. Design choice.
const DESCRIPTORS_MIN: usize = 24;
/// Files that opening a service may create. Design choice.
const INODES_MIN: u64 = 16;
/// Stack needed to open a service: unoptimised code copies the largest payloads several times.
/// `tests/shortage.rs` runs smaller and larger stacks. Design choice.
const STACK_BYTES_MIN: usize = 512 << 10;

/// The error for a refusal of iceoryx2: a shortage, else a foreign file, else iceoryx2's message.
pub(crate) fn refusal_error(place: &Location, what: &'static str, why: String) -> BusError {
    if let Some(why) = find_shortage(place) {
        return BusError::Shortage { what, why };
    }
    if let Some((path, owner)) = place.foreign_file() {
        let why = format!("user {} created it", User(owner));
        return BusError::UnsafeRoot { path, why };
    }
    let versions = ["Incompatible", "Version", "DoesNotSupportRequested"];
    let cure = if versions.iter().any(|word| why.contains(word)) {
        "a process of another version runs on this bus; stop it"
    } else {
        "restart this process and check its log"
    };
    BusError::Open {
        what,
        root: place.root().to_owned(),
        why,
        cure,
    }
}

/// Description of the resource that is short, with the remedy.
pub(crate) fn find_shortage(place: &Location) -> Option<String> {
    descriptor_shortage()
        .or_else(|| space_shortage(Path::new(SHM)))
        .or_else(|| space_shortage(place.root()))
}

fn descriptor_shortage() -> Option<String> {
    let probe = || File::open("/dev/null");
    let probed: io::Result<Vec<File>> = (0..DESCRIPTORS_MIN).map(|_| probe()).collect();
    let error = probed.err()?;
    let limit = getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX);
    Some(match rustix::io::Errno::from_io_error(&error)? {
        rustix::io::Errno::MFILE => format!(
            "fewer than {DESCRIPTORS_MIN} of this process's {limit} file descriptors are free; raise \
             `ulimit -n`"
        ),
        rustix::io::Errno::NFILE => {
            "the machine has no file descriptors left; raise the sysctl fs.file-max".to_owned()
        }
        _ => return None,
    })
}

fn space_shortage(folder: &Path) -> Option<String> {
    let stat = rustix::fs::statvfs(folder).ok()?;
    let (free, place) = (free_bytes(&stat), folder.display());
    // A file system that does not count inodes reports a total of zero.
    if stat.f_files > 0 && stat.f_favail < INODES_MIN {
        return Some(format!(
            "{place} has {} free inodes and {INODES_MIN} are needed; remove files there or mount it \
             with more inodes",
            stat.f_favail
        ));
    }
    (free < RESERVE_BYTES && folder == Path::new(SHM) || free == 0).then(|| {
        format!(
            "{place} has {} KiB free; remove files there or mount it larger",
            free / 1024
        )
    })
}

fn free_bytes(stat: &StatVfs) -> u64 {
    stat.f_bavail.saturating_mul(stat.f_frsize)
}

/// Rejects if `/dev/shm` lacks space for `bytes` plus the reserve: a later access would raise
/// SIGBUS.
pub(crate) fn require_space(what: &'static str, bytes: usize) -> Result<(), BusError> {
    let needed = bytes as u64 + RESERVE_BYTES;
    let shm = Path::new(SHM);
    let stat = rustix::fs::statvfs(shm).map_err(|e| BusError::io("examine", shm)(e.into()))?;
    let free = free_bytes(&stat);
    if free >= needed {
        return Ok(());
    }
    Err(BusError::NoSpace {
        what,
        free_kib: free / 1024,
        needed_kib: needed.div_ceil(1024),
    })
}

/// Rejects if the stack of this thread is too small: it would overflow (SIGSEGV).
pub(crate) fn require_stack(what: &'static str) -> Result<(), BusError> {
    match stacker::remaining_stack() {
        Some(free) if free < STACK_BYTES_MIN => Err(BusError::Shortage {
            what,
            why: format!(
                "this thread has {} KiB of stack left and {} KiB are needed; raise `ulimit -s` or \
                 the thread's stack size",
                free / 1024,
                STACK_BYTES_MIN / 1024
            ),
        }),
        _ => Ok(()),
    }
}
