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

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use atas_core::Order;
use robot_model::RobotVector;
use rtrb::{Consumer, Producer, RingBuffer};
use shm_bus::stop;
use shm_schemas::{Cause, GoalUpdate, ModuleEvent, Reason, Status, TickReport, View};

use crate::input_log::{self, LogReader, LogWriter};

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
/// Silence of the supervisor after which the robot holds, ns: whoever watches over the robot, tells its users and takes
/// their orders is not there. Ours: a hundred rounds.
const SILENT_NS: u64 = 500_000_000;

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
}

impl Shared {
    fn count(&self, dropped: u64) {
        if dropped > 0 {
            self.dropped.fetch_add(dropped, Ordering::Relaxed);
        }
    }
}

/// The tick's end.
#[derive(Debug)]
pub struct TickEnd {
    orders: Consumer<Ticketed>,
    stops: Consumer<Ticketed>,
    signal: Arc<stop::Signal>,
    /// The stop that this tick takes by the signal.
    signalled: Option<u64>,
    records: Producer<TickRecord>,
    news: Producer<News>,
    events: Producer<ModuleEvent>,
    snapshot: triple_buffer::Input<Status>,
    view: triple_buffer::Input<View>,
    input_log: Option<LogWriter>,
    shared: Arc<Shared>,
}

/// The supervisor's end.
#[derive(Debug)]
pub struct SupervisorEnd {
    orders: Producer<Ticketed>,
    stops: Producer<Ticketed>,
    tickets: u64,
    records: Consumer<TickRecord>,
    news: Consumer<News>,
    events: Consumer<ModuleEvent>,
    snapshot: triple_buffer::Output<Status>,
    view: triple_buffer::Output<View>,
    input_log: Option<LogReader>,
    shared: Arc<Shared>,
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

impl SupervisorEnd {
    /// Queues an order; its ticket comes back as [`News::Taken`]. `None` if the queue is full.
    #[must_use]
    pub fn order(&mut self, order: Order) -> Option<u64> {
        let queue = if matches!(order, Order::Stop(_)) {
            &mut self.stops
        } else {
            &mut self.orders
        };
        let ticket = self.tickets + 1;
        queue.push(Ticketed { ticket, order }).ok()?;
        self.tickets = ticket;
        Some(ticket)
    }

    /// Says that the supervisor has come round.
    pub fn supervise(&self, now_ns: u64) {
        self.shared.supervised_ns.store(now_ns, Ordering::Relaxed);
    }

    /// The next record.
    #[must_use]
    pub fn next_record(&mut self) -> Option<TickRecord> {
        self.records.pop().ok()
    }

    /// The next piece of news.
    #[must_use]
    pub fn next_news(&mut self) -> Option<News> {
        self.news.pop().ok()
    }

    /// The next event.
    #[must_use]
    pub fn next_event(&mut self) -> Option<ModuleEvent> {
        self.events.pop().ok()
    }

    /// The newest snapshot, if there is one since the last call.
    #[must_use]
    pub fn newest_snapshot(&mut self) -> Option<Status> {
        self.snapshot
            .update()
            .then(|| *self.snapshot.output_buffer())
    }

    /// The newest view, if there is one since the last call.
    #[must_use]
    pub fn newest_view(&mut self) -> Option<&View> {
        self.view.update().then(|| self.view.output_buffer())
    }

    /// The input log, if recording is switched on.
    #[must_use]
    pub fn input_log(&mut self) -> Option<&mut LogReader> {
        self.input_log.as_mut()
    }

    /// Takes the input log out, for a thread of its own.
    #[must_use]
    pub fn take_input_log(&mut self) -> Option<LogReader> {
        self.input_log.take()
    }

    /// Records, news, events and parts of the input log dropped because the supervisor did not come round.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        let parts = self.input_log.as_ref().map_or(0, LogReader::dropped);
        self.shared.dropped.load(Ordering::Relaxed) + parts
    }

    /// What ends the tick loop.
    #[must_use]
    pub fn quit_handle(&self) -> Quit {
        Quit(Arc::clone(&self.shared))
    }
}

impl TickEnd {
    /// The order for this tick: a stop first, then the others in their order, unless the world still settles.
    #[must_use]
    pub fn take_order(&mut self, settling: bool) -> Option<Ticketed> {
        self.signalled = self.signal.pending();
        if self.signalled.is_some() {
            let order = Order::Stop(Reason::of(Cause::ESTOP));
            return Some(Ticketed { ticket: 0, order });
        }
        self.stops.pop().ok().or_else(|| {
            if settling {
                None
            } else {
                self.orders.pop().ok()
            }
        })
    }

    /// The command of the tick is out: a stop that came by the signal is in it.
    pub fn published(&mut self) {
        if let Some(number) = self.signalled.take() {
            self.signal.take(number);
        }
    }

    /// Whether an order waits.
    #[must_use]
    pub fn has_orders(&self) -> bool {
        self.signal.pending().is_some() || !self.stops.is_empty() || !self.orders.is_empty()
    }

    /// Why the robot must hold at `now_ns`, if the supervisor has been silent for too long.
    #[must_use]
    pub fn supervision(&self, now_ns: u64) -> Reason {
        let supervised_ns = self.shared.supervised_ns.load(Ordering::Relaxed);
        let silent_ns = now_ns.saturating_sub(supervised_ns);
        if supervised_ns == 0 || silent_ns <= SILENT_NS {
            return Reason::default();
        }
        let s = |ns: u64| ns as f64 * 1e-9;
        Reason::limit(Cause::SUPERVISOR_SILENT, s(silent_ns), s(SILENT_NS))
    }

    /// Whether another tick can be recorded without hurry; always, if recording is switched off.
    #[must_use]
    pub fn has_room(&self) -> bool {
        self.input_log.as_ref().is_none_or(LogWriter::has_room)
    }

    /// The input log, if recording is switched on.
    #[must_use]
    pub fn input_log(&mut self) -> Option<&mut LogWriter> {
        self.input_log.as_mut()
    }

    /// Leaves a record, the ticket of the order that was taken (0 if none), and what happened.
    pub fn leave(
        &mut self,
        record: &TickRecord,
        ticket: u64,
        update: Option<&GoalUpdate>,
        events: &[ModuleEvent],
    ) {
        let mut dropped = u64::from(self.records.push(*record).is_err());
        if ticket != 0 {
            dropped += u64::from(self.news.push(News::Taken(ticket)).is_err());
        }
        if let Some(update) = update {
            let has_room = update.state.is_final() || self.news.slots() > NEWS_KEPT;
            let left = has_room && self.news.push(News::Goal(*update)).is_ok();
            dropped += u64::from(!left);
        }
        for event in events {
            dropped += u64::from(self.events.push(*event).is_err());
        }
        self.shared.count(dropped);
    }

    /// Leaves a snapshot; an older one that nobody took is replaced.
    pub fn leave_snapshot(&mut self, snapshot: &Status) {
        self.snapshot.write(*snapshot);
    }

    /// Leaves a view that `fill` writes in place; an older one that nobody took is replaced.
    pub fn leave_view(&mut self, fill: impl FnOnce(&mut View)) {
        fill(self.view.input_buffer_mut());
        self.view.publish();
    }

    /// Whether the loop shall end.
    #[must_use]
    pub fn is_quitting(&self) -> bool {
        self.shared.quit.load(Ordering::Acquire)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::GoalState;

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
    fn what_finds_no_room_is_counted() {
        let (mut tick, supervisor) = ends();
        for _ in 0..RECORDS + 3 {
            tick.leave(&TickRecord::default(), 0, None, &[]);
        }
        assert_eq!(supervisor.dropped(), 3);
        let events = [ModuleEvent::default(); EVENTS + 2];
        tick.leave(&TickRecord::default(), 0, None, &events);
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
            tick.leave(&TickRecord::default(), 0, Some(&progress), &[]);
        }
        // Every order that can wait is taken, and each ends a goal.
        let orders = (ORDERS + STOPS) as u64;
        for ticket in 1..=orders {
            let ended = update(GoalState::FAILED);
            tick.leave(&TickRecord::default(), ticket, Some(&ended), &[]);
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
