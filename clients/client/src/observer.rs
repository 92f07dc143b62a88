//! Observer: reads all data of the daemon's supervisor, newest first, and the timing of the ticks.
//!
//! Observers cost the tick nothing: one that starts, ends or hangs has no connection to the 1 kHz
//! loop.

use std::time::{Duration, Instant};

use shm_bus::{BusError, Subscriber};
use shm_schemas::{ModuleEvent, Status, TickReport, View, service};

use crate::Session;
use crate::histogram::Histogram;

/// Largest number of reports and events per poll.
const REPORTS_PER_POLL: usize = 1024;
/// Silence after which a daemon counts as gone. Design choice: 50 missing statuses.
const SILENCE: Duration = Duration::from_secs(1);

/// Data of an observer.
#[derive(Debug)]
pub struct Observer {
    statuses: Subscriber<Status>,
    reports: Subscriber<TickReport>,
    views: Subscriber<View>,
    events: Subscriber<ModuleEvent>,
    last_status: Instant,
    /// Newest status; process id 0 before the first.
    pub status: Status,
    /// Newest report.
    pub report: TickReport,
    /// Newest frames and joints.
    pub view: Box<View>,
    /// Wake-up delays of ticks.
    pub wake: Histogram,
    /// Durations of tick bodies.
    pub body: Histogram,
}

impl Observer {
    /// Subscribes to the data. The daemon may start and end at any time.
    ///
    /// # Errors
    /// All reader slots are in use.
    pub fn join(session: &Session) -> Result<Self, BusError> {
        let bus = session.bus();
        Ok(Self {
            statuses: bus.subscriber(service::STATUS)?,
            reports: bus.subscriber(service::TICK_REPORT)?,
            views: bus.subscriber(service::VIEW)?,
            events: bus.subscriber(service::MODULE_EVENT)?,
            last_status: Instant::now(),
            status: Status::default(),
            report: TickReport::default(),
            view: Box::default(),
            wake: Histogram::default(),
            body: Histogram::default(),
        })
    }

    /// Reads all new data. Calls the functions once per report and per event, reports first.
    ///
    /// # Errors
    /// The shared memory of the daemon cannot be read.
    pub fn poll(
        &mut self,
        mut each_report: impl FnMut(&TickReport),
        each_event: impl FnMut(&ModuleEvent),
    ) -> Result<(), BusError> {
        if self.statuses.newest(&mut self.status)? {
            self.last_status = Instant::now();
        }
        self.views.newest(&mut self.view)?;
        let Self {
            reports,
            report: newest,
            wake,
            body,
            ..
        } = self;
        reports.drain(REPORTS_PER_POLL, |report| {
            wake.add(report.wake_late_ns.into());
            body.add(body_ns(report));
            *newest = *report;
            each_report(report);
        })?;
        self.events.drain(REPORTS_PER_POLL, each_event)?;
        Ok(())
    }

    /// Returns true if a daemon reports.
    #[must_use]
    pub fn is_alive(&self) -> bool {
        self.status.pid != 0 && self.last_status.elapsed() < SILENCE
    }
}

/// Returns the time from wake-up to the published command, ns: all stages up to it.
#[must_use]
pub fn body_ns(report: &TickReport) -> u64 {
    const AFTER: [&str; 1] = ["recording"];
    let stages = TickReport::STAGE_NAMES.iter().zip(report.stage_ns);
    let counted = stages.filter(|(name, _)| !AFTER.contains(name));
    counted.map(|(_, ns)| u64::from(ns)).sum()
}
