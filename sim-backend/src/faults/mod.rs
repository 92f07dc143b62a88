//! Fault injection between a sensor and its reader, seeded.
//!
//! Input: [`Sensed`]. Output: deliveries. An active [`Fault`] loses, delays, duplicates or alters
//! payloads; without active faults they pass unchanged. Order: content faults (resealed, as by a
//! faulty sensor), bit flips after the seal, delivery faults.
//!
//! Not covered: faults of processes (kill, stop) and of the machine; tests apply those to real
//! processes.

mod channel;
mod inject;
mod spec;

pub use spec::{Fault, FaultError, FaultInfo, FaultKind, Target};

use robot_model::HandSide;
use shm_schemas::{HandFrame, JointState};

use crate::electronics::Sensed;
use crate::random::Random;
use crate::scene::stream;
use channel::Channel;

/// Payload delivered to the readers.
#[derive(Clone, Copy, Debug)]
pub enum Delivery<'a> {
    /// Tactile frame of a hand.
    Frame(HandSide, &'a HandFrame),
    /// Joint feedback.
    Joints(&'a JointState),
}

/// Applies faults to the sensed payloads. Equal faults, seed and inputs give equal deliveries.
#[derive(Clone, Debug)]
pub struct FaultPipeline {
    hands: [Channel<HandFrame>; 2],
    joints: Channel<JointState>,
}

impl FaultPipeline {
    /// Creates a pipeline with these faults.
    #[must_use]
    pub fn new(faults: &[Fault], seed: u64) -> Self {
        let random = |channel: u64| Random::new(seed, stream::FAULTS + channel);
        let of = |target: Target| {
            faults
                .iter()
                .filter(|fault| fault.target.covers(target))
                .copied()
                .collect()
        };
        Self {
            hands: [
                Channel::new(of(Target::Left), random(0)),
                Channel::new(of(Target::Right), random(1)),
            ],
            joints: Channel::new(of(Target::Joints), random(2)),
        }
    }

    /// Delivers the payloads of a tick, counted from the world's start: left frame, right frame,
    /// joints.
    pub fn pass(&mut self, tick: u64, sensed: &Sensed, mut deliver: impl FnMut(Delivery<'_>)) {
        for side in HandSide::BOTH {
            let frame = sensed.frames[side.index()].as_ref();
            self.hands[side.index()]
                .pass(tick, frame, |frame| deliver(Delivery::Frame(side, frame)));
        }
        self.joints.pass(tick, Some(&sensed.joints), |joints| {
            deliver(Delivery::Joints(joints))
        });
    }
}

#[cfg(test)]
mod tests;
