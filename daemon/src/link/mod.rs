//! Link between tick and supervisor: requests one way, records the other. Bounded and wait-free.
//!
//! ```text
//!  supervisor ── requests, stops ──▶ tick
//!             ◀─ records, notifications, events, snapshot, view, input log ─
//!  stop listener ── signal ────────▶
//! ```
//!
//! Invariants:
//! * Entries without room are dropped and counted.
//! * Answers to requests and final goal updates always have room: [`Notification`] has reserved
//!   slots for them.
//! * Every queue has one writer and one reader. Queues with several writers are at best lock-free:
//!   a tick that preempts a writer on the same core would spin for ever.

mod supervisor;
mod tick;

pub use supervisor::SupervisorSide;
pub use tick::RealtimeSide;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use atas_core::OperatorRequest;
use robot_model::RobotVector;
use rtrb::RingBuffer;
use shm_bus::stop;
use shm_schemas::{GoalUpdate, Status, TickReport, View};

use crate::input_log;

/// Capacity for requests, of 48 kB in locked memory; a goal is rejected as BUSY if the queue is
/// full. Design choice: the tick takes 1000 per second.
const REQUESTS: usize = 16;
/// Capacity for stops, separate so that goals cannot delay a stop.
const STOPS: usize = 4;
/// Capacity for records: 1 s at 1 kHz of supervisor delay before records are dropped.
const RECORDS: usize = 1024;
const EVENTS: usize = 1024;
/// Capacity for notifications, and the slots reserved for answers and final updates: every queued
/// request may end a goal and needs an answer.
const NOTIFICATIONS: usize = 1024;
const NOTIFICATIONS_RESERVED: usize = 2 * (REQUESTS + STOPS) + 2;
/// Record of one tick. Fixed size, no pointers.
#[derive(Clone, Copy, Debug, Default)]
pub struct TickRecord {
    /// Report with timings.
    pub report: TickReport,
    /// Time from wake-up to the published command, ns.
    pub body_ns: u32,
    /// Age of the newest frame of any hand, ns; `u64::MAX` if there is none.
    pub frame_age_ns: u64,
    /// True if every commanded velocity is zero.
    pub at_rest: bool,
    /// Commanded positions, rad or m, if any.
    pub commanded_position: Option<RobotVector>,
    /// Number of failed bus calls so far.
    pub bus_failures: u64,
    /// True if the ticks are phase-locked to the frames.
    pub phase_locked: bool,
}

/// Message that a client waits for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Notification {
    /// The request with this ticket was executed.
    Taken(u64),
    /// Goal update.
    Goal(GoalUpdate),
}

/// Request with the ticket that identifies its answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ticketed {
    /// From 1; 0 for a request without an answer.
    pub ticket: u64,
    /// The request.
    pub request: OperatorRequest,
}

#[derive(Debug, Default)]
struct Shared {
    dropped: AtomicU64,
    quit: AtomicBool,
    /// Time of the supervisor's last round, ns; 0 before the first.
    supervisor_alive_ns: AtomicU64,
    /// Lock-step: number of ticks since the start that may pass without work.
    advanced_to: AtomicU64,
}

impl Shared {
    fn count_dropped(&self, dropped: u64) {
        if dropped > 0 {
            self.dropped.fetch_add(dropped, Ordering::Relaxed);
        }
    }
}

/// Handle that ends the tick loop.
#[derive(Clone, Debug)]
pub struct Quit(Arc<Shared>);

impl Quit {
    /// Ends the tick loop before its next tick.
    pub fn quit(&self) {
        self.0.quit.store(true, Ordering::Release);
    }
}

/// Creates a link. `records` adds the input log for a recorder; `signal` carries stops from the
/// stop socket.
#[must_use]
pub fn link(records: bool, signal: Arc<stop::Signal>) -> (RealtimeSide, SupervisorSide) {
    let (orders_in, orders) = RingBuffer::new(REQUESTS);
    let (stops_in, stops) = RingBuffer::new(STOPS);
    let (records_in, records_out) = RingBuffer::new(RECORDS);
    let (news_in, news) = RingBuffer::new(NOTIFICATIONS);
    let (events_in, events) = RingBuffer::new(EVENTS);
    let (snapshot_in, snapshot) = triple_buffer::triple_buffer(&Status::default());
    let (view_in, view) = triple_buffer::triple_buffer(&View::default());
    let (log_in, log) = records.then(input_log::input_log).unzip();
    let shared = Arc::<Shared>::default();
    let tick = RealtimeSide {
        requests: orders,
        stops,
        signal: Arc::clone(&signal),
        signalled_stop: None,
        records: records_in,
        notifications: news_in,
        events: events_in,
        snapshot: snapshot_in,
        view: view_in,
        input_log: log_in,
        shared: Arc::clone(&shared),
    };
    let supervisor = SupervisorSide {
        requests: orders_in,
        stops: stops_in,
        tickets: 0,
        records: records_out,
        notifications: news,
        events,
        snapshot,
        view,
        input_log: log,
        signal,
        shared,
    };
    (tick, supervisor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use atas_core::OperatorRequest;
    use shm_schemas::{GoalState, ModuleEvent, Reason};

    use super::tick::SUPERVISOR_TIMEOUT_NS;

    fn sides() -> (RealtimeSide, SupervisorSide) {
        link(false, Arc::default())
    }

    #[test]
    fn stop_overtakes_queue_and_settling() {
        let (mut tick, mut supervisor) = sides();
        let queued = (0..100)
            .filter(|_| supervisor.request(OperatorRequest::Recover).is_some())
            .count();
        assert_eq!(queued, REQUESTS);
        let stop = OperatorRequest::Stop(Reason::Shutdown);
        let ticket = supervisor.request(stop);
        assert!(ticket.is_some());
        let taken = tick.take_request(true).expect("the stop");
        assert_eq!((Some(taken.ticket), taken.request), (ticket, stop));
        assert_eq!(tick.take_request(true), None);
        assert_eq!(tick.take_request(false).map(|t| t.ticket), Some(1));
    }

    #[test]
    fn signalled_stop_is_confirmed_after_publishing() {
        let signal = Arc::<stop::Signal>::default();
        let (mut tick, mut supervisor) = link(false, Arc::clone(&signal));
        assert!(supervisor.request(OperatorRequest::Recover).is_some());
        let number = signal.raise();
        assert!(tick.has_requests());
        let taken = tick.take_request(true).expect("the stop");
        assert_eq!(taken.request, OperatorRequest::Stop(Reason::Estop));
        // Without a published command it stays pending, before all other requests.
        tick.confirm_stop(false);
        assert!(!signal.is_taken(number));
        assert_eq!(
            tick.take_request(true).map(|t| t.request),
            Some(taken.request)
        );
        tick.confirm_stop(true);
        assert!(signal.is_taken(number));
        assert_eq!(
            tick.take_request(false).map(|t| t.request),
            Some(OperatorRequest::Recover)
        );
    }

    #[test]
    fn million_requests_pass_in_order() {
        const MANY: u64 = 1_000_000;
        let (mut tick, mut supervisor) = sides();
        std::thread::scope(|threads| {
            threads.spawn(move || {
                let mut taken = 0;
                while taken < MANY {
                    let ticket = tick.take_request(false).map_or(0, |order| order.ticket);
                    assert!(ticket == 0 || ticket == taken + 1, "{ticket} after {taken}");
                    taken += u64::from(ticket != 0);
                    tick.push_record(&TickRecord::default(), &[]);
                    tick.push_notifications(ticket, None);
                    if ticket == 0 {
                        std::thread::yield_now();
                    }
                }
            });
            let (mut given, mut answered) = (0, 0);
            while answered < MANY {
                let waits = given - answered < super::REQUESTS as u64;
                if given < MANY && waits && supervisor.request(OperatorRequest::Recover).is_some() {
                    given += 1;
                } else {
                    std::thread::yield_now();
                }
                while supervisor.next_record().is_some() {}
                while let Some(news) = supervisor.next_notification() {
                    answered += 1;
                    assert_eq!(news, Notification::Taken(answered));
                }
            }
        });
    }

    #[test]
    fn dropped_entries_are_counted() {
        let (mut tick, supervisor) = sides();
        for _ in 0..RECORDS + 3 {
            tick.push_record(&TickRecord::default(), &[]);
        }
        assert_eq!(supervisor.dropped(), 3);
        let events = [ModuleEvent::default(); EVENTS + 2];
        tick.push_record(&TickRecord::default(), &events);
        assert_eq!(supervisor.dropped(), 3 + 1 + 2);
    }

    #[test]
    fn answers_and_final_updates_have_reserved_slots() {
        let (mut tick, mut supervisor) = sides();
        let update = |state| GoalUpdate {
            state,
            ..GoalUpdate::default()
        };
        for _ in 0..2 * NOTIFICATIONS {
            let progress = update(GoalState::RUNNING);
            tick.push_notifications(0, Some(&progress));
        }
        // Every queued request is executed and ends a goal.
        let orders = (REQUESTS + STOPS) as u64;
        for ticket in 1..=orders {
            let ended = update(GoalState::FAILED);
            tick.push_notifications(ticket, Some(&ended));
        }
        let (mut answers, mut sides) = (0, 0);
        while let Some(news) = supervisor.next_notification() {
            match news {
                Notification::Taken(_) => answers += 1,
                Notification::Goal(update) => sides += u64::from(update.state.is_final()),
            }
        }
        assert_eq!((answers, sides), (orders, orders));
    }

    #[test]
    fn newest_snapshot_replaces_older_ones() {
        let (mut tick, mut supervisor) = sides();
        assert!(supervisor.newest_snapshot().is_none());
        for ticks in 1..10 {
            tick.push_snapshot(&Status {
                ticks,
                ..Status::default()
            });
        }
        assert_eq!(supervisor.newest_snapshot().map(|s| s.ticks), Some(9));
        assert!(supervisor.newest_snapshot().is_none());
    }

    #[test]
    fn silent_supervisor_causes_hold() {
        let (tick, supervisor) = sides();
        let silent_at = |ns| tick.supervisor_timeout(ns);
        assert_eq!(silent_at(u64::MAX), Reason::None, "before its first round");
        supervisor.report_alive(1_000);
        assert_eq!(silent_at(1_000 + SUPERVISOR_TIMEOUT_NS), Reason::None);
        assert!(matches!(
            silent_at(1_001 + SUPERVISOR_TIMEOUT_NS),
            Reason::SupervisorSilent { .. }
        ));
        assert_eq!(silent_at(0), Reason::None, "time before the last round");
    }
}
