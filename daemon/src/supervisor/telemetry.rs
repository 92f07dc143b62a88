//! Telemetry for observers: reports, events, status (50 Hz) and view (60 Hz).

use std::time::{Duration, Instant};

use shm_bus::{Bus, BusError, Publisher};
use shm_schemas::{ModuleEvent, Status, Text, TickReport, View, service};

use super::SupervisorState;
use crate::link::{SupervisorSide, TickRecord};
use crate::statistics::TickStatistics;

const STATUS_PERIOD: Duration = Duration::from_millis(20);

/// Publishers and the state that they add to the tick data.
#[derive(Debug)]
pub(super) struct Telemetry {
    status: Publisher<Status>,
    reports: Publisher<TickReport>,
    events: Publisher<ModuleEvent>,
    views: Publisher<View>,
    views_sent: u64,
    statistics: Option<TickStatistics>,
    snapshot: Status,
    sequence: u64,
    due: Instant,
}

impl Telemetry {
    pub(super) fn open(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            status: bus.publisher(service::STATUS)?,
            reports: bus.publisher(service::TICK_REPORT)?,
            events: bus.publisher(service::MODULE_EVENT)?,
            views: bus.publisher(service::VIEW)?,
            views_sent: 0,
            statistics: TickStatistics::new(),
            snapshot: Status::default(),
            sequence: 0,
            due: Instant::now(),
        })
    }

    pub(super) fn publish_record(&mut self, record: &TickRecord) {
        if let Some(figures) = &mut self.statistics {
            figures.record(record);
        }
        log_failure(self.reports.send(&record.report));
    }

    pub(super) fn publish_event(&mut self, event: &ModuleEvent) {
        log_failure(self.events.send(event));
    }

    pub(super) fn publish_view(&mut self, state: &SupervisorState, link: &mut SupervisorSide) {
        let Some(newest) = link.newest_view() else {
            return;
        };
        let sent = self.views.send_with(|view| {
            *view = *newest;
            view.stamp.sequence = self.views_sent;
            view.stamp.writer_epoch = state.sensor_setup.writer_epoch;
        });
        self.views_sent += 1;
        log_failure(sent);
    }

    /// Publishes the status that belongs to a notification, before the notification is forwarded.
    pub(super) fn publish_notified_status(
        &mut self,
        state: &SupervisorState,
        link: &mut SupervisorSide,
    ) {
        if let Some(snapshot) = link.newest_snapshot() {
            self.snapshot = snapshot;
            self.send_status(state, link);
        }
    }

    pub(super) fn publish_status(&mut self, state: &SupervisorState, link: &mut SupervisorSide) {
        // Before the snapshot, which then includes this stop.
        let stop = link.stop_signal().unshown();
        if let Some(snapshot) = link.newest_snapshot() {
            self.snapshot = snapshot;
        }
        if stop.is_none() && Instant::now() < self.due {
            // New readers get the last status within a round instead of a period.
            log_failure(self.status.connect_readers());
            return;
        }
        self.send_status(state, link);
        if let Some(number) = stop {
            link.stop_signal().show(number);
        }
        // New readers get the past events even if no event follows.
        log_failure(self.events.connect_readers());
    }

    fn send_status(&mut self, state: &SupervisorState, link: &SupervisorSide) {
        self.due = Instant::now() + STATUS_PERIOD;
        let mut status = self.snapshot;
        status.stamp.sequence = self.sequence;
        status.stamp.writer_epoch = state.sensor_setup.writer_epoch;
        status.version = Text::new(env!("CARGO_PKG_VERSION"));
        status.config_hash = state.config_hash;
        status.started_ns = state.clock_start_ns;
        status.pid = std::process::id();
        status.flags = state.flags;
        status.rate_hz = state.config.realtime.rate_hz;
        status.dropped_records = link.dropped();
        if let Some(figures) = &self.statistics {
            figures.write(&mut status);
        }
        self.sequence += 1;
        log_failure(self.status.send(&status));
    }
}

pub(super) fn log_failure(sent: Result<(), BusError>) {
    if let Err(error) = sent {
        tracing::debug!(%error, "could not publish to an observer");
    }
}
