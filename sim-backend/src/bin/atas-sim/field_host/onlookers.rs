//! What onlookers are told of the field: as many frames as a picture shows, and how every trial ended. Robots are asked first, so
//! that none of them waits for it, and it is told whether or not anybody looks.

use shm_bus::{Bus, Publisher, writer_epoch};
use shm_schemas::{ArenaTruth, service};
use sim_backend::swarm::{Answer, Swarm};

use crate::failure::Failure;

/// Time from one told frame to the next at least, ns: 60 frames a second are all told, of more as many as a screen shows.
const PICTURE_NS: u64 = 15_000_000;

/// The arena on the bus.
pub(super) struct Onlookers {
    publisher: Publisher<ArenaTruth>,
    arena: Box<ArenaTruth>,
    /// Whether they have not been told of what was noted last.
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

    /// Whether they have not been told of any frame.
    pub(super) fn know_nothing(&self) -> bool {
        self.arena.stamp.sequence == 0
    }

    /// Whether it is time for another picture.
    pub(super) fn are_due(&self, captured_ns: u64) -> bool {
        captured_ns >= self.arena.stamp.captured_ns + PICTURE_NS
    }

    /// Notes the frame of this time before its robots move, or how its trial ended.
    pub(super) fn note(&mut self, swarm: &Swarm, answer: Answer<'_>, captured_ns: u64) {
        self.arena.stamp.captured_ns = captured_ns;
        swarm.show(answer, &mut self.arena);
        self.has_news = true;
    }

    /// Tells what was noted.
    pub(super) fn tell(&mut self) -> Result<(), Failure> {
        if std::mem::take(&mut self.has_news) {
            self.publisher.send(&self.arena)?;
            self.arena.stamp.sequence += 1;
        }
        Ok(())
    }

    /// Lets those who came late have the newest frame.
    pub(super) fn greet(&self) -> Result<(), Failure> {
        Ok(self.publisher.connect_readers()?)
    }
}
