//! Tick side of the link: takes requests, pushes records, never waits.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use atas_core::OperatorRequest;
use rtrb::{Consumer, Producer};
use shm_bus::stop;
use shm_schemas::{GoalUpdate, ModuleEvent, Reason, Status, View};

use super::{NOTIFICATIONS_RESERVED, Notification, Shared, TickRecord, Ticketed};
use crate::input_log::LogWriter;

/// Silence of the supervisor after which the robot holds, ns. Without it there is no monitoring,
/// status or request handling. Design choice: about 100 rounds.
pub(super) const SUPERVISOR_TIMEOUT_NS: u64 = 500_000_000;

/// Tick side of the link.
#[derive(Debug)]
pub struct RealtimeSide {
    pub(super) requests: Consumer<Ticketed>,
    pub(super) stops: Consumer<Ticketed>,
    pub(super) signal: Arc<stop::Signal>,
    /// Number of the stop that this tick takes from the signal.
    pub(super) signalled_stop: Option<u64>,
    pub(super) records: Producer<TickRecord>,
    pub(super) notifications: Producer<Notification>,
    pub(super) events: Producer<ModuleEvent>,
    pub(super) snapshot: triple_buffer::Input<Status>,
    pub(super) view: triple_buffer::Input<View>,
    pub(super) input_log: Option<LogWriter>,
    pub(super) shared: Arc<Shared>,
}

impl RealtimeSide {
    /// The request for this tick: stops first, then the others in order, except while the lock-step
    /// world is settling.
    #[must_use]
    pub fn take_request(&mut self, settling: bool) -> Option<Ticketed> {
        self.signalled_stop = self.signal.pending();
        if self.signalled_stop.is_some() {
            let order = OperatorRequest::Stop(Reason::Estop);
            return Some(Ticketed {
                ticket: 0,
                request: order,
            });
        }
        self.stops.pop().ok().or_else(|| {
            if settling {
                None
            } else {
                self.requests.pop().ok()
            }
        })
    }

    /// Returns true if this tick takes a stop from the signal.
    #[must_use]
    pub fn takes_stop(&self) -> bool {
        self.signalled_stop.is_some()
    }

    /// Confirms a stop from the signal if the tick's command was published. Otherwise the next tick
    /// takes it again, and the sender waits.
    pub fn confirm_stop(&mut self, published: bool) {
        if let Some(number) = self.signalled_stop.take().filter(|_| published) {
            self.signal.take(number);
        }
    }

    /// Returns true if a request is waiting.
    #[must_use]
    pub fn has_requests(&self) -> bool {
        self.signal.pending().is_some() || !self.stops.is_empty() || !self.requests.is_empty()
    }

    /// Number of ticks since the start up to which lock-step time may advance without work.
    #[must_use]
    pub fn advanced_to(&self) -> u64 {
        self.shared.advanced_to.load(Ordering::Relaxed)
    }

    /// Reason to hold at `now_ns` if the supervisor has been silent for too long.
    #[must_use]
    pub fn supervisor_timeout(&self, now_ns: u64) -> Reason {
        let supervised_ns = self.shared.supervisor_alive_ns.load(Ordering::Relaxed);
        let silent_ns = now_ns.saturating_sub(supervised_ns);
        if supervised_ns == 0 || silent_ns <= SUPERVISOR_TIMEOUT_NS {
            return Reason::None;
        }
        let s = |ns: u64| ns as f64 * 1e-9;
        Reason::SupervisorSilent {
            silent_s: s(silent_ns),
            limit_s: s(SUPERVISOR_TIMEOUT_NS),
        }
    }

    /// Returns true if there is room to record another tick, or if recording is off.
    #[must_use]
    pub fn has_room(&self) -> bool {
        self.input_log.as_ref().is_none_or(LogWriter::has_room)
    }

    /// The input log, if recording is on.
    #[must_use]
    pub fn input_log(&mut self) -> Option<&mut LogWriter> {
        self.input_log.as_mut()
    }

    /// Pushes a record and its events.
    pub fn push_record(&mut self, record: &TickRecord, events: &[ModuleEvent]) {
        let mut dropped = u64::from(self.records.push(*record).is_err());
        for event in events {
            dropped += u64::from(self.events.push(*event).is_err());
        }
        self.shared.count_dropped(dropped);
    }

    /// Pushes the ticket of the executed request (0 if none) and the goal update.
    pub fn push_notifications(&mut self, ticket: u64, update: Option<&GoalUpdate>) {
        let mut dropped = 0;
        if ticket != 0 {
            dropped += u64::from(
                self.notifications
                    .push(Notification::Taken(ticket))
                    .is_err(),
            );
        }
        if let Some(update) = update {
            let has_room =
                update.state.is_final() || self.notifications.slots() > NOTIFICATIONS_RESERVED;
            let left = has_room && self.notifications.push(Notification::Goal(*update)).is_ok();
            dropped += u64::from(!left);
        }
        self.shared.count_dropped(dropped);
    }

    /// Publishes a snapshot; it replaces an unread one.
    pub fn push_snapshot(&mut self, snapshot: &Status) {
        self.snapshot.write(*snapshot);
    }

    /// Publishes a view written in place by `fill`; it replaces an unread one.
    pub fn push_view(&mut self, fill: impl FnOnce(&mut View)) {
        fill(self.view.input_buffer_mut());
        self.view.publish();
    }

    /// Returns true if the loop must end.
    #[must_use]
    pub fn is_quitting(&self) -> bool {
        self.shared.quit.load(Ordering::Acquire)
    }
}
