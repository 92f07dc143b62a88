//! Exclusive ownership of a bus.

use std::fs::File;

use crate::clock::now_ns;
use crate::end::{End, EndRecord};
use crate::error::BusError;
use crate::folder::Folder;
use crate::lock::{FileLock, OWNER_LOCK};
use crate::name::BusName;

/// Exclusive right to control the robot of one bus. Ends on drop or with the process.
///
/// ```
/// use shm_bus::{FreshBus, OwnerLock};
///
/// let name = FreshBus::new("docs");
/// let lock = OwnerLock::take(&name, "daemon")?;
/// assert!(OwnerLock::take(&name, "second daemon").is_err_and(|error| error.is_in_use()));
/// # drop(lock);
/// # Ok::<(), shm_bus::BusError>(())
/// ```
#[derive(Debug)]
pub struct OwnerLock {
    pub(crate) folder: Folder,
    /// Declared before the lock, which protects it.
    record: EndRecord,
    _lock: FileLock,
}

impl OwnerLock {
    /// Takes the bus without waiting. Call before opening anything on it.
    ///
    /// # Errors
    /// [`BusError::Owned`], naming the owner, if there is one.
    pub fn take(bus: &BusName, role: &str) -> Result<Self, BusError> {
        Self::take_at(&Folder::for_bus(bus)?, role)
    }

    /// The end of the former owner unless it was orderly.
    #[must_use]
    pub fn former_end(&self) -> Option<&End> {
        self.record.former()
    }

    /// Records why this process ends, if it does not end orderly. The first cause counts.
    pub fn record_end(&self, cause: &str) {
        self.record.append(cause);
    }

    /// File to which a signal handler appends the cause of an end, in one line.
    #[must_use]
    pub fn end_record(&self) -> &File {
        self.record.file()
    }

    pub(crate) fn take_at(folder: &Folder, role: &str) -> Result<Self, BusError> {
        let lock = Self::lock(folder, role)?;
        let record = EndRecord::begin(folder, role);
        Ok(Self {
            folder: folder.clone(),
            record: record.map_err(BusError::io("write a record in", &folder.path))?,
            _lock: lock,
        })
    }

    /// Takes the lock without a record of the end.
    pub(crate) fn lock(folder: &Folder, role: &str) -> Result<FileLock, BusError> {
        match FileLock::try_take(folder, OWNER_LOCK, role)? {
            Ok(lock) => Ok(lock),
            Err(owner) => Err(BusError::Owned {
                bus: folder.bus.to_string(),
                pid: owner.pid,
                owned_s: now_ns().saturating_sub(owner.since_ns) / 1_000_000_000,
                role: owner.role,
            }),
        }
    }
}
