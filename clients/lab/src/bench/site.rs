//! Separate bus and folder of one measurement, removed on drop.

use std::path::Path;

use shm_bus::{BusName, FreshBus};

use atas_processes::logs::{self, Logs};

/// New bus and folder. Declare it before the processes and ports that use it.
pub(super) struct Site {
    bus: FreshBus,
    logs: Logs,
}

impl Site {
    pub(super) fn new() -> anyhow::Result<Self> {
        logs::remove_stale();
        let bus = FreshBus::new("bench");
        let logs = Logs::new(&bus)?;
        Ok(Self { bus, logs })
    }

    pub(super) fn bus(&self) -> &BusName {
        &self.bus
    }

    pub(super) fn folder(&self) -> &Path {
        &self.logs.folder
    }
}
