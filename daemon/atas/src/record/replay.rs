//! Replay of a recording through the controller.

use super::{RecordError, read_request};
use crate::controller::Controller;
use crate::io::{Inputs, Outputs, TARGETS_PER_TICK};
use crate::tick::Tick;
use shm_schemas::capacity::HANDS;
use shm_schemas::{GraspTarget, HandFrame, Mode, TickInputs};
use zerocopy::IntoBytes;

/// Error that ends a replay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReplayError {
    /// Recording without the start of the run.
    MissingStart {
        /// Missing parts.
        missing: u64,
    },
    /// Recording with a gap.
    Gap {
        /// Tick after the gap.
        tick: u64,
        /// Missing parts.
        missing: u64,
    },
    /// Panic of the controller; afterwards the daemon held without it.
    Panicked {
        /// First tick without the controller.
        tick: u64,
    },
    /// Too many frames or targets in a tick, or contradictory parts.
    Malformed {
        /// Tick index.
        tick: u64,
    },
    /// Invalid request.
    Request {
        /// Tick index.
        tick: u64,
        /// Reason.
        cause: RecordError,
    },
}

impl core::fmt::Display for ReplayError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::MissingStart { missing } => write!(
                f,
                "replay failed: the first {missing} parts of the run are not recorded; start the \
                 recorder before the daemon"
            ),
            Self::Gap { tick, missing } => {
                write!(
                    f,
                    "replay stopped at tick {tick}: {missing} parts before it are lost"
                )
            }
            Self::Panicked { tick } => {
                write!(
                    f,
                    "replay stopped: the controller panicked in tick {tick}; later ticks of the \
                     daemon cannot be replayed"
                )
            }
            Self::Malformed { tick } => {
                write!(
                    f,
                    "replay stopped at tick {tick}: its parts contradict each other; check whether \
                     the recording is damaged"
                )
            }
            Self::Request { tick, cause: why } => write!(f, "tick {tick}: {why}"),
        }
    }
}

impl core::error::Error for ReplayError {}

/// One replayed tick.
#[derive(Clone, Copy, Debug)]
pub struct Replayed<'a> {
    /// Outputs of the replay.
    pub outputs: &'a Outputs,
    /// True if the replayed command equals the recorded one bit for bit.
    pub is_equal: bool,
}

/// Controller driven by recorded inputs.
#[derive(Debug)]
pub struct Replay<F> {
    controller: Controller,
    frames: [F; HANDS],
    counts: [usize; HANDS],
    targets: [GraspTarget; TARGETS_PER_TICK],
    target_count: usize,
    next_sequence: u64,
    next_part: u32,
}

impl<F: AsRef<[HandFrame]> + AsMut<[HandFrame]>> Replay<F> {
    /// Creates a replay of a [`super::read_origin`] controller, with storage for one tick's frames
    /// per hand; 64 suffice for any recording.
    #[must_use]
    pub fn new(controller: Controller, frames: [F; HANDS]) -> Self {
        Self::resume(controller, 0, frames)
    }

    /// Continues from a [`Replay::state`].
    #[must_use]
    pub fn resume(controller: Controller, next_sequence: u64, frames: [F; HANDS]) -> Self {
        Self {
            controller,
            frames,
            counts: [0; HANDS],
            targets: [GraspTarget::default(); TARGETS_PER_TICK],
            target_count: 0,
            next_sequence,
            next_part: 0,
        }
    }

    /// Returns the controller and the next sequence number; `None` within a tick.
    #[must_use]
    pub fn state(&self) -> Option<(&Controller, u64)> {
        (self.next_part == 0).then_some((&self.controller, self.next_sequence))
    }

    /// Processes the next part; runs a complete tick and compares its command.
    ///
    /// # Errors
    /// [`ReplayError`]; the replay cannot continue.
    pub fn feed(&mut self, part: &TickInputs) -> Result<Option<Replayed<'_>>, ReplayError> {
        self.check(part)?;
        self.collect(part)?;
        if part.part + 1 < part.parts {
            self.next_part = part.part + 1;
            return Ok(None);
        }
        let order = read_request(&part.order).map_err(|why| ReplayError::Request {
            tick: part.tick,
            cause: why,
        })?;
        let [left, right] = &self.frames;
        let outputs = self.controller.step(&Inputs {
            tick: Tick {
                index: part.tick,
                now_ns: part.stamp.captured_ns,
            },
            frames: [
                &left.as_ref()[..self.counts[0]],
                &right.as_ref()[..self.counts[1]],
            ],
            joints: (part.has_joints != 0).then_some(&part.joints),
            targets: &self.targets[..self.target_count],
            request: order.as_ref(),
        });
        (self.counts, self.target_count, self.next_part) = ([0; HANDS], 0, 0);
        Ok(Some(Replayed {
            is_equal: outputs.command.as_bytes() == part.command.as_bytes(),
            outputs,
        }))
    }

    fn check(&mut self, part: &TickInputs) -> Result<(), ReplayError> {
        let (expected, tick) = (self.next_sequence, part.tick);
        let missing = part.stamp.sequence.wrapping_sub(expected);
        match (expected, missing) {
            (_, 0) => {}
            (0, missing) => return Err(ReplayError::MissingStart { missing }),
            (_, missing) => return Err(ReplayError::Gap { tick, missing }),
        }
        if part.part != self.next_part || part.parts <= part.part {
            return Err(ReplayError::Malformed { tick });
        }
        if part.command.mode == Mode::FAULT {
            return Err(ReplayError::Panicked { tick });
        }
        self.next_sequence += 1;
        Ok(())
    }

    fn collect(&mut self, part: &TickInputs) -> Result<(), ReplayError> {
        for hand in 0..HANDS {
            if part.has_frame[hand] == 0 {
                continue;
            }
            let count = &mut self.counts[hand];
            let slot = self.frames[hand].as_mut().get_mut(*count);
            *slot.ok_or(ReplayError::Malformed { tick: part.tick })? = part.frames[hand];
            *count += 1;
        }
        if part.has_target != 0 {
            let slot = self.targets.get_mut(self.target_count);
            *slot.ok_or(ReplayError::Malformed { tick: part.tick })? = part.target;
            self.target_count += 1;
        }
        Ok(())
    }
}
