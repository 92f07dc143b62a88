//! Content faults of a payload.

use shm_schemas::capacity::ELEMENTS;
use shm_schemas::{HandFrame, JointState, Stamp};
use zerocopy::IntoBytes;

use super::spec::{Fault, FaultKind};
use crate::clock::TICK_NS;

/// Bits that a forged writer epoch flips.
const EPOCH_MASK: u64 = 0x5a5a_5a5a_5a5a_5a5a;

/// Denormal reading, N.
const DENORMAL_N: f32 = 1e-40;

/// Payload that accepts content faults.
pub(super) trait Payload: Copy + Default {
    fn stamp(&mut self) -> &mut Stamp;
    fn as_mut_bytes(&mut self) -> &mut [u8];
    /// Seals the payload, if its type has a seal.
    fn seal(&mut self);
    /// Replaces the readings by those of an earlier payload.
    fn replace_readings(&mut self, frozen: &Self);
    /// Applies a fault of the readings; `on_s` is the time since the fault began.
    fn apply_reading_fault(&mut self, fault: &Fault, on_s: f64, onset: &Self);
}

/// Applies content faults to one stream.
#[derive(Clone, Debug, Default)]
pub(super) struct FaultInjector<T> {
    /// Last payload sent; source of frozen readings.
    last: Option<T>,
    /// Sequence number at which the forged epoch began.
    epoch_from: Option<u64>,
}

impl<T: Payload> FaultInjector<T> {
    pub(super) fn inject(&mut self, fault: &Fault, tick: u64, payload: &mut T) {
        let value = fault.value;
        match fault.kind {
            FaultKind::Freeze => {
                if let Some(last) = &self.last {
                    payload.replace_readings(last);
                }
            }
            FaultKind::Future => payload.stamp().captured_ns += (value * 1e9) as u64,
            FaultKind::Stale => {
                let stamp = payload.stamp();
                stamp.captured_ns = stamp.captured_ns.saturating_sub((value * 1e9) as u64);
            }
            FaultKind::Epoch => {
                let stamp = payload.stamp();
                let from = *self.epoch_from.get_or_insert(stamp.sequence);
                stamp.writer_epoch ^= EPOCH_MASK;
                stamp.sequence = stamp.sequence.wrapping_sub(from);
            }
            FaultKind::Wrap => {
                let stamp = payload.stamp();
                stamp.sequence = stamp.sequence.wrapping_sub(value as u64);
            }
            _ => {
                let on_s = ((tick - fault.first_tick) * TICK_NS) as f64 * 1e-9;
                let onset = self.last.unwrap_or(*payload);
                payload.apply_reading_fault(fault, on_s, &onset);
            }
        }
    }

    pub(super) fn remember(&mut self, payload: &T) {
        self.last = Some(*payload);
    }
}

impl Payload for HandFrame {
    fn stamp(&mut self) -> &mut Stamp {
        &mut self.stamp
    }

    fn as_mut_bytes(&mut self) -> &mut [u8] {
        IntoBytes::as_mut_bytes(self)
    }

    fn seal(&mut self) {
        Self::seal(self);
    }

    fn replace_readings(&mut self, frozen: &Self) {
        self.force_n = frozen.force_n;
    }

    fn apply_reading_fault(&mut self, fault: &Fault, on_s: f64, onset: &Self) {
        let fingers = self.finger_count as usize;
        let element = fault.value as usize;
        match fault.kind {
            FaultKind::Stick => self.force_n[0][element] = onset.force_n[0][element],
            FaultKind::Nan => self.force_n[0][..element].fill([f32::NAN; 3]),
            FaultKind::Huge => self.force_n[0][0] = [fault.value as f32; 3],
            FaultKind::Foreign => self.hand.0 = 1 - self.hand.0,
            FaultKind::Denormal => self.force_n[..fingers].fill([[DENORMAL_N; 3]; ELEMENTS]),
            FaultKind::Bias => each_normal(self, |f_n| *f_n += (fault.value * on_s) as f32),
            FaultKind::Saturate => each_normal(self, |f_n| *f_n = fault.value as f32),
            _ => {}
        }
    }
}

/// Applies `change` to the normal force of every valid element.
fn each_normal(frame: &mut HandFrame, mut change: impl FnMut(&mut f32)) {
    for (mask, finger) in frame.valid_mask.iter().zip(&mut frame.force_n) {
        let valid = finger
            .iter_mut()
            .enumerate()
            .filter(|(element, _)| mask >> element & 1 == 1);
        valid.for_each(|(_, reading)| change(&mut reading[0]));
    }
}

impl Payload for JointState {
    fn stamp(&mut self) -> &mut Stamp {
        &mut self.stamp
    }

    fn as_mut_bytes(&mut self) -> &mut [u8] {
        IntoBytes::as_mut_bytes(self)
    }

    fn seal(&mut self) {
        Self::seal(self);
    }

    fn replace_readings(&mut self, frozen: &Self) {
        *self = Self {
            stamp: self.stamp,
            ..*frozen
        };
    }

    fn apply_reading_fault(&mut self, fault: &Fault, _on_s: f64, _onset: &Self) {
        let joints = self.joint_count as usize;
        match fault.kind {
            FaultKind::Nan => {
                self.position[..joints.min(fault.value as usize)].fill(f64::NAN);
            }
            FaultKind::Huge => self.position[0] = fault.value,
            FaultKind::Jump => self.position[..joints]
                .iter_mut()
                .for_each(|q| *q += fault.value),
            _ => {}
        }
    }
}
