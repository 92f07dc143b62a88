//! The start-up lock: one process at a time sets something up.

use std::time::{Duration, Instant};

use crate::error::BusError;
use crate::folder::Folder;
use crate::lock::{FileLock, Holder, STARTUP_LOCK};

/// How long to wait for another process's start-up. A start-up takes some milliseconds; ours.
const WAIT: Duration = Duration::from_secs(2);
/// Pause between two attempts.
const POLL: Duration = Duration::from_millis(1);

/// The lock under which nodes, services and ports of a bus are set up.
///
/// It makes start-up free of races, and it proves that what is half-made was left by a killed process.
#[derive(Debug)]
pub(crate) struct StartupLock {
    _lock: FileLock,
}

impl StartupLock {
    /// Waits for the lock.
    pub(crate) fn take(folder: &Folder, role: &str) -> Result<Self, BusError> {
        let begin = Instant::now();
        loop {
            match Self::attempt(folder, role)? {
                Ok(lock) => return Ok(lock),
                Err(holder) if begin.elapsed() >= WAIT => {
                    let bus = folder.bus.to_string();
                    return Err(BusError::StartUp {
                        bus,
                        pid: holder.pid,
                        waited: WAIT,
                    });
                }
                Err(_) => std::thread::sleep(POLL),
            }
        }
    }

    /// The lock, if nobody has it.
    pub(crate) fn try_take(folder: &Folder, role: &str) -> Result<Option<Self>, BusError> {
        Ok(Self::attempt(folder, role)?.ok())
    }

    fn attempt(folder: &Folder, role: &str) -> Result<Result<Self, Holder>, BusError> {
        let taken = FileLock::try_take(folder, STARTUP_LOCK, role)?;
        Ok(taken.map(|lock| Self { _lock: lock }))
    }
}
