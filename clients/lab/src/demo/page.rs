//! Dashboard of a demo: the demo waits until the page is open, and keeps running until Ctrl-C.

use std::path::Path;
use std::time::Duration;

use atas_console::{Interrupt, Progress};
use serde_json::Value;
use shm_bus::BusName;

use super::child::Child;

/// Poll interval (design choice: imperceptible to a person).
const LOOK: Duration = Duration::from_millis(50);

pub(super) struct Page {
    server: Child,
}

impl Page {
    pub(super) fn serve(bus: &BusName, logs: &Path) -> anyhow::Result<Self> {
        let name = bus.as_str();
        let arguments = [
            "dashboard",
            "--bus",
            name,
            "--port",
            "0",
            "--format",
            "json",
        ];
        Ok(Self {
            server: Child::start("atas-live", &arguments, logs)?,
        })
    }

    pub(super) fn wait_until_open(
        &mut self,
        live: &mut Progress,
        interrupt: &Interrupt,
    ) -> anyhow::Result<()> {
        let url = self.wait_for(interrupt, |said| Some(said["url"].as_str()?.to_owned()))?;
        live.say(&format!("open {url} in a browser"));
        live.note("waits for the page to open");
        self.wait_for(interrupt, |said| {
            said["pages"].as_u64().filter(|pages| *pages > 0)
        })?;
        Ok(())
    }

    /// Waits for a signal; processes keep running.
    pub(super) fn stay(
        &mut self,
        live: &mut Progress,
        interrupt: &Interrupt,
    ) -> anyhow::Result<()> {
        live.note("done; everything stays as it is until Ctrl-C");
        while !interrupt.is_set() {
            self.server.check()?;
            std::thread::sleep(LOOK);
        }
        Ok(())
    }

    /// Waits for a line of the server in which `find` succeeds.
    fn wait_for<T>(
        &mut self,
        interrupt: &Interrupt,
        find: impl Fn(&Value) -> Option<T>,
    ) -> anyhow::Result<T> {
        loop {
            self.server.check()?;
            interrupt.check("the demo ended its processes and wiped its bus")?;
            let lines = self.server.results();
            let said = lines
                .iter()
                .filter_map(|line| serde_json::from_str(line).ok());
            if let Some(found) = said.into_iter().find_map(|said| find(&said)) {
                return Ok(found);
            }
            std::thread::sleep(LOOK);
        }
    }
}
