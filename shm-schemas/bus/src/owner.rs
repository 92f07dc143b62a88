//! One daemon per bus.

use crate::lock::{FileLock, OWNER_LOCK};
use crate::root::Place;
use crate::{BusError, BusName, now_ns};

/// The right to control the robot of one bus. Keep it as long as the daemon runs; it ends with the process.
#[derive(Debug)]
pub struct OwnerLock {
    _lock: FileLock,
}

impl OwnerLock {
    /// Takes the bus, before anything else is opened on it. Does not wait.
    ///
    /// # Errors
    /// [`BusError::Owned`], naming the owner, if there is one.
    pub fn take(bus: &BusName, role: &str) -> Result<Self, BusError> {
        Self::take_at(&Place::of(bus)?, role)
    }

    pub(crate) fn take_at(place: &Place, role: &str) -> Result<Self, BusError> {
        match FileLock::try_take(place, OWNER_LOCK, role)? {
            Ok(lock) => Ok(Self { _lock: lock }),
            Err(owner) => Err(BusError::Owned {
                bus: place.bus.to_string(),
                pid: owner.pid,
                owned_s: now_ns().saturating_sub(owner.since_ns) / 1_000_000_000,
                role: owner.role,
            }),
        }
    }
}
