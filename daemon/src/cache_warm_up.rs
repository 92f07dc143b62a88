//! Cache warm-up: steps a copy of the controller before the tick.
//!
//! Between two ticks other work occupies the core's caches; a tick with cold caches takes twice as
//! long. The tick thread wakes up early anyway. It steps a copy of the controller with the expected
//! inputs of the next tick and discards the result.
//!
//! * **In:** the controller and the inputs of the last tick. **Out:** warm caches only.
//! * **Invariants:** the controller is only read. No allocation, no system call. After a panic of
//!   the copy there are no further warm-ups; the tick itself will report the cause.
//!
//! Requests and targets are omitted, because they are rare.

use std::panic::{AssertUnwindSafe, catch_unwind};

use atas_core::{Controller, Inputs, Tick};
use shm_schemas::capacity::HANDS;
use shm_schemas::{HandFrame, JointState};

/// Copy of the controller and inputs for a warm-up.
#[derive(Debug)]
pub struct CacheWarmUp {
    controller: Box<Controller>,
    frames: Box<[HandFrame; HANDS]>,
    has_frame: [bool; HANDS],
    joints: Box<JointState>,
    has_joints: bool,
    has_panicked: bool,
}

impl CacheWarmUp {
    /// A warm-up for copies of this controller.
    #[must_use]
    pub fn new(controller: &Controller) -> Self {
        Self {
            controller: Box::new(controller.clone()),
            frames: Box::default(),
            has_frame: [false; HANDS],
            joints: Box::default(),
            has_joints: false,
            has_panicked: false,
        }
    }

    /// Steps a copy of the controller with inputs like those of the last tick, one period later.
    pub fn run(&mut self, controller: &Controller, last: &Inputs<'_>, period_ns: u64) {
        if self.has_panicked {
            return;
        }
        self.prepare(last, period_ns);
        let inputs = Inputs {
            tick: Tick {
                index: last.tick.index.saturating_add(1),
                now_ns: last.tick.now_ns.saturating_add(period_ns),
            },
            frames: core::array::from_fn(|hand| {
                if self.has_frame[hand] {
                    core::slice::from_ref(&self.frames[hand])
                } else {
                    &[]
                }
            }),
            joints: self.has_joints.then_some(&*self.joints),
            targets: &[],
            request: None,
        };
        let copy = &mut *self.controller;
        copy.clone_from(controller);
        let stepped = catch_unwind(AssertUnwindSafe(|| {
            std::hint::black_box(copy.step(&inputs));
        }));
        self.has_panicked = stepped.is_err();
    }

    /// Advances the stamps of the last tick's newest payloads by one period.
    fn prepare(&mut self, last: &Inputs<'_>, period_ns: u64) {
        for hand in 0..HANDS {
            if let Some(newest) = last.frames[hand].last() {
                let frame = &mut self.frames[hand];
                *frame = *newest;
                frame.stamp.sequence = frame.stamp.sequence.wrapping_add(1);
                frame.stamp.captured_ns = frame.stamp.captured_ns.saturating_add(period_ns);
                frame.seal();
                self.has_frame[hand] = true;
            }
        }
        if let Some(newest) = last.joints {
            *self.joints = *newest;
            let stamp = &mut self.joints.stamp;
            stamp.sequence = stamp.sequence.wrapping_add(1);
            stamp.captured_ns = stamp.captured_ns.saturating_add(period_ns);
            self.joints.seal();
            self.has_joints = true;
        }
    }
}
