//! Supervisor side of the link: queues requests, reads records.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use atas_core::OperatorRequest;
use rtrb::{Consumer, Producer};
use shm_bus::stop;
use shm_schemas::{ModuleEvent, Status, View};

use super::{Notification, Quit, Shared, TickRecord, Ticketed};
use crate::input_log::LogReader;

/// Supervisor side of the link.
#[derive(Debug)]
pub struct SupervisorSide {
    pub(super) requests: Producer<Ticketed>,
    pub(super) stops: Producer<Ticketed>,
    pub(super) tickets: u64,
    pub(super) records: Consumer<TickRecord>,
    pub(super) notifications: Consumer<Notification>,
    pub(super) events: Consumer<ModuleEvent>,
    pub(super) snapshot: triple_buffer::Output<Status>,
    pub(super) view: triple_buffer::Output<View>,
    pub(super) input_log: Option<LogReader>,
    pub(super) signal: Arc<stop::Signal>,
    pub(super) shared: Arc<Shared>,
}

impl SupervisorSide {
    /// Queues a request and returns its ticket, confirmed by [`Notification::Taken`]. `None` if the
    /// queue is full.
    #[must_use]
    pub fn request(&mut self, order: OperatorRequest) -> Option<u64> {
        let queue = if matches!(order, OperatorRequest::Stop(_)) {
            &mut self.stops
        } else {
            &mut self.requests
        };
        let ticket = self.tickets + 1;
        queue
            .push(Ticketed {
                ticket,
                request: order,
            })
            .ok()?;
        self.tickets = ticket;
        Some(ticket)
    }

    /// Records the time of a supervisor round.
    pub fn report_alive(&self, now_ns: u64) {
        self.shared
            .supervisor_alive_ns
            .store(now_ns, Ordering::Relaxed);
    }

    /// Lock-step: allows time to advance to this number of ticks since the start, also without
    /// work.
    pub fn advance_to(&self, ticks: u64) {
        self.shared.advanced_to.store(ticks, Ordering::Relaxed);
    }

    /// Signal of the stop socket.
    #[must_use]
    pub fn stop_signal(&self) -> &stop::Signal {
        &self.signal
    }

    /// The next record.
    #[must_use]
    pub fn next_record(&mut self) -> Option<TickRecord> {
        self.records.pop().ok()
    }

    /// The next notification.
    #[must_use]
    pub fn next_notification(&mut self) -> Option<Notification> {
        self.notifications.pop().ok()
    }

    /// The next event.
    #[must_use]
    pub fn next_event(&mut self) -> Option<ModuleEvent> {
        self.events.pop().ok()
    }

    /// The newest snapshot since the last call.
    #[must_use]
    pub fn newest_snapshot(&mut self) -> Option<Status> {
        self.snapshot
            .update()
            .then(|| *self.snapshot.output_buffer())
    }

    /// The newest view since the last call.
    #[must_use]
    pub fn newest_view(&mut self) -> Option<&View> {
        self.view.update().then(|| self.view.output_buffer())
    }

    /// The input log, if recording is on.
    #[must_use]
    pub fn input_log(&mut self) -> Option<&mut LogReader> {
        self.input_log.as_mut()
    }

    /// Moves the input log out, for another thread.
    #[must_use]
    pub fn take_input_log(&mut self) -> Option<LogReader> {
        self.input_log.take()
    }

    /// Records, notifications, events and input-log parts dropped because the supervisor was late.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        let parts = self.input_log.as_ref().map_or(0, LogReader::dropped);
        self.shared.dropped.load(Ordering::Relaxed) + parts
    }

    /// Handle that ends the tick loop.
    #[must_use]
    pub fn quit_handle(&self) -> Quit {
        Quit(Arc::clone(&self.shared))
    }
}
