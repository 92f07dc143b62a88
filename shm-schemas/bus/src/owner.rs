//! Exclusive ownership of a bus.

use std::fmt;

use crate::clock::now_ns;
use crate::error::BusError;
use crate::folder::Folder;
use crate::lock::{FileLock, OWNER_LOCK};
use crate::name::BusName;

/// Process that owns a bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Owner {
    /// Its role.
    pub role: String,
    /// Process id.
    pub pid: u32,
}

impl Owner {
    /// The owner of a bus; `None` if there is none or it cannot be determined. Needs no lock and no
    /// answer of the owner.
    #[must_use]
    pub fn find(bus: &BusName) -> Option<Self> {
        let folder = Folder::for_bus(bus).ok()?;
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
