//! One daemon per bus.

use crate::clock::now_ns;
use crate::error::BusError;
use crate::folder::Folder;
use crate::lock::{FileLock, OWNER_LOCK};
use crate::name::BusName;

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
