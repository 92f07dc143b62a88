//! Process that owns a bus.

use std::fmt;

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
