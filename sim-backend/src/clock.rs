//! The world's own time: nothing here reads the machine's clock.

use shm_schemas::Stamp;

/// Length of a tick, ns.
pub const TICK_NS: u64 = 1_000_000;
/// Virtual time of a new world, ns: one second, so that ages and windows that look back never pass below zero.
pub const START_NS: u64 = 1_000_000_000;

/// Where the world is in time, and under which epoch it writes.
#[derive(Clone, Debug)]
pub(crate) struct Clock {
    pub(crate) now_ns: u64,
    /// Ticks simulated so far.
    pub(crate) tick: u64,
    pub(crate) writer_epoch: u64,
}

impl Clock {
    pub(crate) fn new(writer_epoch: u64) -> Self {
        Self {
            now_ns: START_NS,
            tick: 0,
            writer_epoch,
        }
    }

    /// Goes one tick on.
    pub(crate) fn advance(&mut self) {
        self.now_ns += TICK_NS;
        self.tick += 1;
    }

    /// The stamp of a payload written now.
    pub(crate) fn stamp(&self, sequence: u64) -> Stamp {
        Stamp {
            sequence,
            captured_ns: self.now_ns,
            writer_epoch: self.writer_epoch,
        }
    }
}
