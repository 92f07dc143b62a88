//! Unique bus for tests and demos.

use std::ops::Deref;

use crate::bus::Bus;
use crate::name::BusName;

/// Unique bus name whose bus is wiped on drop. Declare it before everything that uses it.
#[derive(Debug)]
pub struct FreshBus(BusName);

impl FreshBus {
    /// A unique bus; see [`BusName::fresh`].
    #[must_use]
    pub fn new(label: &str) -> Self {
        Self(BusName::fresh(label))
    }
}

impl Deref for FreshBus {
    type Target = BusName;

    fn deref(&self) -> &BusName {
        &self.0
    }
}

impl Drop for FreshBus {
    fn drop(&mut self) {
        if let Err(error) = Bus::wipe(&self.0) {
            tracing::warn!(bus = %self.0, %error, "could not wipe the bus");
        }
    }
}
