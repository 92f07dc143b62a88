//! Advisory locks in the bus's folder. The kernel releases them when the holding process ends.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read};
use std::os::unix::fs::{FileExt, MetadataExt, OpenOptionsExt};
use std::path::Path;

use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;

use crate::clock::now_ns;
use crate::error::BusError;
use crate::folder::Folder;

/// File whose lock serialises set-up on the bus.
pub(crate) const STARTUP_LOCK: &str = "startup.lock";
/// File whose lock marks the daemon that owns the bus.
pub(crate) const OWNER_LOCK: &str = "owner.lock";

/// Holder of a lock, as written into its file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Holder {
    pub(crate) pid: u32,
    /// Time at which the lock was taken, ns of `CLOCK_MONOTONIC`.
    pub(crate) since_ns: u64,
    pub(crate) role: String,
}

impl Holder {
    fn current_process(role: &str) -> Self {
        Self {
            pid: std::process::id(),
            since_ns: now_ns(),
            role: role.to_owned(),
        }
    }

    /// Parses `pid since_ns role`. Unreadable parts stay empty, because the holder may be writing.
    fn parse(text: &str) -> Self {
        let mut words = text.trim_end().splitn(3, ' ');
        let pid = words
            .next()
            .and_then(|word| word.parse().ok())
            .unwrap_or_default();
        let since_ns = words
            .next()
            .and_then(|word| word.parse().ok())
            .unwrap_or_default();
        Self {
            pid,
            since_ns,
            role: words.next().unwrap_or("another process").to_owned(),
        }
    }
}

#[derive(Debug)]
pub(crate) struct FileLock {
    file: File,
}

impl Drop for FileLock {
    /// Closing is not enough: a child process has a copy of the descriptor between fork and exec.
    fn drop(&mut self) {
        let _ = flock(&self.file, FlockOperation::Unlock);
    }
}

impl FileLock {
    /// The current holder, from the kernel's lock table. Trying the lock could make another process
    /// fail to get it.
    pub(crate) fn holder(folder: &Folder, name: &str) -> Option<Holder> {
        let mut file = File::open(folder.path.join(name)).ok()?;
        let holder = read(&mut file);
        let locks = fs::read_to_string("/proc/locks").ok()?;
        let inode = file.metadata().ok()?.ino();
        is_listed(&locks, holder.pid, inode).then_some(holder)
    }

    /// Returns true if [`FileLock::holder`] can see holders: the kernel's lock table is readable.
    pub(crate) fn shows_holders() -> bool {
        File::open("/proc/locks").is_ok()
    }

    /// Takes the lock, or returns its holder.
    pub(crate) fn try_take(
        folder: &Folder,
        name: &str,
        role: &str,
    ) -> Result<Result<Self, Holder>, BusError> {
        let path = folder.path.join(name);
        loop {
            folder.make()?;
            let mut file = match open(&path) {
                // Another process wiped the bus between `make` and `open`.
                Err(e) if e.kind() == io::ErrorKind::NotFound => continue,
                opened => opened.map_err(BusError::io("open", &path))?,
            };
            match flock(&file, FlockOperation::NonBlockingLockExclusive) {
                Ok(()) => {}
                Err(Errno::WOULDBLOCK) => return Ok(Err(read(&mut file))),
                Err(e) => return Err(BusError::io("lock", &path)(e.into())),
            }
            // A wipe may have removed the file between open and lock; then the lock protects
            // nothing.
            if is_at(&file, &path) {
                write(&file, &Holder::current_process(role))
                    .map_err(BusError::io("write", &path))?;
                return Ok(Ok(Self { file }));
            }
        }
    }
}

fn open(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .mode(0o600)
        .custom_flags(O_NOFOLLOW);
    options.open(path)
}

/// Refuses a link as last path component, in addition to the private folder.
const O_NOFOLLOW: i32 = rustix::fs::OFlags::NOFOLLOW.bits() as i32;

fn is_at(file: &File, path: &Path) -> bool {
    let identity = |meta: fs::Metadata| (meta.dev(), meta.ino());
    match (file.metadata(), fs::symlink_metadata(path)) {
        (Ok(held), Ok(named)) => identity(held) == identity(named),
        _ => false,
    }
}

/// Searches `/proc/locks` (`proc_locks(5)`) for a lock of this process on the whole file with this
/// inode.
fn is_listed(locks: &str, pid: u32, inode: u64) -> bool {
    let (pid, inode) = (pid.to_string(), inode.to_string());
    locks.lines().any(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [_, "FLOCK", _, _, by, file, ..] = words[..] else {
            return false;
        };
        by == pid && file.rsplit(':').next() == Some(&inode)
    })
}

fn read(file: &mut File) -> Holder {
    let mut text = String::new();
    // Unreadable content only makes a message less precise.
    let _ = file.read_to_string(&mut text);
    Holder::parse(&text)
}

/// Overwrites a constant length in place: truncating costs milliseconds on a disk.
fn write(file: &File, holder: &Holder) -> io::Result<()> {
    let text = format!("{} {} {:.64}", holder.pid, holder.since_ns, holder.role);
    file.write_all_at(format!("{text:<127}\n").as_bytes(), 0)
}

#[cfg(test)]
mod tests {
    use super::{Holder, is_listed};

    #[test]
    fn holder_is_found_in_proc_locks() {
        let locks = "1: POSIX  ADVISORY  READ  7 fe:00:42 128 128\n\
                     2: FLOCK  ADVISORY  WRITE 70 fe:00:42 0 EOF\n\
                     2: -> FLOCK  ADVISORY  WRITE 8 fe:00:42 0 EOF\n";
        let check = |pid, inode, listed| {
            assert_eq!(is_listed(locks, pid, inode), listed, "{pid} {inode}");
        };
        check(70, 42, true);
        check(7, 42, false);
        check(8, 42, false);
        check(70, 2, false);
    }

    #[test]
    fn holder_is_parsed() {
        let check = |text: &str, pid: u32, since_ns: u64, role: &str| {
            assert_eq!(
                Holder::parse(text),
                Holder {
                    pid,
                    since_ns,
                    role: role.to_owned()
                },
                "{text:?}"
            );
        };
        check("12 34 atasd\n", 12, 34, "atasd");
        check("12 34 a b\n", 12, 34, "a b");
        check("", 0, 0, "another process");
        check("12", 12, 0, "another process");
        check("x y z", 0, 0, "z");
    }
}
