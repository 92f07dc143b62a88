//! A bus of one's own, for tests and demos.

use std::ops::Deref;

use crate::bus::Bus;
use crate::name::BusName;

/// A bus name that nobody else uses, and whose bus is wiped when this is dropped: declare it before all that uses it.
#[derive(Debug)]
pub struct FreshBus(BusName);

impl FreshBus {
    /// A fresh bus; see [`BusName::fresh`].
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
            tracing::warn!(bus = %self.0, %error, "left a bus behind");
        }
    }
}
