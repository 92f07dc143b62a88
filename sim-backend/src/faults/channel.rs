//! Fault channel of one payload stream: applies content faults, then delivery faults.

use std::collections::VecDeque;

use super::inject::{FaultInjector, Payload};
use super::spec::{Fault, FaultKind};
use crate::random::Random;

/// Capacity of delayed payloads; more are lost. Equals the longest delay at 1 kHz.
const DELAYED_MAX: usize = 1024;

#[derive(Clone, Debug)]
pub(super) struct Channel<T> {
    faults: Vec<Fault>,
    random: Random,
    injector: FaultInjector<T>,
    /// Delayed payloads with their due tick, oldest first.
    delayed: VecDeque<(u64, T)>,
}

impl<T: Payload> Channel<T> {
    pub(super) fn new(faults: Vec<Fault>, random: Random) -> Self {
        let held = VecDeque::with_capacity(if faults.is_empty() { 0 } else { DELAYED_MAX });
        Self {
            faults,
            random,
            injector: FaultInjector::default(),
            delayed: held,
        }
    }

    /// Delivers the payloads due in this tick: delayed ones first (oldest first), then the new one.
    pub(super) fn pass(&mut self, tick: u64, sensed: Option<&T>, mut deliver: impl FnMut(&T)) {
        if self.faults.is_empty() {
            sensed.into_iter().for_each(deliver);
            return;
        }
        let fresh = sensed.map(|payload| self.with_faults(tick, payload));
        // One pass through the queue: due payloads leave, the rest keep their order.
        for _ in 0..self.delayed.len() {
            if let Some((due, payload)) = self.delayed.pop_front() {
                if due <= tick {
                    deliver(&payload)
                } else {
                    self.delayed.push_back((due, payload))
                }
            }
        }
        if let Some(payload) = fresh {
            self.send(tick, payload, deliver);
        }
    }

    fn with_faults(&mut self, tick: u64, payload: &T) -> T {
        let mut payload = *payload;
        for fault in self.faults.iter().filter(|fault| fault.is_active(tick)) {
            self.injector.inject(fault, tick, &mut payload);
        }
        payload.seal();
        for fault in self.faults.iter().filter(|fault| fault.is_active(tick)) {
            if fault.kind == FaultKind::Corrupt && self.random.chance(fault.value) {
                let bytes = payload.as_mut_bytes();
                let bit = (self.random.bits() % (8 * bytes.len() as u64)) as usize;
                bytes[bit / 8] ^= 1 << (bit % 8);
            }
        }
        self.injector.remember(&payload);
        payload
    }

    /// Delivers a payload now, later, several times or never.
    fn send(&mut self, tick: u64, payload: T, mut deliver: impl FnMut(&T)) {
        let (mut due, mut copies) = (tick, 1);
        for fault in self.faults.iter().filter(|fault| fault.is_active(tick)) {
            match fault.kind {
                FaultKind::Drop if self.random.chance(fault.value) => copies = 0,
                FaultKind::Duplicate => copies *= 2,
                FaultKind::Delay => due += fault.value as u64,
                FaultKind::Reorder if tick.is_multiple_of(2) => due += 2,
                FaultKind::Burst => due = due.next_multiple_of(fault.value as u64),
                _ => {}
            }
        }
        for _ in 0..copies {
            if due == tick {
                deliver(&payload);
            } else if self.delayed.len() < DELAYED_MAX {
                self.delayed.push_back((due, payload));
            }
        }
    }
}
