//! Stuck element detection: a reading that used to change stays bitwise constant and non-zero.
//!
//! A failed element repeats its last reading and hides force changes. Working ones have noise, at
//! least under pressure. Elements that never changed or read zero are harmless and ignored.
//! Constant frames count only while most other elements change. Earlier pauses extend the permitted
//! pause.

use shm_schemas::capacity::ELEMENTS;

/// Changes required before an element counts as working (design choice: 0.25 s at 1 kHz).
const WORKING_FRAMES: u16 = 250;
/// Constant frames before an element counts as stuck (design choice; fault catalogue F15 requires
/// at most 1000).
const STUCK_FRAMES: u16 = 250;
/// Permitted multiple of the longest earlier pause (design choice: coarse readings pause).
const PAUSE_FACTOR: u16 = 4;
/// Smallest non-zero reading, N (design choice: several times the element noise).
const ZERO_N: f32 = 0.01;

/// Detector for the elements of one fingertip; each bit of a set is one element.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct StuckDetector {
    /// Working elements, and those of them that currently pause.
    working: u64,
    paused: u64,
    /// Frames with a change per element, counted until it is working.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    changes: [u16; ELEMENTS],
    /// Current and longest pause per element, frames.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    pauses: [u16; ELEMENTS],
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    longest_pauses: [u16; ELEMENTS],
}

impl Default for StuckDetector {
    fn default() -> Self {
        Self {
            working: 0,
            paused: 0,
            changes: [0; ELEMENTS],
            pauses: [0; ELEMENTS],
            longest_pauses: [0; ELEMENTS],
        }
    }
}

impl StuckDetector {
    /// Compares two frames, N, and returns the stuck elements among the first `count`.
    pub(super) fn update(
        &mut self,
        before_n: &[[f32; 3]; ELEMENTS],
        now_n: &[[f32; 3]; ELEMENTS],
        count: usize,
    ) -> u64 {
        let moved = moved(&before_n[..count], &now_n[..count]);
        // If most elements pause, none is stuck: the sensor is noise-free or repeated a frame.
        let speaks = 2 * (moved & self.working).count_ones() >= self.working.count_ones();
        for element in each(moved & (self.paused | !self.working)) {
            self.end_pause(element);
        }
        let mut stuck = 0;
        for element in each(self.working & !moved) {
            if !is_zero(&now_n[element]) {
                stuck |= u64::from(self.count_pause(element, speaks)) << element;
            }
        }
        stuck
    }

    /// Counts a pause of an element and returns whether it is stuck.
    fn count_pause(&mut self, element: usize, counts: bool) -> bool {
        self.paused |= 1 << element;
        self.pauses[element] = self.pauses[element].saturating_add(u16::from(counts));
        let allowed = self.longest_pauses[element].saturating_mul(PAUSE_FACTOR);
        self.pauses[element] >= STUCK_FRAMES.max(allowed)
    }

    /// Ends the pause of an element or counts its change.
    fn end_pause(&mut self, element: usize) {
        let rests = core::mem::take(&mut self.pauses[element]);
        self.paused &= !(1 << element);
        if rests < STUCK_FRAMES {
            self.longest_pauses[element] = self.longest_pauses[element].max(rests);
        }
        self.changes[element] = self.changes[element].saturating_add(1);
        self.working |= u64::from(self.changes[element] >= WORKING_FRAMES) << element;
    }
}

/// Returns the elements with a changed reading. Bitwise, because NaN is masked elsewhere.
fn moved(before_n: &[[f32; 3]], now_n: &[[f32; 3]]) -> u64 {
    let elements = before_n.iter().zip(now_n);
    // The last element first: each one shifts the set by one bit.
    elements.rev().fold(0, |set, ([a, b, c], [x, y, z])| {
        let change = |before: &f32, now: &f32| before.to_bits() ^ now.to_bits();
        set << 1 | u64::from(change(a, x) | change(b, y) | change(c, z) != 0)
    })
}

fn each(mut set: u64) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let element = (set != 0).then(|| set.trailing_zeros() as usize);
        set &= set.wrapping_sub(1);
        element
    })
}

fn is_zero(reading_n: &[f32; 3]) -> bool {
    reading_n.iter().all(|axis| axis.abs() < ZERO_N)
}

#[cfg(test)]
mod tests;
