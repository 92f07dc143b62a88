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
//! * Answers to requests and final goal updates always have room: [`News`] has reserved
//!   slots for them.
//! * Every queue has one writer and one reader. Queues with several writers are at best lock-free:
//!   a tick that preempts a writer on the same core would spin for ever.

mod supervisor;
mod tick;

pub use supervisor::SupervisorEnd;
pub use tick::TickEnd;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use atas_core::Order;
use robot_model::RobotVector;
use rtrb::RingBuffer;
use shm_bus::stop;
use shm_schemas::{GoalUpdate, Status, TickReport, View};

use crate::input_log;

/// Capacity for requests; a goal is rejected as BUSY if the queue is full. Design choice: the tick
/// takes 1000 per second.
const ORDERS: usize = 32;
/// Capacity for stops, separate so that goals cannot delay a stop.
const STOPS: usize = 4;
/// Capacity for records: 1 s at 1 kHz of supervisor delay before records are dropped.
const RECORDS: usize = 1024;
const EVENTS: usize = 1024;
/// Capacity for notifications, and the slots reserved for answers and final updates: every queued
/// request may end a goal and needs an answer.
const NEWS: usize = 1024;
const NEWS_KEPT: usize = 2 * (ORDERS + STOPS) + 2;
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
    /// Commanded positions, rad, if any.
    pub commanded_rad: Option<RobotVector>,
    /// Number of failed bus calls so far.
    pub bus_failures: u64,
    /// True if the ticks are phase-locked to the frames.
    pub phase_locked: bool,
}

/// Message that a client waits for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum News {
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
    pub order: Order,
}

#[derive(Debug, Default)]
struct Shared {
    dropped: AtomicU64,
    quit: AtomicBool,
    /// Time of the supervisor's last round, ns; 0 before the first.
    supervised_ns: AtomicU64,
    /// Lock-step: number of ticks since the start that may pass without work.
    advanced_to: AtomicU64,
}

impl Shared {
    fn count(&self, dropped: u64) {
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
pub fn link(records: bool, signal: Arc<stop::Signal>) -> (TickEnd, SupervisorEnd) {
    let (orders_in, orders) = RingBuffer::new(ORDERS);
    let (stops_in, stops) = RingBuffer::new(STOPS);
    let (records_in, records_out) = RingBuffer::new(RECORDS);
    let (news_in, news) = RingBuffer::new(NEWS);
    let (events_in, events) = RingBuffer::new(EVENTS);
    let (snapshot_in, snapshot) = triple_buffer::triple_buffer(&Status::default());
    let (view_in, view) = triple_buffer::triple_buffer(&View::default());
    let (log_in, log) = records.then(input_log::input_log).unzip();
    let shared = Arc::<Shared>::default();
    let tick = TickEnd {
        orders,
        stops,
        signal,
        signalled: None,
        records: records_in,
        news: news_in,
        events: events_in,
        snapshot: snapshot_in,
        view: view_in,
        input_log: log_in,
        shared: Arc::clone(&shared),
    };
    let supervisor = SupervisorEnd {
        orders: orders_in,
        stops: stops_in,
        tickets: 0,
        records: records_out,
        news,
        events,
        snapshot,
        view,
        input_log: log,
        shared,
    };
    (tick, supervisor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use atas_core::Order;
    use shm_schemas::{Cause, GoalState, ModuleEvent, Reason};

    use super::tick::SILENT_NS;

    fn ends() -> (TickEnd, SupervisorEnd) {
        link(false, Arc::default())
    }

    #[test]
    fn a_stop_overtakes_any_flood_and_the_world_that_settles() {
        let (mut tick, mut supervisor) = ends();
        let queued = (0..100)
            .filter(|_| supervisor.order(Order::Recover).is_some())
            .count();
        assert_eq!(queued, ORDERS);
        let stop = Order::Stop(Reason::of(Cause::SHUTDOWN));
        let ticket = supervisor.order(stop);
        assert!(ticket.is_some());
        let taken = tick.take_order(true).expect("the stop");
        assert_eq!((Some(taken.ticket), taken.order), (ticket, stop));
        assert_eq!(tick.take_order(true), None);
        assert_eq!(tick.take_order(false).map(|t| t.ticket), Some(1));
    }

    #[test]
    fn a_signalled_stop_comes_first_and_is_taken_when_its_command_is_out() {
        let signal = Arc::<stop::Signal>::default();
        let (mut tick, mut supervisor) = link(false, Arc::clone(&signal));
        assert!(supervisor.order(Order::Recover).is_some());
        let number = signal.raise();
        assert!(tick.has_orders());
        let taken = tick.take_order(true).expect("the stop");
        assert_eq!(taken.order, Order::Stop(Reason::of(Cause::ESTOP)));
        assert!(!signal.is_taken(number));
        tick.published();
        assert!(signal.is_taken(number));
        assert_eq!(
            tick.take_order(false).map(|t| t.order),
            Some(Order::Recover)
        );
    }

    #[test]
    fn a_million_orders_pass_in_their_order_while_both_ends_hurry() {
        const MANY: u64 = 1_000_000;
        let (mut tick, mut supervisor) = ends();
        std::thread::scope(|threads| {
            threads.spawn(move || {
                let mut taken = 0;
                while taken < MANY {
                    let ticket = tick.take_order(false).map_or(0, |order| order.ticket);
                    assert!(ticket == 0 || ticket == taken + 1, "{ticket} after {taken}");
                    taken += u64::from(ticket != 0);
                    tick.leave(&TickRecord::default(), &[]);
                    tick.leave_news(ticket, None);
                    if ticket == 0 {
                        std::thread::yield_now();
                    }
                }
            });
            let (mut given, mut answered) = (0, 0);
            while answered < MANY {
                let waits = given - answered < super::ORDERS as u64;
                if given < MANY && waits && supervisor.order(Order::Recover).is_some() {
                    given += 1;
                } else {
                    std::thread::yield_now();
                }
                while supervisor.next_record().is_some() {}
                while let Some(news) = supervisor.next_news() {
                    answered += 1;
                    assert_eq!(news, News::Taken(answered));
                }
            }
        });
    }

    #[test]
    fn what_finds_no_room_is_counted() {
        let (mut tick, supervisor) = ends();
        for _ in 0..RECORDS + 3 {
            tick.leave(&TickRecord::default(), &[]);
        }
        assert_eq!(supervisor.dropped(), 3);
        let events = [ModuleEvent::default(); EVENTS + 2];
        tick.leave(&TickRecord::default(), &events);
        assert_eq!(supervisor.dropped(), 3 + 1 + 2);
    }

    #[test]
    fn answers_and_final_updates_find_room_when_nothing_else_does() {
        let (mut tick, mut supervisor) = ends();
        let update = |state| GoalUpdate {
            state,
            ..GoalUpdate::default()
        };
        for _ in 0..2 * NEWS {
            let progress = update(GoalState::RUNNING);
            tick.leave_news(0, Some(&progress));
        }
        // Every queued request is executed and ends a goal.
        let orders = (ORDERS + STOPS) as u64;
        for ticket in 1..=orders {
            let ended = update(GoalState::FAILED);
            tick.leave_news(ticket, Some(&ended));
        }
        let (mut answers, mut ends) = (0, 0);
        while let Some(news) = supervisor.next_news() {
            match news {
                News::Taken(_) => answers += 1,
                News::Goal(update) => ends += u64::from(update.state.is_final()),
            }
        }
        assert_eq!((answers, ends), (orders, orders));
    }

    #[test]
    fn the_newest_snapshot_replaces_the_older_ones() {
        let (mut tick, mut supervisor) = ends();
        assert!(supervisor.newest_snapshot().is_none());
        for ticks in 1..10 {
            tick.leave_snapshot(&Status {
                ticks,
                ..Status::default()
            });
        }
        assert_eq!(supervisor.newest_snapshot().map(|s| s.ticks), Some(9));
        assert!(supervisor.newest_snapshot().is_none());
    }

    #[test]
    fn a_silent_supervisor_is_a_reason_to_hold() {
        let (tick, supervisor) = ends();
        let silent_at = |ns| tick.supervision(ns).cause;
        assert_eq!(silent_at(u64::MAX), Cause::NONE, "before its first round");
        supervisor.supervise(1_000);
        assert_eq!(silent_at(1_000 + SILENT_NS), Cause::NONE);
        assert_eq!(silent_at(1_001 + SILENT_NS), Cause::SUPERVISOR_SILENT);
        assert_eq!(silent_at(0), Cause::NONE, "a clock that both read");
    }
}
