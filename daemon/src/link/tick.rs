//! The tick's end: takes orders, leaves what happened, and never waits.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use atas_core::Order;
use rtrb::{Consumer, Producer};
use shm_bus::stop;
use shm_schemas::{Cause, GoalUpdate, ModuleEvent, Reason, Status, View};

use super::{NEWS_KEPT, News, Shared, TickRecord, Ticketed};
use crate::input_log::LogWriter;

/// Silence of the supervisor after which the robot holds, ns: whoever watches over the robot, tells its users and takes
/// their orders is not there. Ours: a hundred rounds.
pub(super) const SILENT_NS: u64 = 500_000_000;

/// The tick's end.
#[derive(Debug)]
pub struct TickEnd {
    pub(super) orders: Consumer<Ticketed>,
    pub(super) stops: Consumer<Ticketed>,
    pub(super) signal: Arc<stop::Signal>,
    /// The stop that this tick takes by the signal.
    pub(super) signalled: Option<u64>,
    pub(super) records: Producer<TickRecord>,
    pub(super) news: Producer<News>,
    pub(super) events: Producer<ModuleEvent>,
    pub(super) snapshot: triple_buffer::Input<Status>,
    pub(super) view: triple_buffer::Input<View>,
    pub(super) input_log: Option<LogWriter>,
    pub(super) shared: Arc<Shared>,
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

    /// How many ticks since the start may pass without anything to do; in lock-step nobody else lets time go on.
    #[must_use]
    pub fn advanced_to(&self) -> u64 {
        self.shared.advanced_to.load(Ordering::Relaxed)
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

    /// Leaves a record and what happened.
    pub fn leave(&mut self, record: &TickRecord, events: &[ModuleEvent]) {
        let mut dropped = u64::from(self.records.push(*record).is_err());
        for event in events {
            dropped += u64::from(self.events.push(*event).is_err());
        }
        self.shared.count(dropped);
    }

    /// Leaves the ticket of the order that was taken (0 if none), and what became of the goal.
    pub fn leave_news(&mut self, ticket: u64, update: Option<&GoalUpdate>) {
        let mut dropped = 0;
        if ticket != 0 {
            dropped += u64::from(self.news.push(News::Taken(ticket)).is_err());
        }
        if let Some(update) = update {
            let has_room = update.state.is_final() || self.news.slots() > NEWS_KEPT;
            let left = has_room && self.news.push(News::Goal(*update)).is_ok();
            dropped += u64::from(!left);
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
