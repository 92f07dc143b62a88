//! Virtual time of the world; independent of the machine's clock.

use shm_schemas::Stamp;

/// Tick length, ns.
pub const TICK_NS: u64 = 1_000_000;
/// Length of a tick, s: [`TICK_NS`].
pub(crate) const TICK_S: f64 = 1e-3;
/// Substeps per tick. 500 µs is unstable for light objects, 125 µs gives the same results (tactile
/// design).
pub(crate) const SUBSTEPS: usize = 4;
pub(crate) const SUBSTEP_S: f64 = TICK_S / SUBSTEPS as f64;
/// Virtual time of a new world, ns. One second, so that look-back windows never underflow.
pub const START_NS: u64 = 1_000_000_000;

/// Virtual time, tick count and writer epoch.
#[derive(Clone, Debug)]
pub(crate) struct Clock {
    pub(crate) now_ns: u64,
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

    pub(crate) fn advance(&mut self) {
        self.now_ns += TICK_NS;
        self.tick += 1;
    }

    /// Returns the stamp of a payload written now.
    pub(crate) fn stamp(&self, sequence: u64) -> Stamp {
        Stamp {
            sequence,
            captured_ns: self.now_ns,
            writer_epoch: self.writer_epoch,
        }
    }
}
