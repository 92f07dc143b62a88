//! Stuck element detection: a reading that used to change stays bitwise constant and non-zero.
//!
//! A failed element repeats its last reading and hides force changes. Working ones have noise, at
//! least under pressure. Elements that never changed or read zero are harmless and ignored.
//! Constant frames count only while most other elements change. Earlier pauses extend the permitted
//! pause.

use shm_schemas::capacity::ELEMENTS;
use wide::u32x8;

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
        let moved = moved(before_n, now_n, count);
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

/// Elements whose axes fill whole SIMD vectors.
const BLOCK: usize = 16;
/// Axes per SIMD vector.
const LANES: usize = 8;

/// Returns the elements among the first `count` with a changed reading. Bitwise, because NaN is
/// masked elsewhere.
fn moved(before_n: &[[f32; 3]; ELEMENTS], now_n: &[[f32; 3]; ELEMENTS], count: usize) -> u64 {
    const { assert!(ELEMENTS == 64 && (3 * BLOCK).is_multiple_of(LANES)) };
    let (before_n, now_n) = (
        before_n.as_chunks::<BLOCK>().0,
        now_n.as_chunks::<BLOCK>().0,
    );
    let blocks = before_n.iter().zip(now_n).take(count.div_ceil(BLOCK));
    let set = blocks
        .enumerate()
        .fold(0, |set, (block, (before_n, now_n))| {
            set | any_of_three(changed(before_n.as_flattened(), now_n.as_flattened()))
                << (BLOCK * block)
        });
    set & u64::MAX >> (ELEMENTS - count)
}

/// Returns the set of changed axes of one block.
fn changed(before_n: &[f32], now_n: &[f32]) -> u64 {
    let lanes = |axes: &[f32; LANES]| u32x8::new(axes.map(f32::to_bits));
    let vectors = before_n.as_chunks().0.iter().zip(now_n.as_chunks().0);
    let same = vectors
        .enumerate()
        .fold(0, |set, (index, (before_n, now_n))| {
            let same = lanes(before_n).simd_eq(lanes(now_n)).to_bitmask();
            set | u64::from(same) << (LANES * index)
        });
    !same & u64::MAX >> (64 - 3 * BLOCK)
}

/// Returns the set of elements with a set bit among their three axes: bits 0, 3, 6 … move to bits
/// 0, 1, 2 …
fn any_of_three(axes: u64) -> u64 {
    let set = (axes | axes >> 1 | axes >> 2) & 0x2492_4924_9249;
    let set = (set | set >> 2) & 0x0c30_c30c_30c3;
    let set = (set | set >> 4) & 0x00f0_0f00_f00f;
    let set = (set | set >> 8) & 0xff00_00ff;
    (set | set >> 16) & 0xffff
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
