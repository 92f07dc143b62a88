//! Start-up lock: serialises set-up on a bus.

use std::time::{Duration, Instant};

use crate::error::BusError;
use crate::folder::Folder;
use crate::lock::{FileLock, Holder, STARTUP_LOCK};

/// Time limit for another process's start-up, which takes a few milliseconds. Design choice.
const WAIT_MAX: Duration = Duration::from_secs(2);
const POLL: Duration = Duration::from_millis(1);

/// Lock for creating nodes, services and ports of a bus.
///
/// It excludes races, and it proves that an unfinished file was left by a killed process.
#[derive(Debug)]
pub(crate) struct StartupLock {
    _lock: FileLock,
}

impl StartupLock {
    pub(crate) fn take(folder: &Folder, role: &str) -> Result<Self, BusError> {
        Self::take_within(folder, role, WAIT_MAX)
    }

    pub(crate) fn take_within(
        folder: &Folder,
        role: &str,
        limit: Duration,
    ) -> Result<Self, BusError> {
        let begin = Instant::now();
        loop {
            match Self::attempt(folder, role)? {
                Ok(lock) => return Ok(lock),
                Err(holder) if begin.elapsed() >= limit => {
                    let bus = folder.bus.to_string();
                    return Err(BusError::StartupBlocked {
                        bus,
                        pid: holder.pid,
                        waited: limit,
                    });
                }
                Err(_) => std::thread::sleep(POLL),
            }
        }
    }

    pub(crate) fn try_take(folder: &Folder, role: &str) -> Result<Option<Self>, BusError> {
        Ok(Self::attempt(folder, role)?.ok())
    }

    fn attempt(folder: &Folder, role: &str) -> Result<Result<Self, Holder>, BusError> {
        let taken = FileLock::try_take(folder, STARTUP_LOCK, role)?;
        Ok(taken.map(|lock| Self { _lock: lock }))
    }
}
