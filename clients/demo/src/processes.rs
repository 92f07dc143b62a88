//! Processes of a demo: a separate bus, simulator, daemon, and logs.
//!
//! Dropping the value terminates the processes and removes the bus. Clients must have left the bus
//! by then: declare them after this value.

use std::path::Path;
use std::time::{Duration, Instant};

use atas_client::{POLL, Session};
use atas_console::Interrupt;
use atas_console::arguments::DemoOptions;
use shm_bus::{BusName, FreshBus};
use shm_schemas::{Mode, Status, service};

use atas_processes::Child;
use atas_processes::logs::{self, Logs};

/// Longest time until the daemon is ready (design choice: usually 150 ms; a loaded machine takes
/// longer).
const READY_TIMEOUT: Duration = Duration::from_secs(15);
/// Time that the daemon must be ready without interruption (design choice: ten status messages).
/// While two processes start, the clock advances unevenly and the daemon may hold in between.
const STEADY_FOR: Duration = Duration::from_millis(200);
/// Empty configuration file: built-in defaults, independent of this machine's configuration.
const NO_CONFIGURATION: &str = "/dev/null";

/// Running simulator and daemon. Fields are dropped in this order.
pub(crate) struct Processes {
    daemon: Child,
    simulator: Child,
    bus: FreshBus,
    logs: Logs,
}

impl Processes {
    pub(crate) fn start(scene: &[String], running: &DemoOptions) -> anyhow::Result<Self> {
        logs::remove_stale();
        let bus = FreshBus::new("demo");
        let logs = Logs::new(&bus)?;
        let (name, seed) = (bus.as_str(), running.seed.to_string());
        let robot = ["--robot", running.robot.as_str()];
        let mut simulate = vec!["run", "--bus", name, "--seed", &seed];
        simulate.extend(robot);
        simulate.extend(scene.iter().map(String::as_str));
        let mut control = vec!["--bus", name, "--config", NO_CONFIGURATION];
        control.extend(robot);
        if let Some(engine) = &running.engine {
            simulate.extend(["--engine", engine.as_str()]);
        }
        if running.vary {
            simulate.push("--vary");
        }
        if running.lockstep {
            simulate.push("--lockstep");
            control.push("--lockstep");
        }
        let simulator = Child::start("atas-sim", &simulate, &logs.folder)?;
        let daemon = Child::start("atasd", &control, &logs.folder)?;
        Ok(Self {
            daemon,
            simulator,
            bus,
            logs,
        })
    }

    pub(crate) fn bus(&self) -> &BusName {
        &self.bus
    }

    pub(crate) fn logs(&self) -> &Path {
        &self.logs.folder
    }

    /// Returns an error if a process has ended; keeps the logs in that case.
    pub(crate) fn check(&mut self) -> anyhow::Result<()> {
        let checked = self.simulator.check().and_then(|()| self.daemon.check());
        self.logs.keep |= checked.is_err();
        checked
    }

    pub(crate) fn wait_until_ready(
        &mut self,
        session: &Session,
        interrupt: &Interrupt,
    ) -> anyhow::Result<()> {
        let mut statuses = session.bus().subscriber::<Status>(service::STATUS)?;
        let mut status = Status::default();
        let begin = Instant::now();
        let mut unready = begin;
        while unready.elapsed() < STEADY_FOR {
            self.check()?;
            interrupt.check("the demo was interrupted during start-up")?;
            if begin.elapsed() > READY_TIMEOUT {
                self.logs.keep = true;
                anyhow::bail!(
                    "the daemon was not ready within {READY_TIMEOUT:?}: mode {} ({}); its log is in {}",
                    status.mode,
                    status.reason,
                    self.logs.folder.display()
                );
            }
            statuses.newest(&mut status)?;
            if status.mode != Mode::READY {
                unready = Instant::now();
            }
            std::thread::sleep(POLL);
        }
        Ok(())
    }
}
