//! Looking on: everything that the daemon's non-real-time side publishes, newest first, and how its ticks are timed.
//!
//! Nothing here costs the tick anything: an observer that comes, goes or hangs is no peer of the 1 kHz loop.

use std::time::{Duration, Instant};

use shm_bus::{BusError, Subscriber};
use shm_schemas::{ModuleEvent, Status, TickReport, View, service};

use crate::Session;
use crate::histogram::Histogram;

/// Most reports and events taken in one look: all that can wait.
const AT_ONCE: usize = 1024;
/// Silence after which a daemon counts as gone (ours: 50 missing statuses).
const SILENCE: Duration = Duration::from_secs(1);

/// What an observer knows.
#[derive(Debug)]
pub struct Watch {
    statuses: Subscriber<Status>,
    reports: Subscriber<TickReport>,
    views: Subscriber<View>,
    events: Subscriber<ModuleEvent>,
    heard: Instant,
    /// The newest status; of no process before the first.
    pub status: Status,
    /// The newest report.
    pub report: TickReport,
    /// The newest frames and joints.
    pub view: Box<View>,
    /// How late ticks began.
    pub wake: Histogram,
    /// How long their bodies took.
    pub body: Histogram,
}

impl Watch {
    /// Begins to look on. The daemon need not be there yet, and may come and go.
    ///
    /// # Errors
    /// All places for readers are taken.
    pub fn join(session: &Session) -> Result<Self, BusError> {
        let bus = session.bus();
        Ok(Self {
            statuses: bus.subscriber(service::STATUS)?,
            reports: bus.subscriber(service::TICK_REPORT)?,
            views: bus.subscriber(service::VIEW)?,
            events: bus.subscriber(service::MODULE_EVENT)?,
            heard: Instant::now(),
            status: Status::default(),
            report: TickReport::default(),
            view: Box::default(),
            wake: Histogram::default(),
            body: Histogram::default(),
        })
    }

    /// Takes in what has come since the last look; every report and every event is shown once, reports first.
    ///
    /// # Errors
    /// The shared memory of the daemon cannot be read.
    pub fn look(
        &mut self,
        mut each_report: impl FnMut(&TickReport),
        each_event: impl FnMut(&ModuleEvent),
    ) -> Result<(), BusError> {
        if self.statuses.newest(&mut self.status)? {
            self.heard = Instant::now();
        }
        self.views.newest(&mut self.view)?;
        let Self {
            reports,
            report: newest,
            wake,
            body,
            ..
        } = self;
        reports.drain(AT_ONCE, |report| {
            wake.add(report.wake_late_ns.into());
            body.add(body_ns(report));
            *newest = *report;
            each_report(report);
        })?;
        self.events.drain(AT_ONCE, each_event)?;
        Ok(())
    }

    /// Whether a daemon reports.
    #[must_use]
    pub fn is_alive(&self) -> bool {
        self.status.pid != 0 && self.heard.elapsed() < SILENCE
    }
}

/// From wake-up to the published command, ns: all stages but those behind it.
#[must_use]
pub fn body_ns(report: &TickReport) -> u64 {
    const AFTER: [&str; 1] = ["recording"];
    let stages = TickReport::STAGE_NAMES.iter().zip(report.stage_ns);
    let counted = stages.filter(|(name, _)| !AFTER.contains(name));
    counted.map(|(_, ns)| u64::from(ns)).sum()
}
