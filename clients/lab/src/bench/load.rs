//! Background load during measurements (Debian package stress-ng).

use std::path::Path;
use std::time::Duration;

use super::Plan;
use super::site::Site;
use super::tool::{self, Notes};
use atas_processes::child::Child;

/// Longest duration of a measurement beyond its windows.
const GRACE: Duration = Duration::from_secs(40);
const START_DELAY: Duration = Duration::from_millis(300);

/// One computing and one memory-moving worker on the core of the ticks. Ends on drop.
pub(super) struct Load {
    _child: Child,
    _site: Site,
}

impl Load {
    /// Starts the load; returns `None` and adds a note if it cannot run.
    pub(super) fn start(plan: &Plan<'_>, notes: &mut Notes) -> anyhow::Result<Option<Self>> {
        let site = Site::new()?;
        let core = plan.core.to_string();
        let limit = format!("{}s", (3 * plan.window + GRACE).as_secs());
        let arguments = [
            "--cpu",
            "1",
            "--vm",
            "1",
            "--vm-bytes",
            "64M",
            "--taskset",
            &core,
            "--timeout",
            &limit,
            "--quiet",
        ];
        let cure = "apt-get install stress-ng; without it nothing is measured under load";
        let program = Path::new("stress-ng");
        let child = tool::start(program, "stress-ng", cure, &arguments, site.folder(), notes)?;
        let Some(mut child) = child else {
            return Ok(None);
        };
        std::thread::sleep(START_DELAY);
        if child.exit_status()?.is_some() {
            let message = child.tail();
            notes.add(format!(
                "stress-ng failed ({}); nothing is measured under load",
                message.trim()
            ));
            return Ok(None);
        }
        Ok(Some(Self {
            _child: child,
            _site: site,
        }))
    }
}
