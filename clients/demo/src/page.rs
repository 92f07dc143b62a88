//! Dashboard of a demo: the demo waits until the page is open, and keeps running until Ctrl-C.

use std::path::Path;
use std::time::Duration;

use atas_console::{Interrupt, Progress};
use serde_json::Value;
use shm_bus::BusName;

use atas_processes::Child;

/// Poll interval (design choice: imperceptible to a person).
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Running dashboard server.
pub struct Page {
    server: Child,
}

impl Page {
    /// Starts `atas-live dashboard` for a bus.
    ///
    /// # Errors
    /// The program `atas-live` is missing or did not start.
    pub fn serve(bus: &BusName, logs: &Path) -> anyhow::Result<Self> {
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

    /// Prints the address and waits until a browser shows the page.
    ///
    /// # Errors
    /// The server ended, or the user interrupted.
    pub fn wait_until_open(
        &mut self,
        live: &mut Progress,
        interrupt: &Interrupt,
    ) -> anyhow::Result<()> {
        let url = self.wait_for(interrupt, |message| {
            Some(message["url"].as_str()?.to_owned())
        })?;
        live.print(&format!("open {url} in a browser"));
        live.show_activity("waiting for the page to open");
        self.wait_for(interrupt, |message| {
            message["pages"].as_u64().filter(|pages| *pages > 0)
        })?;
        Ok(())
    }

    /// Waits for a signal; processes keep running.
    ///
    /// # Errors
    /// The server ended.
    pub fn keep_running(
        &mut self,
        live: &mut Progress,
        interrupt: &Interrupt,
    ) -> anyhow::Result<()> {
        live.show_activity("done; processes keep running until Ctrl-C");
        while !interrupt.is_set() {
            self.server.check()?;
            std::thread::sleep(POLL_INTERVAL);
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
            interrupt.check("the demo terminated its processes and removed its bus")?;
            let lines = self.server.results();
            let message = lines
                .iter()
                .filter_map(|line| serde_json::from_str(line).ok());
            if let Some(found) = message.into_iter().find_map(|message| find(&message)) {
                return Ok(found);
            }
            std::thread::sleep(POLL_INTERVAL);
        }
    }
}
