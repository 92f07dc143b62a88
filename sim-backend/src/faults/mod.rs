//! Fault injection: what can go wrong between a sensor and its reader, on purpose and by seed.
//!
//! [`Sensed`] goes in, deliveries come out: usually the same payloads, but lost, late, doubled, spoilt or forged while a
//! [`Fault`] is on. First the content is spoilt (and sealed again, as a faulty sensor would), then bits are flipped after
//! the seal, then the delivery itself suffers. With no fault on, payloads pass untouched.
//!
//! Absent on purpose: faults of processes (kill, stop) and of the machine; a test does those to real processes.

mod channel;
mod spec;
mod spoil;

pub use spec::{Fault, FaultError, FaultInfo, FaultKind, Target};

use robot_model::Side;
use shm_schemas::{HandFrame, JointState};

use crate::random::Random;
use crate::scene::stream;
use crate::world::Sensed;
use channel::Channel;

/// One payload on its way to the readers.
#[derive(Clone, Copy, Debug)]
pub enum Delivery<'a> {
    /// A hand's frame.
    Frame(Side, &'a HandFrame),
    /// The joint feedback.
    Joints(&'a JointState),
}

/// Spoils what passes through it. Equal faults, seed and inputs give equal deliveries.
#[derive(Clone, Debug)]
pub struct Injector {
    hands: [Channel<HandFrame>; 2],
    joints: Channel<JointState>,
}

impl Injector {
    /// An injector of these faults; without any it passes everything on.
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

    /// Passes on what was sensed in a tick (counted from the world's start): frames, left before right, then joints.
    pub fn pass(&mut self, tick: u64, sensed: &Sensed, mut deliver: impl FnMut(Delivery<'_>)) {
        for side in Side::BOTH {
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
