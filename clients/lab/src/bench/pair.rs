//! Daemon and simulator in real time on a separate bus.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::Context;
use atas_client::{POLL, Session};
use atas_console::Interrupt;
use shm_bus::{Subscriber, now_ns};
use shm_schemas::{Mode, Status, TickReport, service};

use super::site::Site;
use atas_processes::child::Child;

const READY_TIMEOUT: Duration = Duration::from_secs(15);
/// Delay between simulator and daemon start, so that the simulator's start does not affect the
/// measured start of the daemon.
const HEAD_START: Duration = Duration::from_millis(200);
const TICK_THREAD: &str = "atasd-tick";
/// Empty configuration: built-in defaults, independent of this machine's configuration.
pub(super) const NO_CONFIGURATION: [&str; 2] = ["--config", "/dev/null"];

/// Both processes and the ports of this process. Fields are dropped in this order.
pub(super) struct Pair {
    statuses: Subscriber<Status>,
    pub(super) reports: Subscriber<TickReport>,
    pub(super) status: Status,
    _session: Session,
    daemon: Child,
    simulator: Child,
    site: Site,
    started_ns: u64,
}

impl Pair {
    /// Starts both processes. `start_daemon` receives the site and the daemon's arguments.
    pub(super) fn start(
        flags: &[&str],
        start_daemon: impl FnOnce(&Site, &[&str]) -> anyhow::Result<Child>,
    ) -> anyhow::Result<Self> {
        let site = Site::new()?;
        let bus = site.bus().as_str();
        let simulate = ["run", "--bus", bus, "--object", "wood"];
        let simulator = Child::start("atas-sim", &simulate, site.folder())?;
        let session = Session::join(site.bus())?;
        let reports = session.bus().subscriber(service::TICK_REPORT)?;
        let statuses = session.bus().subscriber(service::STATUS)?;
        std::thread::sleep(HEAD_START);
        let control = [&["--bus", bus], &NO_CONFIGURATION[..], flags].concat();
        let started_ns = now_ns();
        let daemon = start_daemon(&site, &control)?;
        Ok(Self {
            statuses,
            reports,
            status: Status::default(),
            _session: session,
            daemon,
            simulator,
            site,
            started_ns,
        })
    }

    /// Waits until `wanted` holds; returns false after `limit`.
    pub(super) fn wait_until(
        &mut self,
        limit: Duration,
        interrupt: &Interrupt,
        wanted: impl Fn(&Status) -> bool,
    ) -> anyhow::Result<bool> {
        let begin = Instant::now();
        while !wanted(&self.status) && begin.elapsed() < limit {
            interrupt.check("the bench was waiting for the daemon")?;
            self.check()?;
            self.refresh()?;
            std::thread::sleep(POLL);
        }
        Ok(wanted(&self.status))
    }

    pub(super) fn wait_until_ready(&mut self, interrupt: &Interrupt) -> anyhow::Result<()> {
        let is_ready = |status: &Status| status.mode == Mode::READY;
        let ready = self.wait_until(READY_TIMEOUT, interrupt, is_ready)?;
        let status = &self.status;
        anyhow::ensure!(
            ready,
            "the daemon was not ready within {READY_TIMEOUT:?}: mode {} ({})",
            status.mode,
            status.reason
        );
        Ok(())
    }

    pub(super) fn refresh(&mut self) -> anyhow::Result<()> {
        self.statuses.newest(&mut self.status)?;
        Ok(())
    }

    pub(super) fn check(&mut self) -> anyhow::Result<()> {
        self.simulator.check().and_then(|()| self.daemon.check())
    }

    /// Returns the time from process start to the first tick, ns; `None` if the first report was
    /// missed.
    pub(super) fn first_tick_ns(&mut self) -> anyhow::Result<Option<u64>> {
        let mut first = None;
        self.reports.drain(1, |report| first = Some(*report))?;
        let first = first.filter(|report| report.tick == 0);
        Ok(first.map(|report| report.stamp.captured_ns.saturating_sub(self.started_ns)))
    }

    pub(super) fn site(&self) -> &Site {
        &self.site
    }

    pub(super) fn process(&self) -> PathBuf {
        PathBuf::from(format!("/proc/{}", self.daemon.pid()))
    }

    pub(super) fn tick_thread(&self) -> anyhow::Result<PathBuf> {
        let folder = self.process().join("task");
        let tasks = std::fs::read_dir(&folder)
            .with_context(|| format!("could not read {}", folder.display()))?;
        let is_tick = |path: &PathBuf| {
            std::fs::read_to_string(path.join("comm")).is_ok_and(|name| name.trim() == TICK_THREAD)
        };
        let mut paths = tasks.flatten().map(|task| task.path());
        paths
            .find(is_tick)
            .with_context(|| format!("could not find the thread {TICK_THREAD} of the daemon"))
    }
}
