//! Publication of the field to observers: frames at a limited rate, and the end of every trial.
//! Robots are served first. Publication does not depend on the presence of observers.

use shm_bus::{Bus, Publisher, writer_epoch};
use shm_schemas::{ArenaTruth, service};
use sim_backend::swarm::{FrameCommands, Swarm};

use crate::failure::Failure;

/// Shortest frame interval, ns: all frames at 60 Hz, fewer at higher rates.
const FRAME_INTERVAL_MIN_NS: u64 = 15_000_000;

/// Publisher of the arena.
pub(super) struct Observers {
    publisher: Publisher<ArenaTruth>,
    arena: Box<ArenaTruth>,
    /// True if the last recorded frame is not published yet.
    is_unpublished: bool,
}

impl Observers {
    pub(super) fn open(bus: &Bus) -> Result<Self, Failure> {
        let mut arena = Box::<ArenaTruth>::default();
        arena.stamp.writer_epoch = writer_epoch();
        Ok(Self {
            publisher: bus.publisher(service::ARENA_TRUTH)?,
            arena,
            is_unpublished: false,
        })
    }

    pub(super) fn have_no_frame(&self) -> bool {
        self.arena.stamp.sequence == 0
    }

    pub(super) fn is_frame_due(&self, captured_ns: u64) -> bool {
        captured_ns >= self.arena.stamp.captured_ns + FRAME_INTERVAL_MIN_NS
    }

    /// Records a frame before its robots move, or the end of a trial.
    pub(super) fn record(&mut self, swarm: &Swarm, answer: FrameCommands<'_>, captured_ns: u64) {
        self.arena.stamp.captured_ns = captured_ns;
        swarm.show(answer, &mut self.arena);
        self.is_unpublished = true;
    }

    pub(super) fn publish(&mut self) -> Result<(), Failure> {
        if std::mem::take(&mut self.is_unpublished) {
            self.publisher.send(&self.arena)?;
            self.arena.stamp.sequence += 1;
        }
        Ok(())
    }

    pub(super) fn connect_readers(&self) -> Result<(), Failure> {
        Ok(self.publisher.connect_readers()?)
    }
}
