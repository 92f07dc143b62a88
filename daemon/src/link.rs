//! The link between the tick and the supervisor: orders one way, records the other. Bounded, lock-free, never waiting.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use atas_core::Order;
use crossbeam::queue::ArrayQueue;
use robot_model::ROBOT_JOINTS;
use shm_schemas::{GoalUpdate, ModuleEvent, Status, TickReport};

use crate::input_log::InputLog;

/// Orders that wait; a goal that finds the queue full is refused as BUSY. Ours: the tick takes a thousand a second.
const ORDERS: usize = 32;
/// Stops that wait beside them, so that no flood of goals can hold up a stop.
const STOPS: usize = 4;
/// Ticks that the supervisor may fall behind before records are dropped: 1 s at 1 kHz.
const RECORDS: usize = 1024;
/// Events that wait.
const EVENTS: usize = 1024;

/// What one tick leaves behind. Fixed size, no pointers.
#[derive(Clone, Copy, Debug, Default)]
pub struct TickRecord {
    /// The report, with its timings.
    pub report: TickReport,
    /// News of the goal.
    pub goal_update: Option<GoalUpdate>,
    /// Ticket of the order that was taken, 0 if none.
    pub ticket: u64,
    /// From wake-up to the published command, ns.
    pub body_ns: u32,
    /// Age of the newest frame of any hand, ns; `u64::MAX` if there never was one.
    pub frame_age_ns: u64,
    /// Whether every commanded velocity is zero.
    pub at_rest: bool,
    /// Commanded positions, rad, if there are any.
    pub commanded_rad: Option<[f64; ROBOT_JOINTS]>,
    /// Calls to the bus that failed so far.
    pub bus_failures: u64,
    /// Whether the ticks are locked to the frames.
    pub phase_locked: bool,
}

/// An order with the number by which its effect is recognised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ticketed {
    /// From 1.
    pub ticket: u64,
    /// The order.
    pub order: Order,
}

/// The link.
#[derive(Debug)]
pub struct Link {
    orders: ArrayQueue<Ticketed>,
    stops: ArrayQueue<Ticketed>,
    tickets: AtomicU64,
    records: ArrayQueue<TickRecord>,
    events: ArrayQueue<ModuleEvent>,
    snapshot: ArrayQueue<Status>,
    input_log: Option<InputLog>,
    dropped: AtomicU64,
    quit: AtomicBool,
}

impl Default for Link {
    fn default() -> Self {
        Self {
            orders: ArrayQueue::new(ORDERS),
            stops: ArrayQueue::new(STOPS),
            tickets: AtomicU64::new(0),
            records: ArrayQueue::new(RECORDS),
            events: ArrayQueue::new(EVENTS),
            snapshot: ArrayQueue::new(1),
            input_log: None,
            dropped: AtomicU64::new(0),
            quit: AtomicBool::new(false),
        }
    }
}

impl Link {
    /// A link with a input_log for a recorder.
    #[must_use]
    pub fn recording() -> Self {
        Self {
            input_log: Some(InputLog::default()),
            ..Self::default()
        }
    }

    /// Whether another tick can be recorded without hurry; always, if recording is switched off.
    #[must_use]
    pub fn has_room(&self) -> bool {
        self.input_log.as_ref().is_none_or(InputLog::has_room)
    }

    /// The input_log, if recording is switched on.
    #[must_use]
    pub fn input_log(&self) -> Option<&InputLog> {
        self.input_log.as_ref()
    }
}

/// The supervisor's end.
impl Link {
    /// Queues an order; its ticket comes back in the record of the tick that takes it. `None` if the queue is full.
    #[must_use]
    pub fn order(&self, order: Order) -> Option<u64> {
        let queue = if matches!(order, Order::Stop(_)) {
            &self.stops
        } else {
            &self.orders
        };
        let ticket = self.tickets.fetch_add(1, Ordering::Relaxed) + 1;
        queue.push(Ticketed { ticket, order }).ok().map(|()| ticket)
    }

    /// The next record.
    #[must_use]
    pub fn next_record(&self) -> Option<TickRecord> {
        self.records.pop()
    }

    /// The next event.
    #[must_use]
    pub fn next_event(&self) -> Option<ModuleEvent> {
        self.events.pop()
    }

    /// The newest snapshot, if there is one since the last call.
    #[must_use]
    pub fn newest_snapshot(&self) -> Option<Status> {
        self.snapshot.pop()
    }

    /// Records, events and parts of the input_log dropped because the supervisor did not come round.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        let parts = self.input_log.as_ref().map_or(0, InputLog::dropped);
        self.dropped.load(Ordering::Relaxed) + parts
    }

    /// Ends the tick loop before its next tick.
    pub fn quit(&self) {
        self.quit.store(true, Ordering::Release);
    }
}

/// The tick's end.
impl Link {
    /// The order for this tick: a stop first, then the others in their order, unless the world still settles.
    #[must_use]
    pub fn take_order(&self, settling: bool) -> Option<Ticketed> {
        self.stops
            .pop()
            .or_else(|| if settling { None } else { self.orders.pop() })
    }

    /// Whether an order waits.
    #[must_use]
    pub fn has_orders(&self) -> bool {
        !self.stops.is_empty() || !self.orders.is_empty()
    }

    /// Leaves a record and its events.
    pub fn leave(&self, record: &TickRecord, events: &[ModuleEvent]) {
        self.count(self.records.push(*record).is_err());
        for event in events {
            self.count(self.events.push(*event).is_err());
        }
    }

    /// Leaves a snapshot; an older one that nobody took is replaced.
    pub fn leave_snapshot(&self, snapshot: &Status) {
        let _replaced = self.snapshot.force_push(*snapshot);
    }

    /// Whether the loop shall end.
    #[must_use]
    pub fn is_quitting(&self) -> bool {
        self.quit.load(Ordering::Acquire)
    }

    fn count(&self, dropped: bool) {
        if dropped {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::{Cause, Reason};

    #[test]
    fn a_stop_overtakes_a_flood_of_orders_and_needs_no_settling() {
        let link = Link::default();
        let queued = (0..100)
            .filter(|_| link.order(Order::Recover).is_some())
            .count();
        assert_eq!(queued, ORDERS);
        let stop = Order::Stop(Reason::of(Cause::ESTOP));
        let ticket = link.order(stop);
        assert!(ticket.is_some());
        let taken = link.take_order(true).expect("the stop");
        assert_eq!((Some(taken.ticket), taken.order), (ticket, stop));
        assert_eq!(link.take_order(true), None);
        assert_eq!(link.take_order(false).map(|t| t.ticket), Some(1));
    }

    #[test]
    fn what_finds_no_room_is_counted() {
        let link = Link::default();
        for _ in 0..RECORDS + 3 {
            link.leave(&TickRecord::default(), &[]);
        }
        assert_eq!(link.dropped(), 3);
        link.leave(
            &TickRecord::default(),
            &[ModuleEvent::default(); EVENTS + 2],
        );
        assert_eq!(link.dropped(), 3 + 1 + 2);
    }
}
