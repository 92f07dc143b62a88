//! One daemon per bus.

use std::fmt;

use crate::clock::now_ns;
use crate::error::BusError;
use crate::folder::Folder;
use crate::lock::{FileLock, OWNER_LOCK};
use crate::name::BusName;

/// The process that owns a bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Owner {
    /// What it took the bus as.
    pub role: String,
    /// Its process id.
    pub pid: u32,
}

impl Owner {
    /// Who owns a bus, without a lock taken or a bus joined: so also of one whose owner says nothing. `None` if nobody does, or if
    /// it cannot be told.
    #[must_use]
    pub fn of(bus: &BusName) -> Option<Self> {
        let folder = Folder::of(bus).ok()?;
        let holder = FileLock::holder(&folder, OWNER_LOCK)?;
        Some(Self {
            role: holder.role,
            pid: holder.pid,
        })
    }
}

impl fmt::Display for Owner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (process {})", self.role, self.pid)
    }
}

/// The right to control the robot of one bus. Keep it as long as the daemon runs; it ends with the process.
#[derive(Debug)]
pub struct OwnerLock {
    pub(crate) folder: Folder,
    _lock: FileLock,
}

impl OwnerLock {
    /// Takes the bus, before anything else is opened on it. Does not wait.
    ///
    /// # Errors
    /// [`BusError::Owned`], naming the owner, if there is one.
    pub fn take(bus: &BusName, role: &str) -> Result<Self, BusError> {
        Self::take_at(&Folder::of(bus)?, role)
    }

    pub(crate) fn take_at(folder: &Folder, role: &str) -> Result<Self, BusError> {
        match FileLock::try_take(folder, OWNER_LOCK, role)? {
            Ok(lock) => Ok(Self {
                folder: folder.clone(),
                _lock: lock,
            }),
            Err(owner) => Err(BusError::Owned {
                bus: folder.bus.to_string(),
                pid: owner.pid,
                owned_s: now_ns().saturating_sub(owner.since_ns) / 1_000_000_000,
                role: owner.role,
            }),
        }
    }
}
