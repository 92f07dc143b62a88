//! The link between the tick and the supervisor: orders one way, records the other. Bounded, wait-free, never waiting.
//!
//! ```text
//!  supervisor ── orders, stops ──▶ tick        every queue has one writer and one reader, so that neither can hold up
//!             ◀─ records, news ───             the other, whatever preempts whom
//!             ◀─ events, snapshot, view, input log ─
//!  stop listener ── signal ──────▶
//! ```
//!
//! * **Invariants:** what finds no room is counted. What somebody waits for, the answer to an order and the final update
//!   of a goal, always finds room: [`News`] has a queue of its own, with places that only those may use.
//! * **Absent on purpose:** queues with several writers. They are lock-free at best: a tick that preempts a writer on the
//!   same core would spin for ever.

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

/// Orders that wait; a goal that finds the queue full is refused as BUSY. Ours: the tick takes a thousand a second.
const ORDERS: usize = 32;
/// Stops that wait beside them, so that no flood of goals can hold up a stop.
const STOPS: usize = 4;
/// Ticks that the supervisor may fall behind before records are dropped: 1 s at 1 kHz.
const RECORDS: usize = 1024;
/// Events that wait.
const EVENTS: usize = 1024;
/// News that wait, and how many of the places are kept for what somebody waits for: every order that can wait can end a
/// goal and must be answered.
const NEWS: usize = 1024;
const NEWS_KEPT: usize = 2 * (ORDERS + STOPS) + 2;
/// What one tick leaves behind. Fixed size, no pointers.
#[derive(Clone, Copy, Debug, Default)]
pub struct TickRecord {
    /// The report, with its timings.
    pub report: TickReport,
    /// From wake-up to the published command, ns.
    pub body_ns: u32,
    /// Age of the newest frame of any hand, ns; `u64::MAX` if there never was one.
    pub frame_age_ns: u64,
    /// Whether every commanded velocity is zero.
    pub at_rest: bool,
    /// Commanded positions, rad, if there are any.
    pub commanded_rad: Option<RobotVector>,
    /// Calls to the bus that failed so far.
    pub bus_failures: u64,
    /// Whether the ticks are locked to the frames.
    pub phase_locked: bool,
}

/// What somebody waits for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum News {
    /// The order with this ticket was taken.
    Taken(u64),
    /// News of the goal.
    Goal(GoalUpdate),
}

/// An order with the number by which its effect is recognised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ticketed {
    /// From 1; 0 for an order that nobody waits for.
    pub ticket: u64,
    /// The order.
    pub order: Order,
}

/// What both ends count and see.
#[derive(Debug, Default)]
struct Shared {
    dropped: AtomicU64,
    quit: AtomicBool,
    /// When the supervisor last came round, ns; 0 before its first round.
    supervised_ns: AtomicU64,
    /// In lock-step: ticks since the start that may pass without anything to do.
    advanced_to: AtomicU64,
}

impl Shared {
    fn count(&self, dropped: u64) {
        if dropped > 0 {
            self.dropped.fetch_add(dropped, Ordering::Relaxed);
        }
    }
}

/// Ends the tick loop.
#[derive(Clone, Debug)]
pub struct Quit(Arc<Shared>);

impl Quit {
    /// Ends the tick loop before its next tick.
    pub fn quit(&self) {
        self.0.quit.store(true, Ordering::Release);
    }
}

/// A link; with `records`, it carries every tick's inputs for a recorder. `signal` brings the stops that have a way of
/// their own.
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
        // Every order that can wait is taken, and each ends a goal.
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
