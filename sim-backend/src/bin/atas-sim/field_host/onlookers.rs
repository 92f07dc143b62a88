//! Publication of the field to observers: frames at a limited rate, and the end of every trial.
//! Robots are served first. Publication does not depend on the presence of observers.

use shm_bus::{Bus, Publisher, writer_epoch};
use shm_schemas::{ArenaTruth, service};
use sim_backend::swarm::{Answer, Swarm};

use crate::failure::Failure;

/// Shortest frame interval, ns: all frames at 60 Hz, fewer at higher rates.
const PICTURE_NS: u64 = 15_000_000;

/// Publisher of the arena.
pub(super) struct Onlookers {
    publisher: Publisher<ArenaTruth>,
    arena: Box<ArenaTruth>,
    /// True if the last recorded frame is not published yet.
    has_news: bool,
}

impl Onlookers {
    pub(super) fn open(bus: &Bus) -> Result<Self, Failure> {
        let mut arena = Box::<ArenaTruth>::default();
        arena.stamp.writer_epoch = writer_epoch();
        Ok(Self {
            publisher: bus.publisher(service::ARENA_TRUTH)?,
            arena,
            has_news: false,
        })
    }

    pub(super) fn know_nothing(&self) -> bool {
        self.arena.stamp.sequence == 0
    }

    pub(super) fn are_due(&self, captured_ns: u64) -> bool {
        captured_ns >= self.arena.stamp.captured_ns + PICTURE_NS
    }

    /// Records a frame before its robots move, or the end of a trial.
    pub(super) fn note(&mut self, swarm: &Swarm, answer: Answer<'_>, captured_ns: u64) {
        self.arena.stamp.captured_ns = captured_ns;
        swarm.show(answer, &mut self.arena);
        self.has_news = true;
    }

    pub(super) fn tell(&mut self) -> Result<(), Failure> {
        if std::mem::take(&mut self.has_news) {
            self.publisher.send(&self.arena)?;
            self.arena.stamp.sequence += 1;
        }
        Ok(())
    }

    pub(super) fn greet(&self) -> Result<(), Failure> {
        Ok(self.publisher.connect_readers()?)
    }
}
